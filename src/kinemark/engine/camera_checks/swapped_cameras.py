"""Whether two cameras have each other's images."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from ...data import Cloud, Detections, Finding, Rig, make_finding
from ...data.array_types import Floats
from ...data.method import Method
from ...match import match
from ...numerics.evenly import evenly
from ...reconstruct import reconstruct

LITTLE = 0.6
"""Share of a camera's valid detections; if less agree with two other cameras, it may have the images of another.
Chosen."""
AS_MUCH, AS_GOOD = 0.7, 0.95
"""Of the detections that must agree once two cameras are swapped, and of the best share; chosen."""
LOOKED_AT = 20
"""Frames on which cameras are swapped; chosen."""
MOST_PAIRS = 30  # pairs of cameras that are tried; chosen for speed


def swapped_cameras(
    detections: Detections, rig: Rig, cloud: Cloud, *, matching: Method, placing: Method
) -> tuple[Finding, ...]:
    """Which two cameras have each other's images or calibration, if so; nothing where all is well.

    A point on two cameras is no proof, as any two rays that meet are one. So cameras little of whose detections became
    part of a point on three are swapped in pairs; that pair is named with which most then do, `AS_MUCH` and twice as
    many as before. In a room as symmetrical as its cameras two pairs may do as well, and both are named.
    """
    confirmed = confirmed_shares(detections, cloud)
    unconfirmed = np.flatnonzero(confirmed < LITTLE)
    if len(rig) < 3 or len(unconfirmed) < 2:
        return ()
    few = some_frames(detections)
    shares: dict[tuple[str, str], float] = {}
    for a, b in list(combinations(map(int, unconfirmed), 2))[:MOST_PAIRS]:
        cameras = list(rig.cameras)
        cameras[a], cameras[b] = replace(rig[b], name=rig.names[a]), replace(rig[a], name=rig.names[b])
        other = replace(rig, cameras=tuple(cameras))
        points = reconstruct(match(few, other, method=matching), few, other, method=placing)
        now, before = (share[[a, b]] for share in (confirmed_shares(few, points), confirmed))
        if now.min() > max(AS_MUCH, 2 * before.max()):
            shares[rig.names[a], rig.names[b]] = float(now.min())
    best = [pair for pair, share in shares.items() if share > AS_GOOD * max(shares.values())]
    if not best:
        return ()
    return (
        make_finding(
            "cameras_swapped",
            cameras=[name for pair in best for name in pair],
            swapped_share=max(shares.values()),
            as_is_share=confirmed[unconfirmed].max(),
        ),
    )


def some_frames(detections: Detections) -> Detections:
    """Those of LOOKED_AT frames, spread over the recording."""
    frames = evenly(detections.n_frames, LOOKED_AT)
    return detections.keep(np.isin(detections.frame, frames))


def confirmed_shares(detections: Detections, cloud: Cloud) -> Floats:
    """(C) share of each camera's valid detections that became part of a point on three cameras; 1 where it has none."""
    valid = np.bincount(detections.camera[detections.valid], minlength=len(detections.cameras))
    three = cloud.detection[(cloud.detection >= 0).sum(1) >= 3]
    in_point = np.zeros(len(detections), bool)
    in_point[three[three >= 0]] = True
    used = np.bincount(detections.camera[in_point], minlength=len(detections.cameras))
    return np.where(valid > 0, used / np.maximum(valid, 1), 1.0)
