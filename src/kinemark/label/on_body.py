"""Which chains of tracks without a name are a marker on the body, and which are ghosts.

A marker that nobody named sits on a segment, so that it keeps its distance to other markers there. A point that wanders
past, stands still in the room, or lies midway between two markers of different segments does not. With s_m the third
smallest standard deviation of the distances from m to markers with a name, m counts as on the body where

    s_m ≤ 1.5 · max over markers a with a name of s_a                                                             (1)

all over the frames in which m is seen: as well as the loosest of the named ones does meanwhile. Nothing in it hangs on
the template, nor on how the subject moves, and names that are wrong for whole markers change nothing.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Bools, Floats
from ..numerics.vectors import lengths
from .evidence import Single

THIRD = 2
"""Which of the standard deviations in order, from 0; chosen: three distances place a point."""
LOOSER = 1.5
"""Of (1); chosen on shreds other:9000-9060: of 44 extra markers all have at most 1.24, of 23 chains of ghosts 17 have
1.9 to 18, the others are seen for 0.15 s or a little more."""
LEAST_FRAMES = 3
"""In which a chain must be seen for anything to be said; chosen: of fewer nothing has a spread."""
TOGETHER = 0.5
"""Share of these frames in which a marker must be seen too to have a say; chosen."""


def on_body(xyz: Single, named: Bools) -> Bools:
    """(M) whether markers are on the body; those with a name are, and what is seen too little to tell.

    Args:
        xyz: (K, M, 3) mm, NaN where not seen. named: (M) markers with a name.
    """
    out, free = np.ones(xyz.shape[1], bool), np.flatnonzero(~named)
    if named.sum() <= THIRD + 1:
        return out
    y, body = xyz[:, free].astype(float), xyz[:, named].astype(float)
    frames = np.isfinite(y[..., 0]).T.astype(float)
    n = frames.sum(1)
    told = frames @ np.isfinite(body[..., 0]) >= TOGETHER * np.maximum(n, 1)[:, None]
    own = _third_spread(lengths(y[:, :, None] - body[:, None]), np.ones((1, len(xyz))), told)
    each = _third_spread(lengths(body[:, :, None] - body[:, None]), frames, told[:, None])
    loosest = np.where(told & np.isfinite(each), each, 0.0).max(1, initial=0.0)
    out[free] = (n < LEAST_FRAMES) | (told.sum(1) <= THIRD + 1) | (own[0] <= LOOSER * loosest)
    return out


def _third_spread(d: Floats, frames: Floats, told: Bools) -> Floats:
    """(F, M) s of markers, mm, from their distances (K, M, N) to the named, over F choices of frames (F, K).

    From those of them that have a say, (F, 1 or M, N), without the distance to itself; infinite of fewer than three.
    """
    seen = np.isfinite(d)
    n = np.maximum(np.tensordot(frames, seen.astype(float), 1), 1.0)
    middle = np.where(seen, d, 0.0).sum(0) / np.maximum(seen.sum(0), 1)
    off = np.where(seen, d - middle, 0.0)  # squares of what is left are exact enough to be subtracted
    mean, square = np.tensordot(frames, off, 1) / n, np.tensordot(frames, off**2, 1) / n
    spread = np.sqrt(np.maximum(square - mean**2, 0.0))
    spread = np.where(told & (middle > 0), spread, np.inf)
    return np.asarray(np.sort(spread, axis=-1)[..., THIRD])
