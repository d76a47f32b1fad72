"""A trial with another axis upwards, as the program that reads it next wants it.

Which axis goes up is shown by the markers of pelvis and ankles, if it has them; else it is what the file says, and z
where it says nothing. x stays where it is not the one that goes up: (x, y, z) with z up is (x, z, -y) with y up, as
OpenSim has it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data import Trial
from ..data.array_types import Floats
from ..data.trial import UP
from ..gait.gait_trial import marker_points
from ..gait.marker_names import model_names, with_model_names
from ..gait.segments import level_axes
from ..gait.standard_trial import axis_of, turned, up_shown
from ..io.notes import FileNote

PELVIS_AND_ANKLES = {"LASI", "RASI", "LANK", "RANK"}


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
    about = {name: text for name, text in trial.about.items() if name != UP}
    if not np.array_equal(wanted, axis_of("z")):
        about[UP] = _name(wanted)
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
        return up_shown(marker_points(replace(trial, trajectories=named))), "from the ankles to the pelvis"
    if UP in trial.about:
        return axis_of(trial.about[UP]), "by the file"
    return axis_of("z"), "where a file does not say it"


def _name(axis: Floats) -> str:
    """As C3D writes it: "+Y"."""
    k = int(np.abs(axis).argmax())
    return ("+" if axis[k] > 0 else "-") + "XYZ"[k]
