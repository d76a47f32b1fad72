"""Reliable reference markers of a gap: those that do not jump there.

A marker that is swapped, reflected or half hidden for some frames jumps against the markers of its own body part, and
what is filled from it jumps along. With D_k(f) the distance of a reference marker from another marker k, it is left out
of a gap when for most of the NEAR markers k whose distance from it varies least

    max |D_k(f + 1) − D_k(f)| > JUMP   and   > TIMES what that is elsewhere in all but OFTEN of the frames   (1)
    D_k leaves the range that it has elsewhere, in all but OFTEN of the frames, by more than AWAY            (2)

within the gap and at its edges. A fast movement is neither: it takes the neighbours along; (1) alone it may be, in the
fastest moment of a trial. Only reference markers whose own path bends by more than JUMP from one frame to the next,
|x(f − 1) − 2 x(f) + x(f + 1)|, are looked at (3), as a jump of that size is such a bend.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Bools, Floats
from .marker_array import Gap, MarkerArray
from .reference_ranking import Ranks

NEAR = 4  # markers whose distance is watched; chosen (see benchmarks/gaps.py)
JUMP = 5.0
"""mm from one frame to the next; chosen (see benchmarks/gaps.py)."""
AWAY = 10.0
"""mm beyond the usual range of a distance, of (2); chosen (see benchmarks/gaps.py)."""
TIMES = 3.0  # times the usual step; chosen
OFTEN = 0.02  # of the frames, at most, in which a distance is unusual; chosen (see benchmarks/gaps.py)


class JumpingMarkers:
    """Which markers of a trial are reliable in a gap; bends are worked out once, distances where they are needed."""

    def __init__(self, motion: MarkerArray, ranks: Ranks) -> None:
        """Of a trial and the order of its markers."""
        self.motion, self.ranks = motion, ranks
        x = motion.xyz
        self.bends: Bools = np.zeros(x.shape[:2], np.bool_)
        with np.errstate(invalid="ignore", over="ignore"):
            self.bends[:, 1:-1] = np.square(x[:, 2:] - 2 * x[:, 1:-1] + x[:, :-2]).sum(-1) > JUMP**2  # (3)

    def of(self, gap: Gap) -> Bools:
        """(M) False for the markers that jump in a gap."""
        frames = slice(max(gap.start - 1, 0), gap.stop + 1)
        out: Bools = ~np.logical_or.reduce(self.bends[:, frames], axis=1)
        for marker in np.flatnonzero(~out):
            out[marker] = not self._jumps(int(marker), gap)
        return out

    def _jumps(self, marker: int, gap: Gap) -> bool:
        """(1) and (2) for most of its neighbours."""
        x = self.motion.xyz
        others = self.ranks.of(marker)
        known = ~np.isnan(x[others, gap.start : gap.stop, 0]).any(1)
        near = [k for k in others[known] if k != gap.marker][:NEAR]
        odd, wanted = 0, len(near) // 2 + 1
        for at, k in enumerate(near):
            if odd + len(near) - at < wanted:  # the others cannot make it most
                return False
            odd += _odd(x[marker] - x[k], gap)
        return len(near) > 1 and odd >= wanted


def _odd(apart: Floats, gap: Gap) -> bool:
    """(1) and (2) for the difference (F, 3) of a marker and one neighbour."""
    first = max(gap.start - 1, 0)
    inside = np.abs(np.diff(np.linalg.norm(apart[first : gap.stop + 1], axis=1)))
    most = np.nanmax(inside, initial=0.0)
    if most <= JUMP:  # as nearly always: what is usual elsewhere is not asked
        return False
    distance = np.linalg.norm(apart, axis=1)
    step = np.abs(np.diff(distance))
    outside = _known(step[:first], step[gap.stop :])
    here, elsewhere = distance[gap.start : gap.stop], _known(distance[: gap.start], distance[gap.stop :])
    if not len(outside) or most <= TIMES * np.quantile(outside, 1 - OFTEN):  # (1)
        return False
    low, high = np.quantile(elsewhere, [OFTEN / 2, 1 - OFTEN / 2])
    return bool(max(low - here.min(), here.max() - high) > AWAY)  # (2)


def _known(*parts: Floats) -> Floats:
    whole = np.concatenate(parts)
    return whole[np.isfinite(whole)]
