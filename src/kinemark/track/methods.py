"""Tracking by whichever method."""

from __future__ import annotations

from collections.abc import Callable

from ..data import Cloud, Tracks
from .kiss_tracking import KissTracking, track_kiss
from .ladder import ExtrapolationLadder, track_ladder
from .swamidas import DistanceOnly, Swamidas, track_distance, track_swamidas

TrackMethod = ExtrapolationLadder | KissTracking | Swamidas | DistanceOnly

TRACKERS: dict[type, Callable[..., Tracks]] = {
    ExtrapolationLadder: track_ladder,
    KissTracking: track_kiss,
    Swamidas: track_swamidas,
    DistanceOnly: track_distance,
}
"""What does each method: called with the cloud and method=…"""

DEFAULT = ExtrapolationLadder()


def track(cloud: Cloud, *, method: TrackMethod = DEFAULT) -> Tracks:
    """The cloud with identities, numbered in the order in which the tracks begin."""
    return TRACKERS[type(method)](cloud, method=method)
