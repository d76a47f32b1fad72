"""Tracks as trajectories: one path a track, over all frames."""

from __future__ import annotations

import numpy as np

from ..data import Path, Tracks, Trajectories


def to_trajectories(tracks: Tracks) -> Trajectories:
    """Each track as a path named `*1`, `*2`, … in the order of their identities."""
    cloud, frame = tracks.cloud, tracks.cloud.frame
    bits = np.left_shift(np.uint32(1), np.arange(min(cloud.view.shape[1], 32), dtype=np.uint32))
    cameras = ((cloud.view[:, :32] >= 0) * bits).sum(1).astype(np.uint32)
    paths = []
    order = np.argsort(tracks.id, kind="stable")
    edges = np.searchsorted(tracks.id[order], np.arange(len(tracks) + 1))
    for i in range(len(tracks)):
        own = order[edges[i] : edges[i + 1]]
        paths.append(
            Path.measured(
                f"*{i + 1}",
                _spread(cloud.xyz[own], frame[own], cloud.n_frames),
                cov=_spread(cloud.cov[own], frame[own], cloud.n_frames),
                residual=_spread(cloud.residual[own], frame[own], cloud.n_frames),
                cameras=np.nan_to_num(_spread(cameras[own], frame[own], cloud.n_frames)),
            )
        )
    return Trajectories(tuple(paths), cloud.rate)


def _spread(values: np.ndarray, frame: np.ndarray, n_frames: int) -> np.ndarray:
    """Values (n, …) at their frames of an array (F, …) that is NaN elsewhere."""
    whole = np.full((n_frames, *values.shape[1:]), np.nan)
    whole[frame] = values
    return whole
