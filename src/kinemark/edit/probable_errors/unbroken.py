"""A trial without its breaks: what is lost, repeated or moved in all paths at once is taken away, so that each path is
judged by what is its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...data import MarkerTrajectory, Trajectories
from ...data.array_types import Ints
from .breaks import Break
from .paths import Paths
from .ways import SMEARED


def unbroken(paths: Paths, names: Sequence[str], some: Sequence[Break]) -> tuple[Trajectories, Ints]:
    """The trial as it would be without these breaks, in the order of their frames; and (F) the frame that each was.

    Frames that were lost are missing in all paths; what follows a movement is moved back.
    """
    xyz, time = paths.xyz.copy(), np.arange(paths.xyz.shape[1])
    kept = np.ones(len(time), np.bool_)
    for one in reversed(some):
        inside = slice(one.before + 1, one.after)
        if one.motion is not None:
            moved = slice(one.after, None) if one.kind == "moved" else inside
            xyz[:, moved] = one.motion.back(xyz[:, moved])
        if one.kind != "shaken" or one.after - one.before - 1 <= SMEARED:
            xyz[:, inside] = np.nan
        if one.frames < 0:
            kept[one.after + one.frames : one.after] = False
        time[one.after :] += one.frames
    out = np.full((len(xyz), int(time[kept].max(initial=-1)) + 1, 3), np.nan)
    out[:, time[kept]] = xyz[:, kept]
    frame = np.flatnonzero(kept)[np.searchsorted(time[kept], np.arange(out.shape[1]), side="right") - 1]
    tracks = tuple(MarkerTrajectory.measured(name, path) for name, path in zip(names, out, strict=True))
    return Trajectories(tracks, paths.rate), frame
