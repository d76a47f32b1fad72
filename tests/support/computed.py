"""A walker's file as a program leaves it: with axes of segments, joint centres, midpoints and a centre of mass."""

from dataclasses import replace

import numpy as np

from kinemark.data import MarkerTrajectory
from kinemark.synth import walking, with_markers

SEGMENTS = {"LFE": "LASI LTHI LKNE", "RTI": "RKNE RTIB RANK", "TRX": "X0 X1 X2", "PEL": "LASI RASI SACR"}
"""Of each, three markers that its axes are made of."""
NORMAL = {"LFE": "LKNE", "RTI": "RANK"}
"""Of some, the marker that lies on the third axis at a fixed distance of the origin, as a joint's does."""
R = 60.0
"""Of it, mm."""


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def walker(seed=1, **how):
    """A walk with 39 markers on skin that moves."""
    how = {"duration_s": 2.0, "rate": 100.0, "wobble_mm": 1.0} | how
    return with_markers(walking(seed=seed, **how), 39, seed=1).trajectories


def computed(trial):
    """Name → places of what a program computes of a trial's markers, in its own conventions."""
    found = {}
    for name, of in SEGMENTS.items():
        a, b, c = (trial[marker].xyz for marker in of.split())
        e = [unit(b - a)]
        e.append(unit(np.cross(c - a, e[0])))
        e.append(np.cross(e[0], e[1]))
        o = trial[NORMAL[name]].xyz - R * e[2] if name in NORMAL else (a + b) / 2
        long = np.linalg.norm(c - a, axis=-1, keepdims=True) if name in NORMAL else 150.0
        found |= {f"{name}{tip}": o + long * axis for tip, axis in zip("ALP", e, strict=True)} | {f"{name}O": o}
        if name == "RTI":
            found |= {f"RSK{k}": o + mm * axis for k, (mm, axis) in enumerate(zip((50, 50, 400), e, strict=True), 1)}
    heel, toe = trial["LHEE"].xyz, trial["LTOE"].xyz
    x = unit(toe - heel)
    y = unit(np.cross(x, [0.0, 0.0, 1.0]))
    found |= {f"LHLX{k}": toe + 50 * axis for k, axis in enumerate((0 * x, x, y, np.cross(x, y)))}
    found["JUG"] = (trial["LANK"].xyz + trial["RKNE"].xyz) / 2
    found["CentreOfMass"] = np.nanmean([path.xyz for path in trial], axis=0)
    found["CentreOfMassFloor"] = found["CentreOfMass"] * [1.0, 1.0, 0.0]
    return found


def with_computed(trial):
    """The trial with these after its markers."""
    more = tuple(MarkerTrajectory.measured(name, xyz) for name, xyz in computed(trial).items())
    return replace(trial, paths=(*trial.paths, *more))
