"""Which trial is edited, by its path; and a file of trajectories with its edits, written as another file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ...data import KinemarkError, MarkerTrajectory, Trajectories
from ...edit import Edited
from ...fill import fill
from ...io.formats import FORMATS, check_new_trial
from ...io.notes import FileNote, read_notes
from ...io.trial import write_trial
from ..open_trial import OpenTrial
from ..session import Session
from ..session_name import FILE
from .editing import Editing
from .journal import Journal
from .stage import check_methods, with_edits


def open_editing(path: Path, *, by: str = "") -> Editing:
    """The trial at a path: a file of trajectories; SESSION/TRIAL; or a session of one trial.

    Raises:
        KinemarkError: there is none, or it cannot be read or processed.
    """
    if path.is_file() and path.suffix.lower() != ".toml":
        return Editing.of_file(path, by=by)
    return Editing.of_trial(_trial_at(path), by=by)


def journal_at(path: Path) -> Journal:
    """The journal of the trial at a path, without reading the trial.

    Raises:
        KinemarkError: there is none.
    """
    if path.is_file() and path.suffix.lower() != ".toml":
        return Journal.of(path.parent, path.stem)
    trial = _trial_at(path)
    return Journal.of(trial.workspace.root, trial.name)


def write_edited(editing: Editing, target: Path) -> tuple[FileNote, ...]:
    """Write a file's trial with its edits; gaps are filled where somebody chose how.

    A marker of which the edits leave nothing, as one that was given another name, is not written; one that is empty in
    the file itself is.

    Returns:
        What was odd in the file, and what the target cannot hold.

    Raises:
        KinemarkError: it is a trial of a session, the target exists, or it has an unknown ending.
    """
    if editing.source is None:
        raise KinemarkError(f"{editing.name} is a trial of a session: kinemark run applies its edits.")
    check_new_trial(target)
    edited = editing.edited()
    check_methods(edited.choices)
    before, after = editing.source.trajectories, _filled_as_chosen(edited)
    emptied = _seen(before) - _seen(after)
    after = replace(after, paths=tuple(path for path in after if path.name not in emptied))
    whole = replace(editing.source, trajectories=after)
    return (*read_notes(editing.source.notes), *write_trial(with_edits(whole, edited), target))


def _seen(trajectories: Trajectories) -> set[str]:
    """Names of the markers that have samples."""
    return {path.name for path in trajectories if np.isfinite(path.xyz).any()}


def _filled_as_chosen(edited: Edited) -> Trajectories:
    """The trajectories with those gaps filled for which somebody chose a method, and no others."""
    before = edited.trajectories
    if not any(choice.method != "open" for choice in edited.choices):
        return before
    filled = fill(before, choices=edited.choices)
    paths = {path.name: path for path in before}
    for gap in filled.gaps:
        first, last = gap.start + before.first_frame, gap.stop - 1 + before.first_frame
        about = [c for c in edited.choices if c.marker == gap.marker and c.first <= last and c.last >= first]
        if about and gap.method:
            paths[gap.marker] = _with_gap(paths[gap.marker], filled.trajectories[gap.marker], gap.start, gap.stop)
    return replace(before, paths=tuple(paths.values()))


def _with_gap(path: MarkerTrajectory, filled: MarkerTrajectory, start: int, stop: int) -> MarkerTrajectory:
    """A marker with the samples of one gap from another."""
    columns = {name: getattr(path, name).copy() for name in ("xyz", "cov", "origin", "residual", "cameras")}
    for name, values in columns.items():
        values[start:stop] = getattr(filled, name)[start:stop]
    return replace(path, **columns)


def _trial_at(path: Path) -> OpenTrial:
    """SESSION/TRIAL, or the only trial of SESSION."""
    if (path / FILE).is_file() or path.is_file():
        session = Session.open(path)
        if len(session.names) != 1:
            some = f"{path / session.names[0]}" if session.names else str(path / "TRIAL")
            raise KinemarkError(
                f"{path} has {len(session.names)} trials: {', '.join(session.names)}. Name one, as {some}."
            )
        return session.trial(session.names[0])
    if path.suffix.lower() in FORMATS:
        raise KinemarkError(f"{path} is not there. Check the path.")
    if not (path.parent / FILE).is_file():
        raise KinemarkError(
            f"{path} is neither a file of trajectories nor a trial of a session. Give a file, or SESSION/TRIAL where "
            f"SESSION is a folder with a {FILE}."
        )
    return Session.open(path.parent).trial(path.name)
