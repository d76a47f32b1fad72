"""Tracks as trajectories whose residuals are lengths."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..data import Cloud, Rig, Tracks, Trajectories
from ..data.track_trajectories import trajectories_of
from ..geometry import to_camera


def to_trajectories(tracks: Tracks, rig: Rig | None) -> Trajectories:
    """Each track as a marker named `*1`, `*2`, … in the order of their identities.

    Args:
        tracks: with residuals in px.
        rig: turns these into mm at the points' distances; without it markers have no residuals.
    """
    return trajectories_of(tracks, None if rig is None else tracks.cloud.residual * _pixel(rig, tracks.cloud))


def _pixel(rig: Rig, cloud: Cloud) -> NDArray[np.float64]:
    """(P) what a pixel spans at each point, mm, on average over the cameras that see it."""
    spans = [np.abs(to_camera(c, cloud.xyz)[:, 2]) / np.sqrt(abs(c.K[0, 0] * c.K[1, 1])) for c in rig]
    seen = cloud.detection >= 0
    return (np.stack(spans, 1) * seen).sum(1) / np.maximum(seen.sum(1), 1)
