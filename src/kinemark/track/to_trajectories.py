"""Tracks as trajectories: one path a track, over all frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..data import Cloud, MarkerTrajectory, Rig, Tracks, Trajectories
from ..geometry import to_camera


def to_trajectories(tracks: Tracks, rig: Rig | None) -> Trajectories:
    """Each track as a path named `*1`, `*2`, … in the order of their identities.

    Args:
        tracks: with residuals in px.
        rig: turns these into mm at the points' distances; without it paths have no residuals.
    """
    cloud, frame = tracks.cloud, tracks.cloud.frame
    residual = cloud.residual * (np.nan if rig is None else _pixel(rig, cloud))
    bits = np.left_shift(np.uint32(1), np.arange(min(cloud.view.shape[1], 32), dtype=np.uint32))
    cameras = ((cloud.view[:, :32] >= 0) * bits).sum(1).astype(np.uint32)
    paths = []
    order = np.argsort(tracks.id, kind="stable")
    edges = np.searchsorted(tracks.id[order], np.arange(len(tracks) + 1))
    for i in range(len(tracks)):
        own = order[edges[i] : edges[i + 1]]
        paths.append(
            MarkerTrajectory.measured(
                f"*{i + 1}",
                _spread(cloud.xyz[own], frame[own], cloud.n_frames),
                cov=_spread(cloud.cov[own], frame[own], cloud.n_frames),
                residual=_spread(residual[own], frame[own], cloud.n_frames),
                cameras=np.nan_to_num(_spread(cameras[own], frame[own], cloud.n_frames)),
            )
        )
    return Trajectories(tuple(paths), cloud.rate)


def _pixel(rig: Rig, cloud: Cloud) -> NDArray[np.float64]:
    """(P) what a pixel spans at each point, mm, on average over the cameras that see it."""
    spans = [np.abs(to_camera(c, cloud.xyz)[:, 2]) / np.sqrt(abs(c.K[0, 0] * c.K[1, 1])) for c in rig]
    seen = cloud.view >= 0
    return (np.stack(spans, 1) * seen).sum(1) / np.maximum(seen.sum(1), 1)


def _spread(values: np.ndarray, frame: np.ndarray, n_frames: int) -> np.ndarray:
    """Values (n, …) at their frames of an array (F, …) that is NaN elsewhere."""
    whole = np.full((n_frames, *values.shape[1:]), np.nan)
    whole[frame] = values
    return whole
