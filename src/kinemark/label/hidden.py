"""Where tracks may have taken each other's marker while nobody saw them: their neighbours say, before any name.

A gap of one track in which another one is hidden too may have been closed the wrong way. Beyond a twentieth of a second
motion hardly tells; but markers on a body keep their distances. Let p be a track before its gap and q after it, r and s
the other one, and N the tracks that are seen on all sides. That s is the same marker as p, rather than any other, has

    e(p, s) = Σ_N max( log(0.75 R / (σ √(2π))) − (m_s − m_p)² / (2 σ²),  log 0.25 )  +  motion                     (1)

nats, m the medians of the distances to N within a second of the gap, σ² their variances on both sides and what markers
are seen to, R half the size of the body, as `evidence` (1) has it of templates. Of the N those count that keep their
distance best to any of the four. An exchange gains

    G = e(p, s) + e(r, q) − e(p, q) − e(r, s)                                                                     (2)

Where the other track ends before p's gap does, or begins after it began, r or s is missing or of a third track: what is
missing tells nothing, and neither does e(r, s). G is odd in the exchange, so that exchanges that lose show how often
gaps that are none would gain.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import Trajectories
from ..data.array_types import Ints
from .beside_gaps import Beside, Parts

CLEAR = 10.0
"""|G| from which on it is told, nats; chosen on 1 177 exchanges of near markers in 20 trials, hidden for 0.05 to 0.5 s
and seen for 0.05 to 1 s beside it: 1 144 gained as much, none lost as much; of 791 others 773 and none."""
OPEN = -5.0
"""G above which it is open, nats; chosen: of the same exchanges one in a thousand lost as much, and far fewer gaps than
one in ten are exchanges."""
FEWEST = 3
"""Neighbours that tell, at least; by definition, of a place up to its mirror image."""
UNLIKELY = 15.0
"""Nats that motion may speak against an exchange for it to be looked at; chosen."""
BESIDE_S = 0.25
"""By which a track that ends may do so before another one's gap, or one that begins after it, s; chosen."""
NOBODY = -1
"""Where there is no part; by definition."""


class Hidden(NamedTuple):
    """(track, frame) before which tracks go over to another marker, and before which they may."""

    changed: set[tuple[int, int]]
    open: set[tuple[int, int]]


class _Doubt(NamedTuple):
    """Part p may go on as s, and not as p + 1, which r may go on as; NOBODY where there is none.

    Paired are r and s of one track, which follow each other.
    """

    p: int
    r: int
    s: int
    paired: bool = False

    @property
    def gaps(self) -> list[int]:
        """The parts before the gap of the one track, or of both."""
        return [self.p, self.r] if self.paired else [self.p]


def find_hidden(tracks: Trajectories, size: float, free: Ints) -> Hidden:
    """Where tracks may be other markers after a gap than before.

    Args:
        tracks: of a recording. size: of the body, mm. free: the tracks that may be cut.
    """
    xyz = tracks.xyz
    parts = Parts.of(xyz, tracks.rate, size)
    doubts = _doubts(parts)
    beside = Beside.of(xyz, parts, {p for one in doubts for p in one.gaps})
    may, most = set(free.tolist()), dict[tuple[int, int], float]()
    for one in doubts:
        gain = _gain(one, beside)
        for p in one.gaps:
            at = int(parts.track[p]), int(parts.first[p + 1])
            most[at] = max(most.get(at, -np.inf), gain)
    mine = {at: gain for at, gain in most.items() if at[0] in may}
    return Hidden(
        {at for at, gain in mine.items() if gain >= CLEAR}, {at for at, gain in mine.items() if OPEN < gain < CLEAR}
    )


def _doubts(parts: Parts) -> list[_Doubt]:
    """What motion leaves open of gaps."""
    goes_on = parts.goes_on
    begun_anew = np.append(np.ones(min(len(goes_on), 1), bool), ~goes_on[:-1])
    by_last, by_first = np.argsort(parts.last, kind="stable"), np.argsort(parts.first, kind="stable")
    lasts, firsts = parts.last[by_last], parts.first[by_first]
    slack, out = BESIDE_S * parts.rate, []
    for p in np.flatnonzero(goes_on).tolist():
        q, last, first = p + 1, parts.last[p], parts.first[p + 1]
        ends = by_last[slice(*np.searchsorted(lasts, (last - slack, first)))]
        begins = by_first[slice(*np.searchsorted(firsts, (last + 1, first + slack)))]
        ends, begins = (rows[parts.track[rows] != parts.track[p]] for rows in (ends, begins))
        both = ends[goes_on[ends] & ((parts.last[ends] > last) | ((parts.last[ends] == last) & (ends > p)))]
        r, s = ends[~goes_on[ends]], begins[begun_anew[begins]]
        stays = parts.motion(p, q)
        swap = parts.motion(p, both + 1) + parts.motion(both, q) - parts.motion(both, both + 1)
        out += [_Doubt(p, k, k + 1, paired=True) for k in both[swap - stays > -UNLIKELY].tolist()]
        out += [_Doubt(p, k, NOBODY) for k in r[parts.motion(r, q) - stays > -UNLIKELY].tolist()]
        out += [_Doubt(p, NOBODY, k) for k in s[parts.motion(p, s) - stays > -UNLIKELY].tolist()]
    return out


def _gain(one: _Doubt, beside: Beside) -> float:
    """G of (2), nats; where too few neighbours tell, what motion says against it, and of single tracks nothing."""
    p, q, r, s = one.p, one.p + 1, one.r, one.s
    sides = ((p, True), (q, False), (r, True), (s, False))
    there = beside.neighbours([side for side in sides if side[0] != NOBODY])

    def goes_on(a: int, b: int) -> float:
        if NOBODY in (a, b):
            return 0.0
        return beside.same(a, b, there) + float(beside.parts.motion(a, b))

    gain = goes_on(p, s) + goes_on(r, q) - goes_on(p, q) - (goes_on(r, s) if one.paired else 0.0)
    if len(there) < FEWEST:
        return min(gain, 0.0) if one.paired else -np.inf
    return gain
