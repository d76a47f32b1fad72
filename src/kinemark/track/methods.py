"""Tracking of points by whichever method."""

from __future__ import annotations

from ..data import Cloud, Tracks
from ..data.method import Method
from .ladder import ExtrapolationLadder
from .stage import CLOUD, TRACK

DEFAULT = ExtrapolationLadder()


def track(cloud: Cloud, *, method: Method = DEFAULT) -> Tracks:
    """The cloud with identities, numbered in the order in which the tracks begin.

    Raises:
        ValueError: the method is none of `TRACK`, or takes detections (`track_detections`).
    """
    return TRACK.function(method, takes=CLOUD)(cloud, method=method)
