"""What was said of a trial, and how two versions of it differ."""

from __future__ import annotations

from ...data import KinemarkError
from ...data.edit_outcomes import Applied, entry_outcome
from ...data.edits import Entry, Signed, counting
from ...edit import Edited
from ...edit.difference import difference
from ...engine.editing.journal import hash_of_entry
from ...report.words import edit_text, entry_text
from .acts import outcome
from .desk import OpenDocument
from .edit_messages import Difference, Fault, FillChange, History, HistoryRow, IdentityChange, SampleChange
from .header import finite


def history(document: OpenDocument) -> History:
    """Every entry with its outcome now."""
    text, counts = document.text, {entry.id for entry in counting(document.text.entries)}
    applied: dict[int, list[Applied]] = {}
    for one in document.now.applied:
        applied.setdefault(one.entry, []).append(one)
    rows = [_row(entry, applied.get(entry.id, []), entry.id in counts) for entry in text.entries]
    faults = [Fault(line=fault.line, words=fault.text) for fault in text.faults]
    return History(entries=rows, faults=faults, head=text.head)


def _row(entry: Entry, applied: list[Applied], counts: bool) -> HistoryRow:
    return HistoryRow.like(
        entry,
        hash=hash_of_entry(entry),
        kinds=[edit.kind for edit in entry.edits],
        words="; ".join(map(edit_text, entry.edits)),
        short=entry_text(entry.edits),
        undone=not counts,
        signed=any(isinstance(edit, Signed) for edit in entry.edits),
        outcome=entry_outcome(applied) if applied else None,
        outcomes=[outcome(one) for one in applied],
    )


def versions_apart(document: OpenDocument, of: int, other: int) -> Difference:
    """How the version up to an entry differs from the one up to another; 0 is before all edits.

    Raises:
        KinemarkError: there is no such entry.
    """
    before, after = (_version(document, number) for number in (of, other))
    found = difference(before.trajectories, after.trajectories)
    return Difference(
        of=of,
        other=other,
        identities=[IdentityChange(**one._asdict()) for one in found.renamed],
        samples=[SampleChange(**one._asdict() | {"max_mm": finite(one.max_mm)}) for one in found.changed],
        fills=_refilled(before, after),
    )


def _refilled(before: Edited, after: Edited) -> list[FillChange]:
    """Gaps for which another way to fill them was chosen; the last word counts."""
    old, new = ({(one.marker, one.first, one.last): one.method for one in each.choices} for each in (before, after))
    changed = (gap for gap in {**old, **new} if old.get(gap) != new.get(gap))
    return [
        FillChange(marker=gap[0], first=gap[1], last=gap[2], before=old.get(gap), after=new.get(gap)) for gap in changed
    ]


def _version(document: OpenDocument, number: int) -> Edited:
    if number == 0:
        return document.editing.at("")
    entry = next((entry for entry in document.text.entries if entry.id == number), None)
    if entry is None:
        raise KinemarkError(f"There is no entry {number} in the journal.")
    return document.editing.at(hash_of_entry(entry))
