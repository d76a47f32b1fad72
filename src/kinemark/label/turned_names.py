"""Names of two markers that change places at once: what each is far from and near to turns round.

With d_ak the distance of markers a and k, both seen, and

    w(t) = ( d_ak(t) − d_bk(t) )_k                                                                                (1)

over the nearest others k, names are exchanged between frames p and q where w turns round. While markers are seen they
move little from frame to frame, and w with them, so that names that are right never do

    w(p) · w(q) < −c |w|²,   w(p) · w(q) < −s max ( w(p)², w(q)² )                                                (2)

with |w|² the median of the trial. Where two markers meet w is small, and turns round without telling anything.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from ..numerics.evenly import evenly_rounded
from ..numerics.vectors import lengths

TURNED, SAME = 0.1, 0.5
"""c and s of (2); chosen: of two that turn round each other w is near 0 where it turns."""
AT_ONCE_S = 0.2
"""How long a change of names takes at most, s; chosen: gaps that were filled across one are mostly shorter."""
NEAREST = 8
"""Markers k; chosen: over a gap w of the pelvis's markers turns round with those of feet."""
USUAL = 100
"""Frames by which |w|² is told; chosen."""


def names_turn(xyz: Floats, two: tuple[int, int], between: tuple[int, int], rate: float) -> bool:
    """Whether (2) holds of two frames at most `AT_ONCE_S` apart, or that adjoin a gap of either marker.

    Args:
        xyz: (F, L, 3) mm. two: markers. between: the first frame and the last that are looked at. rate: Hz.
    """
    seen = np.flatnonzero(np.isfinite(xyz[:, two, 0]).all(1))
    if len(seen) < 2:
        return False
    usual = seen[evenly_rounded(len(seen), USUAL)]
    near = _near(xyz[usual], two)
    size = float(np.nanmedian(_mean(_apart(xyz, two, near, usual) ** 2)))
    most = int(AT_ONCE_S * rate)
    first = max(int(np.searchsorted(seen, between[0] - most)) - 1, 0)
    w = _apart(xyz, two, near, seen[first : int(np.searchsorted(seen, between[1] + most, side="right")) + 1])
    lags = _lags(most, len(w))
    return any(bool(_turned(w[:-lag], w[lag:], size).any()) for lag in lags)


def _turned(before: Floats, after: Floats, size: float) -> Bools:
    """(n) whether (2) holds of w (n, K) before and after."""
    both = np.isfinite(before) & np.isfinite(after)
    before, after = np.where(both, before, np.nan), np.where(both, after, np.nan)
    alike = _mean(before * after)
    return (alike < -TURNED * size) & (alike < -SAME * np.maximum(_mean(before**2), _mean(after**2)))


def _lags(most: int, n: int) -> list[int]:
    """1, 2, 4, … frames, to the most that n frames have."""
    return [lag for lag in (2**k for k in range(16)) if lag < n and (lag == 1 or lag <= most)]


def _near(y: Floats, two: tuple[int, int]) -> Ints:
    """The markers nearest to either of two, of places (F, L, 3)."""
    distance = _mean(np.minimum(*(lengths(y - y[:, [a]]) for a in two)).T)
    distance[list(two)] = np.nan
    return np.asarray(np.argsort(distance, kind="stable")[: min(NEAREST, int(np.isfinite(distance).sum()))])


def _apart(xyz: Floats, two: tuple[int, int], near: Ints, frames: Ints) -> Floats:
    """(n, K) w of (1), NaN of markers that are not seen."""
    y = xyz[frames][:, near]
    return np.asarray(lengths(xyz[frames, two[0], None] - y) - lengths(xyz[frames, two[1], None] - y))


def _mean(w: Floats) -> Floats:
    """(n) of (n, K), NaN where nothing is known."""
    known = np.isfinite(w)
    n = known.sum(1)
    return np.where(n > 0, np.where(known, w, 0.0).sum(1) / np.maximum(n, 1), np.nan)
