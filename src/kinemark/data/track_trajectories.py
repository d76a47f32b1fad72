"""Tracks as trajectories: one marker a track, over all frames, with the images behind every sample."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .array_types import Floats, Ints
from .cloud import Tracks
from .trajectories import MarkerTrajectory, Trajectories


def trajectories_of(tracks: Tracks, residual: Floats | None = None) -> Trajectories:
    """Each track as a marker named `*1`, `*2`, … in the order of their identities.

    Args:
        tracks: of a recording.
        residual: (P) how far the rays of its cameras pass from each point, mm; unknown where None.
    """
    cloud, frame = tracks.cloud, tracks.cloud.frame
    residual = np.full(len(cloud), np.nan) if residual is None else residual
    order = np.argsort(tracks.id, kind="stable")
    edges = np.searchsorted(tracks.id[order], np.arange(len(tracks) + 1))
    paths = []
    for i in range(len(tracks)):
        own = order[edges[i] : edges[i + 1]]
        at = frame[own], cloud.n_frames
        paths.append(
            MarkerTrajectory.measured(
                f"*{i + 1}",
                _spread(cloud.xyz[own], *at, np.nan),
                cov=_spread(cloud.cov[own], *at, np.nan),
                residual=_spread(residual[own], *at, np.nan),
                detection=_spread(cloud.detection[own], *at, -1),
            )
        )
    return Trajectories(tuple(paths), cloud.rate)


def _spread(values: NDArray[Any], frame: Ints, n_frames: int, blank: float) -> NDArray[Any]:
    """Values (n, …) at their frames of an array (F, …) that is blank elsewhere."""
    whole = np.full((n_frames, *values.shape[1:]), blank, values.dtype)
    whole[frame] = values
    return whole
