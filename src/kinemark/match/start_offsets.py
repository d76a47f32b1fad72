"""By how many images recordings that were not started together are apart, from the markers that they show.

Where camera b shows in image g what camera a shows in image f, markers' images lie on each other's epipolar lines. With
w(f, g) the share of a's detections in f of which a detection in g of b lies within `TOLERANCE` px of their line,

    S(k) = mean over f of w(f, f + k)                                                         (1)

has a peak at the k by which b's numbers lead those of a; elsewhere it is what chance gives. With h(k) = S(k) less the
median of S,

    q = h(k*) / max h(k)    over all k that are not k* or near it                              (2)

is the clearness of the peak. A pair of cameras tells something where q is `CLEAR` or more and h(k*) `HEIGHT`; where
nothing moves, every k is alike, and motions that repeat reach nearly the same height a cycle later. Cameras are chained
from the clearest pair on (a spanning tree of the greatest q), and other clear pairs that disagree by more than an image
are counted. Parts of a frame are left to tracking, which learns delays below one.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..data import Detections, KinemarkError, Rig
from ..data.array_types import Floats, Ints
from ..geometry import epipolar_lines, fundamental
from ..geometry.ideal_pixels import check_cameras, ideal_pixels
from ..numerics.evenly import evenly

TOLERANCE = 1.5
"""px from an epipolar line; chosen: usual calibrations leave half a pixel, and more would let chance in."""
CLEAR, HEIGHT = 1.4, 0.2
"""The least q of (2), and the least height of a peak, a share of detections; chosen: in walks of a second and a half,
of which cameras shared a quarter and more, right peaks had 1.8 to 2.8 and 0.45 to 0.6."""
NEAR = 3
"""Images from a peak that belong to it; chosen: slow markers hardly leave their lines in so many."""
MOST_FRAMES = 200
"""Frames of a camera that are looked at, spread evenly; chosen for time."""


class StartOffsets(NamedTuple):
    """Of C cameras.

    Attributes:
        images: (C) how many images later camera c was started than the first, so that its image k belongs to image
            k + images[c] of the first.
        clearness: (C) q by (2) of the pair that ties the camera to the others; inf for the first.
        disagreeing: pairs of names that say otherwise by more than an image.
    """

    images: Ints
    clearness: Floats
    disagreeing: tuple[tuple[str, str], ...]


class _Pair(NamedTuple):
    """Cameras a and b, by how many images b's numbers lead, and q."""

    a: int
    b: int
    lead: int
    q: float


def start_offsets(detections: Detections, rig: Rig, *, most: int) -> StartOffsets:
    """How many images later each camera was started than the first.

    Args:
        detections: of all cameras, whose images are numbered from their own start.
        rig: the calibrated cameras.
        most: images that two cameras may be apart.

    Raises:
        KinemarkError: detections and rig name other cameras, or a camera's markers agree with no other's at any offset.
    """
    check_cameras(detections, rig)
    uv = ideal_pixels(detections, rig)
    pairs = [_pair(detections, rig, uv, a, b, most) for a, b in combinations(range(len(rig)), 2)]
    clear = sorted((pair for pair in pairs if pair.q >= CLEAR), key=lambda pair: -pair.q)
    lead, q = _chained(clear, len(rig))
    if lost := [name for name, found in zip(rig.names, q, strict=True) if not found]:
        raise KinemarkError(
            f"The markers of {', '.join(lost)} agree with no other camera's at any offset up to {most} images. Markers "
            "must move, in view of two cameras at once; allow more images, or check the calibration."
        )
    wrong = tuple((rig.names[p.a], rig.names[p.b]) for p in clear if abs(lead[p.b] - lead[p.a] - p.lead) > 1)
    return StartOffsets(-lead, np.array(q), wrong)


def _pair(detections: Detections, rig: Rig, uv: Floats, a: int, b: int, most: int) -> _Pair:
    """What cameras a and b tell; q is 0 where no peak is high enough."""
    score = agreement(detections, rig, uv, a, b, most)
    best = int(score.argmax())
    height = score - np.median(score)
    away = np.abs(np.arange(len(score)) - best) > NEAR
    rival = float(np.max(height, where=away, initial=1e-3))
    return _Pair(a, b, best - most, float(height[best]) / rival if height[best] >= HEIGHT else 0.0)


def agreement(detections: Detections, rig: Rig, uv: Floats, a: int, b: int, most: int) -> Floats:
    """S (2 most + 1) by (1) of cameras a and b, from −most on, of ideal pixels uv (D, 2)."""
    F, n = fundamental(rig.P[a], rig.P[b]), detections.n_frames
    start = detections.start
    total, counted = np.zeros(2 * most + 1), np.zeros(2 * most + 1)
    shown = np.flatnonzero(np.diff(start[a]))
    for f in shown[evenly(len(shown), MOST_FRAMES)]:
        first, last = max(f - most, 0), min(f + most, n - 1)
        others = uv[start[b, first] : start[b, last + 1]]
        lines = epipolar_lines(F, uv[start[a, f] : start[a, f + 1]])
        near = np.abs(lines[:, :2] @ others.T + lines[:, 2:]) < TOLERANCE
        counts = np.diff(start[b, first : last + 2])
        filled = np.flatnonzero(counts)
        if not len(filled):
            continue
        edges = (start[b, first : last + 1] - start[b, first])[filled]
        share = np.logical_or.reduceat(near, edges, axis=1).mean(0)
        at = first + filled - f + most
        total[at] += share
        counted[at] += 1
    return np.where(counted >= max(counted.max() / 4, 1), total / np.maximum(counted, 1), 0.0)


def _chained(clear: list[_Pair], n: int) -> tuple[Ints, list[float]]:
    """By how many images every camera's numbers lead those of the first, and q; 0 where no chain leads there."""
    lead, q = np.zeros(n, np.int64), [np.inf, *[0.0] * (n - 1)]
    for _ in range(n - 1):
        for pair in clear:
            if bool(q[pair.a]) != bool(q[pair.b]):
                new, old, sign = (pair.b, pair.a, 1) if q[pair.a] else (pair.a, pair.b, -1)
                lead[new], q[new] = lead[old] + sign * pair.lead, pair.q
                break
    return lead, q
