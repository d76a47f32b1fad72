"""Markers where a ground was subtracted, moved by what lies beside them that is not that ground.

A limb hides a lamp, and lets its own light be seen. So of what is behind a marker, B, some is left where the ground g
was subtracted: B − g. At the rim a pixel of which the marker covers the share c has (1 − c)(B − g) of it, which draws
the centroid to the brighter side. With q = (B − g) / C for the marker's contrast C, seen in `DIRECTIONS` n round it,
and no more than `MOST`, as a rim is not darker than nothing, and none where another marker lies, the marker lies at
its centroid less

    s = RIM ⟨q n⟩                                                       (1)

for a rim of RIM / 2 px. Light that hides nothing, as glare, adds ½ r ⟨q n⟩ of a disc of radius r (2). How wide the rim
is, and what lies behind the disc itself, is known badly. So the centre gets the covariance

    |s| (ALONG s sᵀ / |s|² + ACROSS 1)                                   (3)

which grows as |s|: small shifts are due to slopes, large ones to edges, of which the place matters. Where the ground
is so bright that the marker would not stand out before it, some of the marker may be lost. With l = 1 in these
directions, else 0, that adds

    r² ⟨l n⟩ ⟨l n⟩ᵀ                                                      (4)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats, GreyLevels, Ints
from .ground import PARTS, Ground, negative
from .separate import Suspects

TURN = 2 * np.pi * np.arange(16) / 16
"""(16) rad, of which the first points to the right; chosen: some 1.5 px apart round a marker of 4 px."""
DIRECTIONS = np.stack([np.cos(TURN), np.sin(TURN)], -1)
"""(16, 2) of unit length; by definition of `TURN`."""
BEYOND = 2.0, 3.0  # px outside of a marker's outline; chosen: the first lie outside of its blurred rim
FARTHER = 4.5, 6.0  # px outside of it, where a marker lies whose rim is seen nearer; chosen: no gap between the rings
MOST = 0.3  # of the marker's contrast; chosen by simulated walks before lamps, docs/theory/detect.md
RIM = 4.0  # px, twice the width of a blurred rim; chosen by the same walks
ALONG, ACROSS = 0.03, 0.01  # px of variance for a px of shift; chosen by the same walks


class Seen(NamedTuple):
    """Pixels of places (G, K) as they were recorded, markers bright.

    Attributes:
        light: (G, K) grey levels of the learned ground.
        beyond: (G, K) grey levels by which the image is above that ground, or below it.
        times: (G, K) that what is above counts.
    """

    light: Floats
    beyond: Floats
    times: Floats


def moved(
    part: Suspects, images: GreyLevels, rest: GreyLevels, ground: Ground, *, first: int, aspect: float
) -> Suspects:
    """What was found in frames (n, H, W), of which the first has this number, by (1) to (4).

    Args:
        part: as it was found in `rest`.
        images: as they were recorded.
        rest: the same without the ground.
        ground: that was taken away.
        first: number of the first frame.
        aspect: height of a round marker's image by its width.
    """
    blobs = part.blobs
    some = np.flatnonzero(np.isfinite(blobs.cov).all((1, 2)))  # no more is said of what is too large
    frame = np.repeat(np.arange(len(images)), blobs.counts)[some]
    uv, r = blobs.uv[some], np.sqrt(blobs.area[some] / (np.pi * aspect))[:, None]
    middle = _seen(images, rest, ground, frame, first, uv[:, None])
    rings = [_seen(images, rest, ground, frame, first, _round(uv, r + more, aspect)) for more in BEYOND]
    round_it = Seen(*(np.mean(column, axis=0) for column in zip(*rings, strict=True)))
    contrast = np.maximum(middle.beyond, 1.0)
    farther = [_seen(images, rest, ground, frame, first, _round(uv, r + more, aspect)) for more in FARTHER]
    beside = np.where(_markers([ring.beyond for ring in rings + farther], contrast), 0.0, round_it.beyond)
    shift = _shift(beside / contrast, r, ground.times is None)  # (1)
    far = np.maximum(np.linalg.norm(shift, axis=1), 1e-9)[:, None, None]
    cov = ALONG * _squares(shift) / far + ACROSS * far * np.eye(2)  # (3)
    marker = middle.light + middle.beyond / middle.times
    lost = (marker - round_it.light) * round_it.times < _least(part, ground)
    cov += _squares(r * (lost @ DIRECTIONS) / len(TURN))  # (4)
    blobs = blobs._replace(uv=blobs.uv.copy(), cov=blobs.cov.copy())
    blobs.uv[some] -= shift * [1, aspect]
    blobs.cov[some] += cov * np.outer([1, aspect], [1, aspect])
    return part._replace(blobs=blobs)


def _markers(rings: list[Floats], contrast: Floats) -> Bools:
    """(G, 16) directions in which another marker lies, or beside which one does: its rim is no light behind."""
    there = np.max(rings, axis=0) > contrast / 2
    return there | np.roll(there, 1, 1) | np.roll(there, -1, 1)


def _shift(q: Floats, r: Floats, adds: bool) -> Floats:
    """(G, 2) px by (1), and (2) where light adds to what is behind it."""
    return (RIM + (r / 2 if adds else 0.0)) * (np.clip(q, -MOST, MOST) @ DIRECTIONS) / len(TURN)


def _least(part: Suspects, ground: Ground) -> float:
    """Grey levels by which a white pixel is above the ground at least."""
    white = 0 if part.negative is None or ground.white is None else part.negative - ground.white
    return part.threshold - white - ground.level


def _round(uv: Floats, r: Floats, aspect: float) -> Floats:
    """(G, K, 2) px, places at distances (G, 1) from centres (G, 2)."""
    return uv[:, None] + r[..., None] * DIRECTIONS * [1, aspect]


def _squares(rows: Floats) -> Floats:
    """(G, 2, 2) of rows (G, 2)."""
    return rows[:, :, None] * rows[:, None]


def _seen(images: GreyLevels, rest: GreyLevels, ground: Ground, frame: Ints, first: int, places: Floats) -> Seen:
    """Pixels at places (G, K, 2) of frames (G); beyond the image those at its edge."""
    row, column = (
        np.clip(np.rint(places[..., axis]).astype(np.int64), 0, images.shape[2 - axis] - 1) for axis in (1, 0)
    )
    at, field = (frame[:, None], row, column), ((frame + first)[:, None] % len(ground.light), row, column)
    light = ground.light[field].astype(np.float64) + ground.level
    below = negative(images[at], ground.white) - light
    above = np.maximum(negative(rest[at], ground.white).astype(np.float64) - ground.level, 0.0)
    times = np.ones(light.shape) if ground.times is None else ground.times[field] / PARTS
    return Seen(light, np.where(below < 0, below, above), times)
