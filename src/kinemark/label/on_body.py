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
    out = np.ones(xyz.shape[1], bool)
    for m in np.flatnonzero(~named).tolist():
        frames = np.isfinite(xyz[:, m, 0])
        y = xyz[frames].astype(float)
        told = named & (np.isfinite(y[..., 0]).mean(0) >= TOGETHER) if len(y) else named & False
        if len(y) >= LEAST_FRAMES and told.sum() > THIRD + 1:
            loosest = max(_third_spread(y[:, told], y[:, a]) for a in np.flatnonzero(told).tolist())
            out[m] = _third_spread(y[:, told], y[:, m]) <= LOOSER * loosest
    return out


def _third_spread(y: Floats, own: Floats) -> float:
    """s of a marker (K, 3) among the named (K, N, 3), mm, without its distance to itself."""
    d = np.linalg.norm(y - own[:, None], axis=2)
    seen = np.isfinite(d)
    n = np.maximum(seen.sum(0), 1)
    mean = np.where(seen, d, 0.0).sum(0) / n
    spread = np.sqrt(np.where(seen, (d - mean) ** 2, 0.0).sum(0) / n)
    return float(np.sort(spread[mean > 0])[THIRD])
