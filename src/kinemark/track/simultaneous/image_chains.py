"""Where images go on in their own camera, beyond the frames in which a track has them.

Of images y_1, y_2, y_3 of frames that follow each other, the line of least squares expects the next one at

    (4 y_3 + y_2 − 2 y_1) / 3                                                             (1)

Images go on in the one that lies within some radius of that place, if it is the only one there, and if none of the
frame of y_3 is nearer to it than y_3 is (2). Others may be another marker's that passes, and merged ones are.

A marker may be hidden for a moment, or drop out. Over such a hole, of frames without any image there, the line of the
last three images, at times t_i with the mean t̄, expects the next one at

    Σ w_i y_i,   w_i = 1 / 3 + (t − t̄) (t_i − t̄) / Σ (t_j − t̄)²                            (3)

which is (1) without a hole, and the radius grows with the standard deviation √(1 + Σ w_i²).
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from .detection_index import Images

OTHERS = -2
"""Stands for an image, where there are several, or one that may be another marker's; by definition."""


def images_beyond(images: Images, last: Ints, step: int, radius: Floats, r: float, most: int, hole: int = 0) -> Ints:
    """(n, most) detections in which images go on frame by frame, −1 in holes, and from where they do not.

    Args:
        last: (n, 3) detections of one camera in frames that follow each other; step: 1 for later frames, −1 for
            earlier ones.
        radius: (n) px, in the frame after an image; r: px, 0 where merged images are marked.
        hole: frames without an image that they go on over, a number at most.
    """
    out, last, going = np.full((len(last), most), -1), last.copy(), np.arange(len(last))
    first = images.frame[last[:, 2]]
    for k in range(most):
        frame = first[going] + step * (k + 1)
        near = np.abs(frame - images.frame[last[going, 2]]) <= hole + 1
        near &= (frame >= 0) & (frame < images.n_frames)
        going, frame = going[near], frame[near]
        found = _next(images, last[going], frame, radius[going], r)
        on, image = going[found >= 0], found[found >= 0]
        out[on, k] = image
        last[on] = np.column_stack([last[on, 1:], image])
        going = going[found != OTHERS]
    return out


def _next(images: Images, last: Ints, frame: Ints, radius: Floats, r: float) -> Ints:
    """(n) the image in each frame (n) in which the last (n, 3) go on; −1 where there is none, OTHERS where it may be
    another marker's."""
    place, wider = _expected_at(images, last, frame)
    cell = frame * len(images.P) + images.camera[last[:, 2]]
    found = _only(images, cell, place, wider * radius)
    on = np.flatnonzero(found >= 0)
    good = alone(images, found[on], last[on, 2], r) & ~images.merged[found[on]]
    found[on[~good]] = OTHERS
    return found


def _expected_at(images: Images, last: Ints, frame: Ints) -> tuple[Floats, Floats]:
    """(3) in frames (n) of the last (n, 3) detections, px (n, 2), and how much wider (n) than without a hole."""
    t = images.frame[last].astype(np.float64)
    middle = t.mean(1, keepdims=True)
    weight = 1 / 3 + (frame[:, None] - middle) * (t - middle) / ((t - middle) ** 2).sum(1, keepdims=True)
    place = np.einsum("nk,nki->ni", weight, images.uv[last])
    return place, np.sqrt((1 + (weight**2).sum(1)) / (10 / 3))


def expected(first: Floats, second: Floats, third: Floats) -> Floats:
    """(1) of places (…, 2) px."""
    return (4 * third + second - 2 * first) / 3


def _only(images: Images, cell: Ints, place: Floats, radius: Floats) -> Ints:
    """(n) the only image in each cell within the radius (n) px of a place (n, 2) px; −1 where there is none, OTHERS where
    there are more."""
    query, row = images.near(cell, place[:, 0], radius)
    close = np.hypot(*(images.uv[row] - place[query]).T) < radius[query]
    query, row = query[close], row[close]
    out = np.full(len(cell), -1)
    out[query] = row
    out[np.bincount(query, minlength=len(cell)) > 1] = OTHERS
    return out


def alone(images: Images, found: Ints, before: Ints, r: float) -> Bools:
    """(n) whether of all images in the frame and camera of `before` (n) that one alone is near `found` (n), by (2)."""
    reach = np.maximum(np.hypot(*(images.uv[found] - images.uv[before]).T), r)
    cell = images.frame[before] * len(images.P) + images.camera[before]
    query, row = images.near(cell, images.uv[found, 0], reach)
    near = (np.hypot(*(images.uv[row] - images.uv[found[query]]).T) < reach[query]) & (row != before[query])
    return np.bincount(query, near, minlength=len(found)) == 0
