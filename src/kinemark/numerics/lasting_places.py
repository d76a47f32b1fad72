"""Places at which something is seen from the beginning of a recording to its end."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..data.array_types import Floats, Ints
from .evenly import scattered

LOOKED_AT = 60
"""Frames in which places are looked for; chosen: one is seen in twelve."""

PRESENT = 0.2
"""Of these frames the share in which a place has an image, and half of it in the first and in the last third of them;
chosen: reflections flicker, and whoever walks stands on a foot for a part of the recording only."""


def lasting_places(uv: Floats, frame: Ints, n_frames: int, near: float) -> Ints:
    """A row of the images uv (N, 2) px of one camera, of frames (N), at each such place; near (px) are those of one."""
    frames = scattered(n_frames, LOOKED_AT)
    rows = np.flatnonzero(np.isin(frame, frames))
    if not len(rows):
        return rows
    when = np.searchsorted(frames, frame[rows])
    pairs = cKDTree(uv[rows]).query_pairs(near, output_type="ndarray")
    pairs = np.concatenate([pairs, pairs[:, ::-1], np.arange(len(rows))[:, None].repeat(2, 1)])
    seen = np.zeros((len(rows), len(frames)), bool)
    seen[pairs[:, 0], when[pairs[:, 1]]] = True
    thirds = (part.mean(1) >= PRESENT / 2 for part in np.array_split(seen, 3, axis=1)[::2])
    stands = (seen.mean(1) >= PRESENT) & np.logical_and(*thirds)
    pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    first = np.searchsorted(pairs[:, 0], np.arange(len(rows) + 1))
    found = list[int]()
    for k in np.argsort(-seen.sum(1), kind="stable").tolist():
        if stands[k]:
            found.append(k)
            stands[pairs[first[k] : first[k + 1], 1]] = False
    return rows[found]
