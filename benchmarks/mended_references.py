"""Real trials whose own names are wrong in places, mended.

LWRA and LWRB are exchanged in all three files of HC030A: the left wrist has the handedness of the right one. RHLX and
RNAV are exchanged in HC032A18 from about frame 150 on. In the first 24 frames of HC033A22 what is called LFIN lies on
LWRA, 63 mm from LWRB where it has 78 later, while LWRA is absent and LFIN a nameless sample; by frame 29 it has glided
over.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.data.array_types import Floats

MIDWAY_MM = 70.0
"""Between what LWRB has to LWRA and to LFIN; by definition."""


def mended(file: str, trial: Trajectories) -> Trajectories:
    """The trial of a file, with its names mended."""
    if "HC030A" in file:
        other = {"LWRA": "LWRB", "LWRB": "LWRA"}
        return replace(trial, paths=tuple(replace(path, name=other.get(path.name, path.name)) for path in trial))
    if "HC032A18" in file:
        return _mended_foot(trial)
    return _mended_hand(trial) if "HC033A22" in file else trial


def _mended_foot(trial: Trajectories) -> Trajectories:
    """RHLX and RNAV as they were at first: the navicular bone is the one nearer to the heel."""
    a, b, heel = trial["RHLX"].xyz, trial["RNAV"].xyz, trial["RHEE"].xyz
    turned = (np.linalg.norm(a - heel, axis=1) < np.linalg.norm(b - heel, axis=1))[:, None]
    return _replaced(trial, {"RHLX": np.where(turned, b, a), "RNAV": np.where(turned, a, b)})


def _mended_hand(trial: Trajectories) -> Trajectories:
    """LFIN without the frames in which it lies on LWRA, which has these where it has none."""
    finger, wrist = trial["LFIN"].xyz, trial["LWRA"].xyz
    turned = (np.linalg.norm(finger - trial["LWRB"].xyz, axis=1) < MIDWAY_MM)[:, None]
    absent = turned & np.isnan(wrist)
    return _replaced(trial, {"LFIN": np.where(turned, np.nan, finger), "LWRA": np.where(absent, finger, wrist)})


def _replaced(trial: Trajectories, new: dict[str, Floats]) -> Trajectories:
    """With other samples (F, 3) mm of some markers."""
    return replace(
        trial,
        paths=tuple(MarkerTrajectory.measured(p.name, new[p.name]) if p.name in new else p for p in trial),
    )
