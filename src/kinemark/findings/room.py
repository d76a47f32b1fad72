"""How well the room is known: an error that all positions of a calibration have in common, as plain figures."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..calibrate.quality import WorldPose, points_of, volume_grid
from ..calibrate.quality.volume import deviation
from ..data.array_types import Floats
from .plain import quantile, rms

MOST_PLACES = 5000
"""Positions of a trial at which it is looked at, evenly spread; chosen for speed."""


def room_figures(world: WorldPose | None, volume: Floats) -> dict[str, Any] | None:
    """Of a calibration over its volume (2, 3) mm; None where the room is not known, or not by points seen afterwards.

    `covariance` is that of a turn, rad, a shift, mm, and a growth, mm over `spread_mm`, about `centre_mm`.
    """
    if world is None:
        return None
    sd = deviation(world.at(points_of(volume_grid(volume))))
    return {
        "sd_median_mm": quantile(sd, 0.5),
        "sd_95_mm": quantile(sd, 0.95),
        "turn_sd_deg": np.degrees(np.sqrt(np.trace(world.cov[:3, :3]) / 3)),
        "centre_sd_mm": np.sqrt(np.trace(world.cov[3:6, 3:6]) / 3),
        "centre_mm": world.centre,
        "spread_mm": world.spread,
        "covariance": world.cov,
    }


def room_at(room: dict[str, Any] | None, xyz: Floats) -> dict[str, Any] | None:
    """The same of a trial with positions (N, 3) mm: `sd_at_subject_mm` besides, per axis, over those that are known."""
    if room is None:
        return None
    there = xyz[np.isfinite(xyz).all(1)]
    there = there[:: max(len(there) // MOST_PLACES, 1)]
    world = WorldPose(np.array(room["centre_mm"]), np.array(room["covariance"]), room["spread_mm"])
    return room | {"sd_at_subject_mm": rms(deviation(world.at(there)))}
