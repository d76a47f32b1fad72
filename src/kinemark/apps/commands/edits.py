"""What people say of a trial: list, check, show and undo it; claim names, erase, put, fill, trim, finish.

TRIAL is SESSION/NAME, a trial of a session, or a file of trajectories such as walk01.c3d. What is said goes into the
journal edits/NAME.jsonl beside session.toml or the file, and is applied whenever the trial is processed.
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

from cyclopts import App, Parameter

from ...data import KinemarkError
from ...data.edits import Applied, Entry, counting
from ...engine.edit_files import journal_at, open_editing, write_edited
from ...engine.editing import Said
from ...io.edits_jsonl import JournalText
from ...io.notes import file_note_text
from ...report.words import edit_text
from ..output import Json, print_result

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
        print_result([_entry_figures(entry) | {"counts": entry.id in counts} for entry in text.entries])
        return
    lines = [_line(entry) + ("" if entry.id in counts else "  (undone)") for entry in text.entries]
    print_result("\n".join([*lines, *_faults(text)]) or "nothing was said")


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
        print_result({"applied": [_applied_figures(one) for one in applied], "faults": faults})
    else:
        print_result("\n".join([*map(_applied_text, applied), *_faults(text)]) or "nothing was said")
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
        print_result(_entry_figures(found) | {"applied": [_applied_figures(one) for one in applied]})
        return
    lines = [_line(found), f"  version {found.version}, line before {found.before[:12]}"]
    for edit in found.edits:
        where = getattr(edit, "where", ())
        for stretch in where if isinstance(where, tuple) else (where,):
            lines += [f"  witness: frame {w.frame} at {w.xyz} mm, {len(w.images)} images" for w in stretch.witnesses]
    print_result("\n".join([*lines, *map(_applied_text, applied)]))


@edits.command
def undo(trial: Path, entry: int | None = None, *, why: Why = "", by: By = "", json: Json = False) -> None:
    """Take an entry back; it stays in the journal.

    Args:
        trial: SESSION/NAME or a file.
        entry: its number; the last that counts where none is given.
        why: in your words. by: who says it. json: print it for a machine.
    """
    _print_entry(journal_at(trial).undo(entry, why=why, by=by), json)


@edits.command
def redo(trial: Path, *, why: Why = "", by: By = "", json: Json = False) -> None:
    """Take the last undo back.

    Args:
        trial: SESSION/NAME or a file.
        why: in your words. by: who says it. json: print it for a machine.
    """
    _print_entry(journal_at(trial).redo(why=why, by=by), json)


@edits.command
def sign(trial: Path, *, why: Why = "", by: By = "", json: Json = False) -> None:
    """Stand for the trial with all that was said of it until now.

    Args:
        trial: SESSION/NAME or a file.
        why: in your words. by: who says it. json: print it for a machine.
    """
    _print_entry(open_editing(trial, by=by).sign(why=why), json)


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
    first, last = _span(frames)
    joined = None if name is None or frames is not None else editing.connection(track, name)
    if joined is not None and not joined.connectable and not anyway:
        where = f"overlap in {joined.overlap} frames" if joined.overlap else f"are {joined.gap} frames apart"
        raise KinemarkError(
            f"{track} does not go on {name}: they {where}, and are {joined.off_mm:.1f} mm off, "
            f"{joined.deviations:.1f} standard deviations. Join them with --anyway, or name frames with --frames."
        )
    _print_said(editing.claim(track, name, first=first, last=last, why=why), json)


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
    first, last = _span(frames)
    _print_said(open_editing(trial, by=by).exchange(one, other, first=first, last=last, why=why), json)


@edits.command
def erase(trial: Path, marker: str, *, frames: str, why: Why = "", by: By = "", json: Json = False) -> None:
    """Say that samples of a marker are wrong; they become a gap.

    Args:
        trial: SESSION/NAME or a file.
        marker: its name. frames: A-B, or one.
        why: in your words. by: who says it. json: print it for a machine.
    """
    _print_said(open_editing(trial, by=by).erase(marker, *_closed(frames), why=why), json)


@edits.command
def gap(trial: Path, marker: str, *, frames: str, method: str, why: Why = "", by: By = "", json: Json = False) -> None:
    """Choose how gaps of a marker are filled.

    Args:
        trial: SESSION/NAME or a file.
        marker: its name. frames: A-B; every gap that reaches into them is meant.
        method: one of `kinemark methods fill`; best for the least expected error; open for not at all.
        why: in your words. by: who says it. json: print it for a machine.
    """
    _print_said(open_editing(trial, by=by).gap(marker, *_closed(frames), method, why=why), json)


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
        _print_said(editing.put(marker, frame, at, sd_mm=sd, why=why), json)
    else:
        _print_said(editing.put_in_images(marker, frame, dict(map(_image, image or [])), why=why), json)


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
    _print_said(open_editing(trial, by=by).smooth(marker, *_closed(frames), cutoff, why=why), json)


@edits.command
def trim(trial: Path, *, frames: str, why: Why = "", by: By = "", json: Json = False) -> None:
    """Let all markers begin and end at these frames.

    Args:
        trial: SESSION/NAME or a file.
        frames: A-B.
        why: in your words. by: who says it. json: print it for a machine.
    """
    _print_said(open_editing(trial, by=by).trim(*_closed(frames), why=why), json)


@edits.command
def finish(trial: Path, *, frames: Span = None, why: Why = "", by: By = "", json: Json = False) -> None:
    """Drop what has no name, and trim all markers to the frames that they have in common.

    Args:
        trial: SESSION/NAME or a file.
        frames: A-B instead of those.
        why: in your words. by: who says it. json: print it for a machine.
    """
    first, last = _span(frames)
    _print_said(open_editing(trial, by=by).finish(first=first, last=last, why=why), json)


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
    _print_said(open_editing(trial, by=by).event(label, side, time, why=why), json)


@edits.command
def apply(source: Path, *, output: Annotated[Path, Parameter(name=("--output", "-o"))]) -> None:
    """Write a file of trajectories with its edits as another file; gaps are filled where somebody chose how.

    Args:
        source: the file, whose journal is in the folder edits beside it.
        output: the file to write; an existing one is not replaced.
    """
    notes = write_edited(open_editing(source), output)
    print_result("\n".join([*(f"note:     {file_note_text(note)}" for note in notes), f"results:  {output}"]))


def _span(text: str | None) -> tuple[int | None, int | None]:
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


def _closed(text: str) -> tuple[int, int]:
    """First and last frame of "A-B" or "A"."""
    first, last = _span(text)
    if first is None or last is None:
        raise KinemarkError(f"{text!r} has no end. Give both, as 120-180.")
    return first, last


def _image(text: str) -> tuple[str, tuple[float, float]]:
    """Camera and place of "cam1:312.5,204"."""
    camera, _, place = text.rpartition(":")
    try:
        u, v = map(float, place.split(","))
    except ValueError as error:
        raise KinemarkError(f"{text!r} is no place in an image. Give it as cam1:312.5,204.") from error
    return camera, (u, v)


def _line(entry: Entry) -> str:
    """An entry in a line."""
    why = f"  “{entry.why}”" if entry.why else ""
    said = "; ".join(map(edit_text, entry.edits))
    return f"{entry.id:4d}  {entry.at[:19].replace('T', ' ')}  {entry.by}  {said}{why}"


def _applied_text(one: Applied) -> str:
    """What became of an edit, in a line."""
    why = f" ({one.reason})" if one.reason else ""
    return f"{one.entry:4d}  {one.outcome:9s}  {edit_text(one.edit)}{why}"


def _faults(text: JournalText) -> list[str]:
    return [f"line {fault.line} of the journal does not count: {fault.text}" for fault in text.faults]


def _entry_figures(entry: Entry) -> dict[str, Any]:
    """For a machine."""
    figures = {name: getattr(entry, name) for name in ("id", "at", "by", "why", "version")}
    return figures | {"edits": [asdict(edit) for edit in entry.edits], "text": [edit_text(e) for e in entry.edits]}


def _applied_figures(one: Applied) -> dict[str, Any]:
    figures = {name: getattr(one, name) for name in ("entry", "outcome", "share", "samples", "reason")}
    return figures | {"edit": one.edit.kind, "text": edit_text(one.edit)}


def _print_entry(entry: Entry, json: bool) -> None:
    print_result(_entry_figures(entry) if json else _line(entry))


def _print_said(said: Said, json: bool) -> None:
    """An entry and what came of it."""
    if json:
        print_result(_entry_figures(said.entry) | {"applied": [_applied_figures(one) for one in said.applied]})
    else:
        print_result("\n".join([_line(said.entry), *map(_applied_text, said.applied)]))
