"""What people say of a trial: list, check, show and undo it; claim names, erase, put, fill, trim, finish.

TRIAL is SESSION/NAME, a trial of a session, or a file of trajectories such as walk01.c3d. What is said goes into the
journal edits/NAME.jsonl beside session.toml or the file, and is applied whenever the trial is processed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from ...data import KinemarkError
from ...data.edits import Undo, counting
from ...data.typed import typed
from ...io.notes import file_note_figures, file_note_text
from ..edits_output import (
    applied_figures,
    applied_text,
    entry_figures,
    entry_line,
    fault_lines,
    print_entry,
    print_said,
)
from ..output import NO_EMPTY, Json, print_result
from .edits_said import (
    NOTHING,
    Edited,
    Saying,
    claim,
    erase,
    event,
    exchange,
    finish,
    gap,
    image,
    put,
    retrack,
    review,
    smooth,
    trim,
)  # fmt: skip

edits = App(name="edits", help=__doc__, default_parameter=NO_EMPTY)
for said in (claim, exchange, erase, gap, put, image, review, smooth, trim, finish, event, retrack):
    edits.command(said)


@edits.command(name="list")
def list_entries(trial: Edited, *, json: Json = False) -> None:
    """List what was said of a trial: who, when, what, and whether it was undone."""
    from ...engine.editing.files import journal_at

    text = journal_at(trial).read()
    counts = {entry.id for entry in counting(text.entries)}
    if json:
        print_result([entry_figures(entry) | {"counts": entry.id in counts} for entry in text.entries])
        return
    lines = [entry_line(entry) + ("" if entry.id in counts else "  (undone)") for entry in text.entries]
    print_result("\n".join([*lines, *fault_lines(text)]) or "nothing was said")


@edits.command
def matches(trial: Edited, *, track: str, json: Json = False) -> None:
    """Say which markers a piece of track may be: those that are missing then are filled, and compared with it.

    Args:
        track: the piece, as it is called now, such as '*12'.
    """
    from ...engine.editing.files import open_editing

    found = open_editing(trial).matches(track)
    if json:
        print_result([one._asdict() for one in found])
        return
    lines = [
        f"{one.name:10s} {one.off_mm:7.1f} mm off, {one.deviations:5.1f} standard deviations, "
        f"after {one.gap} frames{'  likely' if one.likely else ''}"
        for one in found
    ]
    print_result("\n".join(lines) or f"no marker that is missing while {track} is seen can be filled there")


@edits.command
def check(trial: Path, *, json: Json = False) -> None:
    """Apply the journal, and say of each entry what became of it; ends with status 1 where lines are damaged.

    Args:
        trial: SESSION/NAME or a file; a session's trial is processed as far as it must be.
    """
    from ...engine.editing.files import open_editing

    editing = open_editing(trial)
    applied, text = editing.edited().applied, editing.journal.read()
    if json:
        faults = [fault._asdict() for fault in text.faults]
        print_result({"applied": [applied_figures(one) for one in applied], "faults": faults})
    else:
        print_result("\n".join([*map(applied_text, applied), *fault_lines(text)]) or "nothing was said")
    if text.faults:
        raise SystemExit(1)


@edits.command
def show(trial: Edited, entry: int, *, json: Json = False) -> None:
    """Show one entry with all that it was said of, and what became of it.

    Args:
        entry: its number, from `kinemark edits list`.
    """
    from ...engine.editing.files import open_editing

    editing = open_editing(trial)
    found = next((one for one in editing.journal.entries if one.id == entry), None)
    if found is None:
        raise KinemarkError(f"There is no entry {entry}. List them: kinemark edits list {typed(trial)}.")
    applied = [one for one in editing.edited().applied if one.entry == entry]
    if json:
        print_result(entry_figures(found) | {"applied": [applied_figures(one) for one in applied]})
        return
    lines = [entry_line(found), f"  version {found.version}, line before {found.before[:12]}"]
    for edit in found.edits:
        where = getattr(edit, "where", None) or ()
        for stretch in where if isinstance(where, tuple) else (where,):
            lines += [f"  witness: frame {w.frame} at {w.xyz} mm, {len(w.images)} images" for w in stretch.witnesses]
    print_result("\n".join([*lines, *map(applied_text, applied)]))


@edits.command
def undo(trial: Edited, entry: int | None = None, *, saying: Saying = NOTHING) -> None:
    """Take an entry back; it stays in the journal.

    Args:
        entry: its number; the last that counts where none is given.
    """
    from ...engine.editing.files import journal_at

    print_entry(journal_at(trial).undo(entry, why=saying.why, by=saying.by), saying.json)


@edits.command
def redo(trial: Edited, *, saying: Saying = NOTHING) -> None:
    """Take the last undo back."""
    from ...engine.editing.files import journal_at

    journal = journal_at(trial)
    entry = journal.redo(why=saying.why, by=saying.by)
    if saying.json:
        print_entry(entry, json=True)
        return
    of = {one.id: edit.of for one in journal.entries for edit in one.edits if isinstance(edit, Undo)}
    print_result(f"entry {of[of[entry.id]]} done again, by entry {entry.id}")


@edits.command(name="problems")
def list_problems(
    trial: Path, *, fill: Annotated[bool, Parameter(negative="")] = False, every: bool = False, json: Json = False
) -> None:
    """List what is probably wrong with a trial, what saves most first, and what can be done about each.

    Args:
        trial: SESSION/NAME or a file; a session's trial is processed as far as it must be.
        fill: fill its gaps too, for what error is to be expected in each.
        every: also those that are not worth a look.
    """
    from ...engine.editing.files import open_editing
    from ...engine.problems import filled_gaps, problems
    from ..edits_output import problems_figures, problems_text

    editing = open_editing(trial)
    found = problems(editing, gaps=filled_gaps(editing) if fill else ())
    print_result(problems_figures(found) if json else problems_text(found, every=every))


@edits.command
def accept(trial: Edited, problem: str, alternative: int = 1, *, saying: Saying = NOTHING) -> None:
    """Take an alternative of a problem.

    Args:
        problem: its id, from `kinemark edits problems`.
        alternative: its number, from 1.
    """
    from ...engine.problems import filled_gaps, problems
    from ..edits_output import chosen_edits

    editing = saying.of(trial)
    found = problems(editing, gaps=filled_gaps(editing) if problem.startswith("gap-") else ())
    print_said(editing.say(*chosen_edits(found, problem, alternative), why=saying.why, head=found.head), saying.json)


@edits.command
def sign(trial: Edited, *, saying: Saying = NOTHING) -> None:
    """Stand for the trial with all that was said of it until now."""

    print_entry(saying.of(trial).sign(why=saying.why), saying.json)


@edits.command
def apply(source: Path, *, output: Annotated[Path, Parameter(name=("--output", "-o"))], json: Json = False) -> None:
    """Write a file of trajectories with its edits as another file; gaps are filled where somebody chose how.

    Args:
        source: the file, whose journal is in the folder edits beside it.
        output: the file to write; an existing one is not replaced.
    """
    from ...engine.editing.files import open_editing, write_edited

    notes = write_edited(open_editing(source), output)
    if json:
        print_result({"written": str(output), "notes": file_note_figures(notes)})
        return
    print_result("\n".join([*(f"note:     {file_note_text(note)}" for note in notes), f"results:  {output}"]))
