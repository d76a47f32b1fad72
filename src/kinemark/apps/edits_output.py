"""What the commands of edits and problems read and print: frames, places in images, entries and what became of them."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ..data import KinemarkError
from ..data.edit_outcomes import Applied
from ..data.edits import Edit, Entry
from ..data.problems import ASK_ABOVE, Problem, Problems
from .output import print_result

if TYPE_CHECKING:  # these take long to import, and --help does without
    from ..engine.editing.editing import Said
    from ..io.edits_jsonl import JournalText


def span_of(text: str | None) -> tuple[int | None, int | None]:
    """First and last frame of "A-B", "A-", "-B" or "A"."""
    if text is None:
        return None, None
    first, dash, last = text.strip().partition("-")
    try:
        ends = int(first) if first else None, (int(last) if last else None) if dash else int(first)
    except ValueError as error:
        raise KinemarkError(f"{text!r} are no frames. Give them as 120-180, 120- or -180.") from error
    if ends == (None, None):
        raise KinemarkError(f"{text!r} are no frames. Give them as 120-180, 120- or -180.")
    return ends


def closed_span(text: str) -> tuple[int, int]:
    """First and last frame of "A-B" or "A"."""
    first, last = span_of(text)
    if first is None or last is None:
        raise KinemarkError(f"{text!r} has no end. Give both, as 120-180.")
    return first, last


def image_of(text: str) -> tuple[str, tuple[float, float]]:
    """Camera and place of "cam1:312.5,204"."""
    camera, _, place = text.rpartition(":")
    try:
        u, v = map(float, place.split(","))
    except ValueError as error:
        raise KinemarkError(f"{text!r} is no place in an image. Give it as cam1:312.5,204.") from error
    return camera, (u, v)


def entry_line(entry: Entry) -> str:
    """An entry in a line."""
    from ..report.words import entry_text

    why = f"  “{entry.why}”" if entry.why else ""
    return f"{entry.id:4d}  {entry.at[:19].replace('T', ' ')}  {entry.by}  {entry_text(entry.edits)}{why}"


def applied_text(one: Applied) -> str:
    """What became of an edit, in a line."""
    from ..report.words import edit_text

    why = f" ({one.reason})" if one.reason else ""
    return f"{one.entry:4d}  {one.outcome:9s}  {edit_text(one.edit)}{why}"


def fault_lines(text: JournalText) -> list[str]:
    """What is wrong with a journal, a line each."""
    return [f"line {fault.line} of the journal does not count: {fault.text}" for fault in text.faults]


def entry_figures(entry: Entry) -> dict[str, Any]:
    """For a machine."""
    from ..report.words import edit_text

    figures = {name: getattr(entry, name) for name in ("id", "at", "by", "why", "version")}
    return figures | {"edits": [asdict(edit) for edit in entry.edits], "text": [edit_text(e) for e in entry.edits]}


def applied_figures(one: Applied) -> dict[str, Any]:
    """What became of an edit, for a machine."""
    from ..report.words import edit_text

    figures = {name: getattr(one, name) for name in ("entry", "outcome", "share", "samples", "reason")}
    return figures | {"edit": one.edit.kind, "text": edit_text(one.edit)}


def print_entry(entry: Entry, json: bool) -> None:
    """Print an entry, for a machine where `json`."""
    print_result(entry_figures(entry) if json else entry_line(entry))


def print_said(said: Said, json: bool) -> None:
    """An entry and what came of it."""
    if json:
        print_result(entry_figures(said.entry) | {"applied": [applied_figures(one) for one in said.applied]})
    else:
        print_result("\n".join([entry_line(said.entry), *map(applied_text, said.applied)]))


def problems_text(found: Problems, *, every: bool = False) -> str:
    """A paragraph for each, and how many errors are expected to be left."""
    shown = found.items if every else found.asked
    lines = [line for one in shown for line in _lines(one)]
    rest, asked = len(found.items) - len(found.asked), len(found.asked)
    more = (
        f"; {rest} more {'is' if rest == 1 else 'are'} less likely than {100 * ASK_ABOVE:.0f} % (--every)"
        if rest
        else ""
    )
    left = f"{found.errors_left:.1f} errors are expected to be left" + (" after these" if asked else "")
    lines.append(f"{_count(asked, 'problem') if asked else 'Nothing'} to look at{more}; {left}.")
    return "\n".join(lines)


def problems_figures(found: Problems) -> dict[str, Any]:
    """For a machine."""
    return {
        "head": found.head,
        "expected_errors": round(found.errors, 3),
        "errors_left": round(found.errors_left, 3),
        "problems": [_plain(asdict(one) | {"asked": one.asked}) for one in found.items],
    }


def chosen_edits(found: Problems, problem: str, alternative: int) -> tuple[Edit, ...]:
    """Of an alternative by its number, from 1.

    Raises:
        KinemarkError: there is no such problem or alternative, or nothing must be said for it.
    """
    try:
        one = found[problem]
    except KeyError as error:
        raise KinemarkError(f"There is no problem {problem}. List them: kinemark edits problems.") from error
    if not 1 <= alternative <= len(one.alternatives):
        raise KinemarkError(f"{problem} has {len(one.alternatives)} alternatives; give a number from 1.")
    edits = one.alternatives[alternative - 1].edits
    if not edits:
        raise KinemarkError(f"Nothing must be said to {one.alternatives[alternative - 1].words}.")
    return edits


def _lines(one: Problem) -> list[str]:
    """What it is, then its alternatives."""
    head = f"{one.id}  {100 * one.wrong:.0f} %  {one.words}; {_count(one.at_stake, 'sample')}"
    return [head, *(f"    {k}  {way.words}" for k, way in enumerate(one.alternatives, 1))]


def _count(n: int, one: str) -> str:
    """`1 sample`, `2 samples`; the report's own words take long to import."""
    return f"{n} {one if n == 1 else one + 's'}"


def _plain(value: Any) -> Any:
    """Without numbers that JSON does not know."""
    if isinstance(value, dict):
        return {name: _plain(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
