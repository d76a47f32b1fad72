"""A trial turned so that another axis goes up, as another program expects it.

Which axis goes up is shown by the markers of pelvis and ankles, if it has them; else it is what the file says; else
the one along which the markers of somebody who stands or walks are far longer than wide and begin near 0, where the
floor is; and z where nothing tells it. x stays where it is not the one that goes up: (x, y, z) with z up is (x, z, -y)
with y up, as OpenSim has it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data import KinemarkError, Trajectories, Trial
from ..data.array_types import Floats
from ..data.laboratory_axes import axis_of, level_axes, turned, up_shown
from ..data.marker_sides import without_subject
from ..data.model_markers import model_names, with_model_names
from ..data.trial import UP
from ..io.notes import FileNote

PELVIS_AND_ANKLES = {"LASI", "RASI", "LANK", "RANK"}
UNKNOWN = "where a file does not say it"
MANY = 8
"""So many markers, at least, show how somebody stands; chosen."""
LONGER = 1.5
"""So many times longer than wide is who stands; chosen: whole bodies that walk are 1.6 to 3 times."""
FLOOR_MM = 300.0
"""The lowest marker is so near to 0; chosen: of 49 files, those of a prone start and of a racing wheelchair, whose
longest side is level, are so told apart."""
TALL_MM = (700.0, 2500.0)
"""How long the markers of a person are who stands; chosen: shorter ones are a limb's, longer ones no person's."""


def with_axis_up(trial: Trial, up: str) -> tuple[Trial, tuple[FileNote, ...]]:
    """The trial turned so that an axis of the world goes up, and what was done.

    Args:
        trial: with markers, mm.
        up: "x", "y" or "z".

    Raises:
        KinemarkError: from the ankles to the pelvis it goes along no axis.
    """
    have, by = vertical(trial)
    wanted = axis_of(up)
    turn = level_axes(have) @ level_axes(wanted).T
    about = {**trial.about, UP: _name(wanted)}
    what = f"{_name(have)} goes up {by}; it is turned to {_name(wanted)}"
    notes = [FileNote("turned", what)]
    if len(trial.signals) or trial.poses:
        kept = ["signals"] * bool(len(trial.signals)) + ["poses of segments"] * bool(trial.poses)
        notes.append(FileNote("not_turned", " and ".join(kept)))
    return replace(turned(trial, turn), about=about), tuple(notes)


def vertical(trial: Trial) -> tuple[Floats, str]:
    """(3) the axis that goes up, and by what it is known, in words.

    Raises:
        KinemarkError: from the ankles to the pelvis it goes along no axis.
    """
    named = with_model_names(trial.trajectories, model_names(trial.trajectories.names))
    if set(named.names) >= PELVIS_AND_ANKLES:
        return up_shown({without_subject(path.name): path.xyz for path in named}), "from the ankles to the pelvis"
    if UP in trial.about:
        return axis_of(trial.about[UP]), "by the file"
    if (longest := _up_by_length(trial.trajectories)) is not None:
        return longest, "along the length of the body"
    return axis_of("z"), UNKNOWN


def with_axis_said(trial: Trial) -> tuple[Trial, tuple[FileNote, ...]]:
    """The trial that says which axis goes up, where its markers show it and nothing said it; and what is said.

    A trial whose markers do not show it is as it was: the file that is written says nothing of it.
    """
    if UP in trial.about or trial.source is not None or not len(trial.trajectories):
        return trial, ()
    try:
        axis, by = vertical(trial)
    except KinemarkError:  # along no axis
        by = UNKNOWN
    if by == UNKNOWN:
        what = "which axis goes up is not shown by the markers, and the file does not say it; --up z says that z does"
        return trial, (FileNote("turned", what),)
    about = {**trial.about, UP: _name(axis)}
    return replace(trial, about=about), (FileNote("turned", f"{_name(axis)} goes up {by}, and the file says so"),)


def _up_by_length(trajectories: Trajectories) -> Floats | None:
    """(3) the axis along which many markers are far longer than along the others and begin at the floor, or None."""
    if len(trajectories) < MANY or not trajectories.n_frames:
        return None
    xyz = trajectories.xyz
    xyz = xyz[:, np.isfinite(xyz).all(-1).sum(0) >= MANY]
    if not xyz.size:
        return None
    low, high = np.median(np.nanmin(xyz, 0), 0), np.median(np.nanmax(xyz, 0), 0)
    sides = high - low
    second, longest = np.sort(sides)[1:]
    if not TALL_MM[0] < longest < TALL_MM[1] or longest < LONGER * second:
        return None
    k = int(sides.argmax())
    return np.eye(3)[k] if abs(low[k]) < FLOOR_MM else None


def _name(axis: Floats) -> str:
    """As C3D writes it: "+Y"."""
    k = int(np.abs(axis).argmax())
    return ("+" if axis[k] > 0 else "-") + "XYZ"[k]
