"""Stitches over wide gaps that companions contradict are undone.

Where motion leaves more than `uncertain_sd` open, a stitch is made by the mean distances from a few other tracks (2 of
`stitch`). A marker on the same limb has nearly the same. Companions as they are next to the gap, with their standard
deviations, tell more of these: the stitch stays where its score and theirs, by (1) of `companions`, are together at
least LEAST. Either alone tells less: neighbours that bend or swing contradict many that are right.

Companions are tracks as they are before any wide gap is stitched.
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Floats, Ints
from .companions import Pairs, scored
from .neighbouring_points import TrackPoints, rows_of
from .simultaneous_method import Simultaneous
from .stitch import CLEAR_MARGIN, Stitch, Stitched, identities_after

LEAST = 15.0
"""Least sum of both scores, in units of (1) of `stitch`; chosen: of 1 941 stitches over wide gaps (seeds 810001 to
811340 of benchmarks/tracking_scenes.py), 48 have less, of which 12 join two markers, and of the others 19."""


def without_contradicted(points: TrackPoints, whole: Stitched, T: float, method: Simultaneous) -> Stitched:
    """The stitches of P points of tracks without those that companions contradict; T s between frames."""
    made = [one for one in whole.stitches if one.margin > CLEAR_MARGIN]
    wide = [one for one in made if one.sd > method.uncertain_sd and one.first - one.last > 1]
    if not wide:
        return whole
    ids = identities_after(np.arange(len(whole.id)), [one for one in made if one not in wide])
    told = _told(points._replace(id=ids[points.id]), ids, wide, T)
    contradicted = {wide[k] for k in np.flatnonzero(told < LEAST).tolist()}
    ids = identities_after(ids, [one for one in wide if one not in contradicted])
    return Stitched(ids, [one for one in whole.stitches if one not in contradicted])


def _told(points: TrackPoints, ids: Ints, wide: list[Stitch], T: float) -> Floats:
    """(n) the sums of both scores; infinite where too few companions are there on both sides."""
    name, number = np.unique(points.id, return_inverse=True)
    points = points._replace(id=number)  # a table of tracks that are there no more would be most of the memory
    before, after = (np.searchsorted(name, ids[end]) for end in np.array([(one.before, one.after) for one in wide]).T)
    pairs = Pairs(before, after, *np.zeros((2, len(wide))))
    by_companions = scored(points, rows_of(points), np.arange(len(name)), pairs, T).score
    return np.array([one.score for one in wide]) + np.where(np.isfinite(by_companions), by_companions, np.inf)
