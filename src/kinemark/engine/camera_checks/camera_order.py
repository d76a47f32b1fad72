"""Cameras in the wrong order, put in order.

With A the share of the images of camera i that, by the calibration of a, have one of camera j within `TOLERANCE` of
their epipolar line by the calibration of b, the order π in which cameras should have the calibrations has the most of

    S(π) = Σ A(i, π(i); j, π(j))    over all pairs i < j                                                   (1)

It is grown from pairs of cameras that agree well, each time by the camera and calibration that add most to S, and
improved by exchanges. Cameras that see hardly anything together agree as well in other orders, and so do all of them in
a room as symmetrical as its cameras. Of the orders whose S is `AS_GOOD` of the greatest the one is taken that leaves
most cameras as they are; where several leave as many, nobody can tell which is right, and nothing is put in order (2).
Whoever calls sees by tracking again whether that is so.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np

from ...data import Cloud, Detections, Finding, Rig, make_finding
from ...data.array_types import Floats, Ints
from ...geometry import fundamental, undistort
from .swapped_cameras import LITTLE, confirmed_shares, some_frames

IN_PLACE_OF, FITS_NOTHING = "camera_takes_place_of_other", "camera_fits_nothing"
TOLERANCE = 2.0
"""px from an epipolar line; chosen: calibrations may be one off."""
AS_GOOD = 0.9
"""Of (2); chosen on scenes 530000 to 530015 of the second generator, 4 to 8 cameras in any order: the next order had
0.25 to 0.75 of S, or all of it before cameras that saw nothing together."""
STARTS = 6
"""Pairs of cameras a camera, from which orders are grown; chosen."""


def images_of_others(findings: Sequence[Finding], detections: Detections, rig: Rig, cloud: Cloud) -> dict[str, str]:
    """Cameras by name, and the one whose images each has instead of its own; empty where that is not so, or not sure.

    Args:
        findings: of the tracker. detections: what was tracked. rig, cloud: cameras and points of the tracks.
    """
    unlike = any(one.kind in (IN_PLACE_OF, FITS_NOTHING) for one in findings)
    little = (confirmed_shares(detections, cloud) < LITTLE).sum() > 1
    if len(rig) < 3 or not (unlike or little):
        return {}
    order = _sure_order(_agreement(some_frames(detections), rig))
    return {rig.names[i]: rig.names[a] for i, a in enumerate(order.tolist()) if i != a}


def _agreement(detections: Detections, rig: Rig) -> Floats:
    """(C, C, C, C) A(i, a; j, b) of (1)."""
    C = len(rig)
    A, F = np.zeros((C, C, C, C)), [[fundamental(P, Q) for Q in rig.P] for P in rig.P]
    own = [np.flatnonzero(detections.valid & (detections.camera == c)) for c in range(C)]
    uv = [[undistort(camera, detections.uv[rows]) for camera in rig] for rows in own]
    for i, j in combinations(range(C), 2):
        p, q = np.nonzero(detections.frame[own[i]][:, None] == detections.frame[own[j]])
        first = np.flatnonzero(np.diff(p, prepend=-1))
        for a, b in permutations(range(C), 2) if len(p) else ():
            lines = uv[i][a] @ F[a][b][:, :2].T + F[a][b][:, 2]
            lines /= np.linalg.norm(lines[:, :2], axis=1, keepdims=True)
            off = np.abs(np.einsum("nk,nk->n", lines[p, :2], uv[j][b][q]) + lines[p, 2])
            A[i, a, j, b] = A[j, b, i, a] = (np.minimum.reduceat(off, first) < TOLERANCE).mean()
    return A


def _sure_order(A: Floats) -> Ints:
    """(C) the calibration of each camera by (1); all as they are where it is not sure by (2)."""
    given = np.arange(len(A))
    grown = {tuple(_improved(A, order).tolist()) for order in _starts(A)}
    best = max(grown, key=lambda order: _sum(A, np.array(order)))
    orders = {*grown, tuple(given.tolist()), *(tuple(one.tolist()) for one in _exchanges(np.array(best)))}
    least = AS_GOOD * _sum(A, np.array(best))
    good = np.array([order for order in sorted(orders) if _sum(A, np.array(order)) >= least])
    left = (good == given).sum(1)
    return good[left.argmax()] if (left == left.max()).sum() == 1 else given


def _starts(A: Floats) -> Iterator[Ints]:
    """Orders (C): as it is, and those grown from pairs that agree best."""
    C = len(A)
    yield np.arange(C)
    for pair in np.argsort(-A, axis=None, kind="stable")[: 2 * STARTS * C : 2]:  # each pair is there in both directions
        i, a, j, b = np.unravel_index(pair, A.shape)
        order = np.full(C, -1)
        order[i], order[j] = a, b
        while (order < 0).any():
            known = np.flatnonzero(order >= 0)
            adds = A[:, :, known, order[known]].sum(-1)
            adds[known], adds[:, order[known]] = -1.0, -1.0
            camera, calibration = np.unravel_index(adds.argmax(), adds.shape)
            order[camera] = calibration
        yield order


def _improved(A: Floats, order: Ints) -> Ints:
    """The order (C) after the exchanges that add most to S."""
    while _sum(A, other := max(_exchanges(order), key=lambda one: _sum(A, one))) > _sum(A, order):
        order = other
    return order


def _exchanges(order: Ints) -> Iterator[Ints]:
    """The order (C) with two cameras exchanged, any two."""
    for x, y in combinations(range(len(order)), 2):
        other = order.copy()
        other[[x, y]] = order[[y, x]]
        yield other


def _sum(A: Floats, order: Ints) -> float:
    """S of (1), twice."""
    i = np.arange(len(order))
    return float(A[i[:, None], order[:, None], i, order].sum())


def put_in_order(rig: Rig, images_of: Mapping[str, str]) -> Rig:
    """The rig, in which cameras by name have the calibration of the others."""
    by_name = {camera.name: camera for camera in rig}
    cameras = (replace(by_name[images_of.get(one.name, one.name)], name=one.name) for one in rig)
    return replace(rig, cameras=tuple(cameras))


def told_in_order(images_of: Mapping[str, str]) -> Finding:
    """What was put in order."""
    return make_finding("cameras_put_in_order", cameras=images_of, images_of_list=tuple(images_of.values()))
