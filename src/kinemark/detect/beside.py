"""Markers where a ground was subtracted, moved by what lies beside them that is not that ground.

A limb hides a lamp, and lets its own light be seen. So of what is behind a marker, B, some is left where the ground g
was subtracted: B − g. At the rim a pixel of which the marker covers the share c has (1 − c)(B − g) of it, which draws
the centroid to the brighter side. With q = (B − g) / C of the marker's contrast C, seen in `DIRECTIONS` n round it, no
more than `MOST`, as a rim is not darker than nothing, the marker lies at its centroid less

    s = RIM ⟨q n⟩                                                       (1)

for a rim of RIM / 2 px. Light that hides nothing, as glare, adds ½ r ⟨q n⟩ of a disc of radius r (2). How wide the rim
is, and what lies behind the disc itself, is known badly, so the centre gets the covariance

    |s| (ALONG s sᵀ / |s|² + ACROSS 1)                                   (3)

which grows as |s|: small shifts are due to slopes, large ones to edges, of which the place matters.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats, GreyLevels, Ints
from .blobs import Blobs
from .ground import Ground, negative

TURN = 2 * np.pi * np.arange(16) / 16
DIRECTIONS = np.stack([np.cos(TURN), np.sin(TURN)], -1)
"""(16, 2) without unit; chosen: some 1.5 px apart round a marker of 4 px."""
BEYOND = 2.0, 3.0  # px outside of a marker's outline; chosen: the first lie outside of its blurred rim
MOST = 0.3  # of the marker's contrast; chosen by simulated walks before lamps, docs/theory/detect.md
RIM = 4.0  # px; chosen likewise
ALONG, ACROSS = 0.07, 0.02  # px; chosen likewise


def moved(blobs: Blobs, images: GreyLevels, rest: GreyLevels, ground: Ground, *, first: int, aspect: float) -> Blobs:
    """Detections of frames (n, H, W), of which the first has this number, by (1) to (3); px.

    Args:
        blobs: as they were found in `rest`.
        images: as they were recorded.
        rest: the same without the ground.
        ground: that was taken away.
        first: number of the first frame.
        aspect: height of a round marker's image by its width.
    """
    some = np.flatnonzero(np.isfinite(blobs.cov).all((1, 2)))  # no more is said of what is too large
    frame = np.repeat(np.arange(len(images)), blobs.counts)[some]
    uv, radius = blobs.uv[some], np.sqrt(blobs.area[some] / (np.pi * aspect))
    dark = negative(images, ground.white), negative(rest, ground.white), ground
    contrast = np.maximum(_beyond_ground(*dark, frame, first, uv[:, None])[:, 0], 1.0)[:, None]
    outside = np.stack([(radius + more)[:, None, None] * DIRECTIONS for more in BEYOND], 1) * [1, aspect]
    round_it = uv[:, None] + outside.reshape(len(uv), -1, 2)
    beside = _beyond_ground(*dark, frame, first, round_it).reshape(len(uv), len(BEYOND), -1).mean(1)
    beside = np.where(beside > contrast / 2, 0.0, beside)  # another marker
    reach = RIM + (radius / 2 if ground.times is None else 0 * radius)  # (2)
    shift = np.clip(beside / contrast, -MOST, MOST) @ DIRECTIONS / len(DIRECTIONS) * reach[:, None] * [1, aspect]  # (1)
    far = np.maximum(np.linalg.norm(shift, axis=1), 1e-9)[:, None, None]
    blobs = blobs._replace(uv=blobs.uv.copy(), cov=blobs.cov.copy())
    blobs.uv[some] -= shift
    blobs.cov[some] += ALONG * shift[:, :, None] * shift[:, None] / far + ACROSS * far * np.eye(2)  # (3)
    return blobs


def _beyond_ground(
    images: GreyLevels, rest: GreyLevels, ground: Ground, frame: Ints, first: int, places: Floats
) -> Floats:
    """(G, K) grey levels by which images are above the ground, or below it, at places (G, K, 2) px of frames (G)."""
    row, column = np.clip(np.rint(places[..., ::-1]).astype(np.int64).T, 0, np.array(images.shape[1:])[:, None, None] - 1)
    light = ground.light[(frame + first) % len(ground.light), row, column].astype(np.float64) + ground.level
    below, above = images[frame, row, column] - light, rest[frame, row, column].astype(np.float64) - ground.level
    return np.where(below < 0, below, np.maximum(above, 0.0)).T
