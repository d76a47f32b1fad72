"""Trials that Plug-in Gait has processed, with their static trials."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from kinemark.data import Trial
from kinemark.data.array_types import Floats
from kinemark.io.trial import read_trial

from .shared import shared_data


class Processed(NamedTuple):
    """A walk, its static trial, and whether the feet were flat in it."""

    walk: str
    static: str
    flat: bool

    def __str__(self) -> str:
        return self.walk.rsplit("/", 1)[-1]


CHILDREN = {
    "pig_gait_child/HC030A": ("01", "05", "22"),
    "pig_gait_children/HC002D": ("02", "06", "25"),
    "pig_gait_children/HC031A": ("01", "06", "23"),
    "pig_gait_children/HC032A": ("01", "03", "18"),
    "pig_gait_children/HC033A": ("01", "10", "22"),
}
"""Static trial, walk and turn of each."""
ADULT = "pig_gait_3plates_emg/PiG_"
TRIALS = (
    *(Processed(f"{c}{n}.c3d", f"{c}{s}.c3d", True) for c, (s, *walks) in CHILDREN.items() for n in walks),
    Processed(f"{ADULT}Motion3_FF.c3d", f"{ADULT}Calibration3_FF.c3d", True),
    Processed(f"{ADULT}Motion3_noFF.c3d", f"{ADULT}Calibration3_noFF.c3d", False),
    Processed(f"{ADULT}Motion3_FF_N18.c3d", f"{ADULT}Calibration3_FF_N18.c3d", True),
    Processed("pig_wholebody/Movement_trial.c3d", "pig_wholebody/Static_trial.c3d", False),
)


@cache
def trial(name: str) -> Trial:
    """A file of the data folder."""
    return read_trial(shared_data(f"mocap3d/{name}"))


def points(name: str) -> dict[str, Floats]:
    """(F, 3) mm by name."""
    return {path.name: path.xyz for path in trial(name).trajectories}
