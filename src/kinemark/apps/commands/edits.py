"""What people say of a trial: list, check, show and undo it; claim names, erase, put, fill, trim, finish.

TRIAL is SESSION/NAME, a trial of a session, or a file of trajectories such as walk01.c3d. What is said goes into the
journal edits/NAME.jsonl beside session.toml or the file, and is applied whenever the trial is processed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from ...data import KinemarkError
from ...data.edits import counting
from ...engine.edit_files import journal_at, open_editing, write_edited
from ...engine.problems import filled_gaps, problems
from ...io.notes import file_note_text
from ..edits_output import (
    applied_figures,
    applied_text,
    closed_span,
    entry_figures,
    entry_line,
    fault_lines,
    image_of,
    print_entry,
    print_said,
    span_of,
)
from ..output import Json, print_result
from ..problems_output import chosen_edits, problems_figures, problems_text

edits = App(name="edits", help=__doc__)

Why = Annotated[str, Parameter(help="Why, in your words; kept in the journal.")]
By = Annotated[str, Parameter(help="Who says it; the user of the machine where not given.")]
Span = Annotated[
    str | None,
    Parameter(help="Frames A-B, numbers in the recording; A- or -B follows the path to its end; all where not given."),
]


@edits.command(name="list")
def list_entries(trial: Path, *, json: Json = False) -> None:
    """List what was said of a trial: who, when, what, and whether it was undone.

    Args:
        trial: SESSION/NAME or a file.
        json: print it for a machine.
    """
    text = journal_at(trial).read()
    counts = {entry.id for entry in counting(text.entries)}
    if json:
        print_result([entry_figures(entry) | {"counts": entry.id in counts} for entry in text.entries])
        return
    lines = [entry_line(entry) + ("" if entry.id in counts else "  (undone)") for entry in text.entries]
    print_result("\n".join([*lines, *fault_lines(text)]) or "nothing was said")


@edits.command
def check(trial: Path, *, json: Json = False) -> None:
    """Apply the journal, and say of each entry what became of it; ends with status 1 where lines are damaged.

    Args:
        trial: SESSION/NAME or a file; a session's trial is processed as far as it must be.
        json: print it for a machine.
    """
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
def show(trial: Path, entry: int, *, json: Json = False) -> None:
    """Show one entry with all that it was said of, and what became of it.

    Args:
        trial: SESSION/NAME or a file.
        entry: its number, from `kinemark edits list`.
        json: print it for a machine.
    """
    editing = open_editing(trial)
    found = next((one for one in editing.journal.entries if one.id == entry), None)
    if found is None:
        raise KinemarkError(f"There is no entry {entry}. List them: kinemark edits list {trial}.")
    applied = [one for one in editing.edited().applied if one.entry == entry]
    if json:
        print_result(entry_figures(found) | {"applied": [applied_figures(one) for one in applied]})
        return
    lines = [entry_line(found), f"  version {found.version}, line before {found.before[:12]}"]
    for edit in found.edits:
        where = getattr(edit, "where", ())
        for stretch in where if isinstance(where, tuple) else (where,):
            lines += [f"  witness: frame {w.frame} at {w.xyz} mm, {len(w.images)} images" for w in stretch.witnesses]
    print_result("\n".join([*lines, *map(applied_text, applied)]))


@edits.command
def undo(trial: Path, entry: int | None = None, *, why: Why = "", by: By = "", json: Json = False) -> None:
    """Take an entry back; it stays in the journal.

    Args:
        trial: SESSION/NAME or a file.
        entry: its number; the last that counts where none is given.
        why: in your words. by: who says it. json: print it for a machine.
    """
    print_entry(journal_at(trial).undo(entry, why=why, by=by), json)


@edits.command
def redo(trial: Path, *, why: Why = "", by: By = "", json: Json = False) -> None:
    """Take the last undo back.

    Args:
        trial: SESSION/NAME or a file.
        why: in your words. by: who says it. json: print it for a machine.
    """
    print_entry(journal_at(trial).redo(why=why, by=by), json)


@edits.command(name="problems")
def list_problems(
    trial: Path, *, fill: Annotated[bool, Parameter(negative="")] = False, every: bool = False, json: Json = False
) -> None:
    """List what is probably wrong with a trial, what saves most first, and what can be done about each.

    Args:
        trial: SESSION/NAME or a file; a session's trial is processed as far as it must be.
        fill: fill its gaps too, for what error is to be expected in each.
        every: also those that are not worth a look.
        json: print it for a machine, with the edits that each alternative would say.
    """
    editing = open_editing(trial)
    found = problems(editing, gaps=filled_gaps(editing) if fill else ())
    print_result(problems_figures(found) if json else problems_text(found, every=every))


@edits.command
def accept(trial: Path, problem: str, alternative: int = 1, *, why: Why = "", by: By = "", json: Json = False) -> None:
    """Take an alternative of a problem.

    Args:
        trial: SESSION/NAME or a file.
        problem: its id, from `kinemark edits problems`.
        alternative: its number, from 1.
        why: in your words. by: who says it. json: print it for a machine.
    """
    editing = open_editing(trial, by=by)
    found = problems(editing, gaps=filled_gaps(editing) if problem.startswith("gap-") else ())
    print_said(editing.say(*chosen_edits(found, problem, alternative), why=why, head=found.head), json)


@edits.command
def sign(trial: Path, *, why: Why = "", by: By = "", json: Json = False) -> None:
    """Stand for the trial with all that was said of it until now.

    Args:
        trial: SESSION/NAME or a file.
        why: in your words. by: who says it. json: print it for a machine.
    """
    print_entry(open_editing(trial, by=by).sign(why=why), json)


@edits.command
def claim(
    trial: Path,
    *,
    track: str,
    name: str | None = None,
    no_marker: Annotated[bool, Parameter(negative="")] = False,
    frames: Span = None,
    anyway: Annotated[bool, Parameter(negative="")] = False,
    why: Why = "",
    by: By = "",
    json: Json = False,
) -> None:
    """Say which marker a trajectory is, or that it is none.

    Where another trajectory has the name already, it is first looked whether the two can be one marker.

    Args:
        trial: SESSION/NAME or a file.
        track: the trajectory, as it is called now: '*12', or a name.
        name: of the marker.
        no_marker: it is none: a ghost.
        frames: of the stretch that is meant.
        anyway: join two that do not seem to be one marker.
        why: in your words. by: who says it. json: print it for a machine.
    """
    if (name is None) != no_marker:
        raise KinemarkError("Say either --name NAME or --no-marker.")
    editing = open_editing(trial, by=by)
    first, last = span_of(frames)
    joined = None if name is None or frames is not None else editing.connection(track, name)
    if joined is not None and not joined.connectable and not anyway:
        where = f"overlap in {joined.overlap} frames" if joined.overlap else f"are {joined.gap} frames apart"
        raise KinemarkError(
            f"{track} does not go on {name}: they {where}, and are {joined.off_mm:.1f} mm off, "
            f"{joined.deviations:.1f} standard deviations. Join them with --anyway, or name frames with --frames."
        )
    print_said(editing.claim(track, name, first=first, last=last, why=why), json)


@edits.command
def exchange(
    trial: Path, one: str, other: str, *, frames: Span = None, why: Why = "", by: By = "", json: Json = False
) -> None:
    """Give two trajectories each other's names.

    Args:
        trial: SESSION/NAME or a file.
        one: a marker. other: the marker that it was taken for.
        frames: in which they are exchanged: 751- from frame 751 on.
        why: in your words. by: who says it. json: print it for a machine.
    """
    first, last = span_of(frames)
    print_said(open_editing(trial, by=by).exchange(one, other, first=first, last=last, why=why), json)


@edits.command
def erase(trial: Path, marker: str, *, frames: str, why: Why = "", by: By = "", json: Json = False) -> None:
    """Say that samples of a marker are wrong; they become a gap.

    Args:
        trial: SESSION/NAME or a file.
        marker: its name. frames: A-B, or one.
        why: in your words. by: who says it. json: print it for a machine.
    """
    print_said(open_editing(trial, by=by).erase(marker, *closed_span(frames), why=why), json)


@edits.command
def gap(trial: Path, marker: str, *, frames: str, method: str, why: Why = "", by: By = "", json: Json = False) -> None:
    """Choose how gaps of a marker are filled.

    Args:
        trial: SESSION/NAME or a file.
        marker: its name. frames: A-B; every gap that reaches into them is meant.
        method: one of `kinemark methods fill`; best for the least expected error; open for not at all.
        why: in your words. by: who says it. json: print it for a machine.
    """
    print_said(open_editing(trial, by=by).gap(marker, *closed_span(frames), method, why=why), json)


@edits.command
def put(
    trial: Path,
    marker: str,
    *,
    frame: int,
    at: tuple[float, float, float] | None = None,
    image: Annotated[list[str] | None, Parameter(negative="")] = None,
    sd: float = 1.0,
    why: Why = "",
    by: By = "",
    json: Json = False,
) -> None:
    """Put a marker at a place by hand, in space or by two images.

    Args:
        trial: SESSION/NAME or a file.
        marker: its name. frame: number in the recording.
        at: X Y Z in mm.
        image: where it is in an image, as cam1:312.5,204; twice or more, instead of --at.
        sd: standard deviation of each axis, mm; of images it is computed.
        why: in your words. by: who says it. json: print it for a machine.
    """
    if (at is None) == (not image):
        raise KinemarkError("Say either --at X Y Z or --image CAMERA:U,V for two cameras or more.")
    editing = open_editing(trial, by=by)
    if at is not None:
        print_said(editing.put(marker, frame, at, sd_mm=sd, why=why), json)
    else:
        print_said(editing.put_in_images(marker, frame, dict(map(image_of, image or [])), why=why), json)


@edits.command
def image(
    trial: Path,
    camera: str,
    *,
    frame: int,
    at: tuple[float, float],
    name: str | None = None,
    no_marker: Annotated[bool, Parameter(negative="")] = False,
    why: Why = "",
    by: By = "",
    json: Json = False,
) -> None:
    """Say where a marker is in an image, or that the image there is none; its sample is worked out again.

    Args:
        trial: SESSION/NAME.
        camera: its name. frame: number in the recording. at: U V in px.
        name: of the marker.
        no_marker: the image there is no marker's.
        why: in your words. by: who says it. json: print it for a machine.
    """
    if (name is None) != no_marker:
        raise KinemarkError("Say either --name NAME or --no-marker.")
    print_said(open_editing(trial, by=by).image(camera, frame, *at, name, why=why), json)


@edits.command
def review(
    trial: Path,
    decision: int,
    *,
    right: Annotated[bool, Parameter(negative="--wrong")] = True,
    why: Why = "",
    by: By = "",
    json: Json = False,
) -> None:
    """Give a verdict on an ambiguous decision of the tracking, which then leaves the report.

    Args:
        trial: SESSION/NAME.
        decision: its number, from 1, in ambiguous_decisions.json.
        right: it was right, or --wrong.
        why: in your words. by: who says it. json: print it for a machine.
    """
    print_said(open_editing(trial, by=by).review(decision, right=right, why=why), json)


@edits.command
def smooth(
    trial: Path, marker: str, *, frames: str, cutoff: float, why: Why = "", by: By = "", json: Json = False
) -> None:
    """Low-pass filter a stretch of a marker, without lag.

    Args:
        trial: SESSION/NAME or a file.
        marker: its name. frames: A-B. cutoff: in Hz.
        why: in your words. by: who says it. json: print it for a machine.
    """
    print_said(open_editing(trial, by=by).smooth(marker, *closed_span(frames), cutoff, why=why), json)


@edits.command
def trim(trial: Path, *, frames: str, why: Why = "", by: By = "", json: Json = False) -> None:
    """Let all markers begin and end at these frames.

    Args:
        trial: SESSION/NAME or a file.
        frames: A-B.
        why: in your words. by: who says it. json: print it for a machine.
    """
    print_said(open_editing(trial, by=by).trim(*closed_span(frames), why=why), json)


@edits.command
def finish(trial: Path, *, frames: Span = None, why: Why = "", by: By = "", json: Json = False) -> None:
    """Drop what has no name, and trim all markers to the frames that they have in common.

    Args:
        trial: SESSION/NAME or a file.
        frames: A-B instead of those.
        why: in your words. by: who says it. json: print it for a machine.
    """
    first, last = span_of(frames)
    print_said(open_editing(trial, by=by).finish(first=first, last=last, why=why), json)


@edits.command
def event(
    trial: Path, label: str, *, time: float, side: str = "General", why: Why = "", by: By = "", json: Json = False
) -> None:
    """Add an event.

    Args:
        trial: SESSION/NAME or a file.
        label: what, such as 'Foot Strike'. time: s from frame 1 of the recording. side: Left, Right or General.
        why: in your words. by: who says it. json: print it for a machine.
    """
    print_said(open_editing(trial, by=by).event(label, side, time, why=why), json)


@edits.command
def apply(source: Path, *, output: Annotated[Path, Parameter(name=("--output", "-o"))]) -> None:
    """Write a file of trajectories with its edits as another file; gaps are filled where somebody chose how.

    Args:
        source: the file, whose journal is in the folder edits beside it.
        output: the file to write; an existing one is not replaced.
    """
    notes = write_edited(open_editing(source), output)
    print_result("\n".join([*(f"note:     {file_note_text(note)}" for note in notes), f"results:  {output}"]))
