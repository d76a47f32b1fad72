"""Where images go on in their own camera, beyond the frames in which a track has them.

Of images y_1, y_2, y_3 of frames that follow each other, the line of least squares expects the next one at

    (4 y_3 + y_2 − 2 y_1) / 3                                                             (1)

Images go on in the one that lies within some radius of that place, if it is the only one there, and if none of the
frame before is nearer to it than y_3 is (2). Others may be another marker's that passes, and merged ones are.
"""

from __future__ import annotations

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ..detection_index import Images


def images_beyond(images: Images, last: Ints, step: int, radius: Floats, r: float, most: int) -> Ints:
    """(n, most) detections in which images go on frame by frame, −1 from where they do not.

    Args:
        last: (n, 3) detections of one camera in frames that follow each other; step: 1 for later frames, −1 for
            earlier ones.
        radius: (n) px; r: px, 0 where merged images are marked.
    """
    out, last, going = np.full((len(last), most), -1), last.copy(), np.arange(len(last))
    for k in range(most):
        now = last[going]
        frame = images.frame[now[:, 2]] + step
        place = expected(*images.uv[now].swapaxes(0, 1))
        inside = (frame >= 0) & (frame < images.n_frames)
        going, now, frame, place = going[inside], now[inside], frame[inside], place[inside]
        cell = frame * len(images.P) + images.camera[now[:, 2]]
        found = _only(images, cell, place, radius[going])
        on = found >= 0
        going, now, found = going[on], now[on], found[on]
        good = alone(images, found, now[:, 2], r) & ~images.merged[found]
        going, found = going[good], found[good]
        out[going, k] = found
        last[going] = np.column_stack([now[good, 1:], found])
    return out


def expected(first: Floats, second: Floats, third: Floats) -> Floats:
    """(1) of places (…, 2) px."""
    return (4 * third + second - 2 * first) / 3


def _only(images: Images, cell: Ints, place: Floats, radius: Floats) -> Ints:
    """(n) the only image in each cell within the radius (n) px of a place (n, 2) px; −1 where there is none or more."""
    query, row = images.near(cell, place[:, 0], radius)
    close = np.hypot(*(images.uv[row] - place[query]).T) < radius[query]
    query, row = query[close], row[close]
    out = np.full(len(cell), -1)
    out[query] = row
    out[np.bincount(query, minlength=len(cell)) > 1] = -1
    return out


def alone(images: Images, found: Ints, before: Ints, r: float) -> Bools:
    """(n) whether of all images in the frame and camera of `before` (n) that one alone is near `found` (n), by (2)."""
    reach = np.maximum(np.hypot(*(images.uv[found] - images.uv[before]).T), r)
    cell = images.frame[before] * len(images.P) + images.camera[before]
    query, row = images.near(cell, images.uv[found, 0], reach)
    near = (np.hypot(*(images.uv[row] - images.uv[found[query]]).T) < reach[query]) & (row != before[query])
    return np.bincount(query, near, minlength=len(found)) == 0
