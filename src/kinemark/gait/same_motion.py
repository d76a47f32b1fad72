"""Whether two walks are one recording: a file and its copy, raw and processed, whole and cut to some of its frames.

A marker of one recording is at one place in one frame, but for what a filter and filling did to it. Files number their
frames as they like. So the middle frame of the shorter walk, x₂(m), is looked for in the longer one; that gives the
shift between both, and the distances at all frames that they share:

    s = argmin_f  median_markers |x₁(f) − x₂(m)|  −  m                                                        (1)
    d = 95th percentile over frames f of  median_markers |x₁(f + s) − x₂(f)|                                  (2)

Of one recording d is small, and small beside how far it moves,

    w = 95th percentile over frames f of  median_markers |x₂(f) − x₂(m)|                                      (3)

Nobody walks the same way twice: of two walks d is many times larger. Who stands moves by no more than d, and twice in
the same place is two recordings.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..data.array_types import Floats

SAME_MM = 5.0
"""Of (2), mm; chosen: of public walks against themselves processed, or filtered at 6 Hz and cut, it was up to 2.9; of
two recordings 58 and more."""
SAME_SHARE = 0.1
"""Of w, that d is below; chosen: of public standing trials cut in two it was 0.8 and more, of walks against themselves
processed or filtered 0.003 at most."""
FEW_FRAMES = 10
"""That two walks must share to be compared; chosen."""


def same_motion(first: Mapping[str, Floats], second: Mapping[str, Floats]) -> bool:
    """Whether both are one recording, in one world and at one frame rate.

    Args:
        first, second: (F, 3) mm by the model's names, of any number of frames.
    """
    apart, moved = motion_apart(first, second)
    return bool(apart < min(SAME_MM, SAME_SHARE * moved))


def motion_apart(first: Mapping[str, Floats], second: Mapping[str, Floats]) -> tuple[float, float]:
    """d of (2) and w of (3), mm; d is infinite where they share too little to be compared."""
    names = sorted(first.keys() & second.keys())
    if not names:
        return np.inf, 0.0
    both = (np.stack([walk[name] for name in names], axis=1) for walk in (first, second))
    short, long = sorted(both, key=len)
    if len(short) < FEW_FRAMES:
        return np.inf, 0.0
    middle = len(short) // 2
    apart = _apart(long, short[middle])
    if not np.isfinite(apart).any():
        return np.inf, 0.0
    shift = int(np.nanargmin(apart)) - middle  # (1)
    begin, end = max(-shift, 0), min(len(long) - shift, len(short))
    apart = _apart(long[begin + shift : end + shift], short[begin:end])
    return _most(apart), _most(_apart(short, short[middle]))  # (2), (3)


def _most(apart: Floats) -> float:
    """The 95th percentile of (F) mm; infinite where too few are known."""
    known = apart[np.isfinite(apart)]
    return float(np.percentile(known, 95)) if len(known) >= FEW_FRAMES else np.inf


def _apart(one: Floats, other: Floats) -> Floats:
    """(F) mm, the (lower) median over the markers that both have of how far apart they are; NaN where there is none."""
    apart = np.sort(np.linalg.norm(one - other, axis=-1), axis=-1)  # NaN comes last
    middle = np.maximum(np.isfinite(apart).sum(axis=-1, keepdims=True) - 1, 0) // 2
    return np.take_along_axis(apart, middle, axis=-1)[..., 0]
