"""What became of what people said of a trial: figures and findings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from ..data import Finding, make_finding
from ..data.edit_outcomes import Applied, entry_outcome
from ..data.edits import Claim, Verdict
from ..io.edits_jsonl import Fault


def edit_figures(applied: Sequence[Applied]) -> list[dict[str, Any]]:
    """Each edit and its outcome, as plain data."""
    return [
        {
            "entry": one.entry,
            "edit": one.edit.kind,
            "markers": _markers(one),
            "frames": list(_frames(one)),
            "outcome": one.outcome,
            "share": one.share,
            "samples": one.samples,
            "reason": one.reason,
        }
        for one in applied
    ]


def edit_findings(applied: Sequence[Applied], faults: Sequence[Fault]) -> Iterator[Finding]:
    """What needs attention of them, and how many stand."""
    if faults:
        lines = [f"{fault.line}: {fault.text}" for fault in faults]
        yield make_finding("edits_unreadable", lines=len(faults), lines_list=lines)
    for outcome, kind in (("orphan", "edits_orphaned"), ("thin", "edits_thin")):
        some = [one for one in applied if one.outcome == outcome]
        if some:
            yield make_finding(
                kind,
                markers=dict.fromkeys(name for one in some for name in _markers(one)),
                frames=[_frames(one) for one in some],
                edits=len(some),
                entries_list=[f"{one.entry}: {one.reason}" for one in some],
            )
    if applied:
        count = Counter(entry_outcome([one for one in applied if one.entry == k]) for k in {a.entry for a in applied})
        stand = count["held"] + count["thin"]
        gone = {"moot": count["moot"], "overruled": count["overruled"]}
        yield Finding("edits_applied", "info", "edit", values={"entries": count.total(), "held": stand, **gone})


def _markers(one: Applied) -> list[str]:
    """Names that an edit is about."""
    name = one.edit.name if isinstance(one.edit, Claim) else getattr(one.edit, "marker", None)
    return [name] if isinstance(name, str) else []


def _frames(one: Applied) -> tuple[int, int]:
    """First and last frame that an edit is about, numbers in the recording; 0, 0 of one of the whole trial."""
    edit = one.edit
    if isinstance(edit, Claim | Verdict):
        stretches = (edit.where,) if isinstance(edit, Claim) else edit.where
        frames = [w.frame for stretch in stretches for w in stretch.witnesses] or [0]
        return min(frames), max(frames)
    first = getattr(edit, "first", getattr(edit, "frame", 0))
    return first, getattr(edit, "last", first)
