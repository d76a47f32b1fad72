"""Pieces that lie beside the place of their marker, as ghosts in a marker's gap do.

A ghost 20 to 60 mm beside a marker that is not seen has most distances of that marker to within their spread, and no
other piece of the trial contradicts it. But the marker's other pieces tell where it belongs among the markers that it
moves with. Its core are its longest pieces, that together have half of its samples. With b and the shape G of the
covariance that `body_places` (1, 2) foretells, from the marker's figure, and s such that

    d² = (p − b)ᵀ G⁻¹ (p − b) / s²                                                                                 (1)

of the core has the median and the 95 % quantile of χ² with three degrees of freedom or less, a piece is beside where
the median of its d² is above that quantile, and it does not go on by motion from the marker's other pieces: a posture
that the core did not show is reached step by step.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from .body_places import LEAST_MM, QUANTILES, Figure, distance, figures, foretold
from .leaps import leaping, marker_places
from .stretches import GRID_HZ, Stretches
from .sweeps import GOES_ON, continuity
from .template import Template

CORE = 0.5
"""Share of a marker's samples that its core has; by definition of a label that is right, as `margin.MOST_OF_LABEL`."""
LEAST_ROWS = 8
"""Of the sampled frames in which the core must be seen for s to be known; chosen: half a second."""
RARE = max(QUANTILES)
"""The quantile of (1); by definition."""
AT_ONCE = 13.0
"""Nats from which on a piece goes on where another of its marker ends, and does not leap; chosen: right pieces that
begin in the next frame have 13.2 and more at 100 Hz, of 63 ghosts in gaps with sure names 54 have less."""


def beside_their_places(stretches: Stretches, label: Ints, template: Template) -> Bools:
    """(T) whether pieces lie beside the place of the marker that they are called; label (T), −1 for none."""
    out = np.zeros(len(label), bool)
    own = np.unique(label[label >= 0])
    several = np.isin(label, own[np.bincount(label[label >= 0])[own] > 1])
    goes_on = continuity(stretches, label, len(template))[np.arange(len(label)), label]
    asked = several & (goes_on < AT_ONCE)
    if not asked.any():
        return out
    core = _core(stretches, label)
    xyz, known = (marker_places(stretches, of, own) for of in (label, core))
    learnt = figures(xyz, own, template, GRID_HZ, np.searchsorted(own, label[asked]))
    every = [_widened(one, xyz, known[one.marker]) for one in learnt]
    every = [one for one in every if np.isfinite(one[0].spread)]
    for figure, square in every:
        pieces = (label == own[figure.marker]) & (label != core) & (goes_on < GOES_ON)
        for t in np.flatnonzero(pieces).tolist():
            rows = square[np.isfinite(stretches.xyz[t, :, 0])]
            rows = rows[np.isfinite(rows)]
            out[t] = len(rows) > 0 and np.median(rows) > QUANTILES[RARE]
    return out | leaping(stretches, label, own, [one for one, _ in every], known, asked)


def _core(stretches: Stretches, label: Ints) -> Ints:
    """(T) labels of the longest pieces, that have half of their label's samples; −1 of the others."""
    n, core = stretches.seen.sum(1), np.full(len(label), -1)
    for a in np.unique(label[label >= 0]).tolist():
        of = np.flatnonzero(label == a)
        of = of[np.argsort(-n[of], kind="stable")]
        core[of[np.cumsum(n[of]) - n[of] < CORE * n[of].sum()]] = a
    return core


def _widened(figure: Figure, xyz: Floats, core: Floats) -> tuple[Figure, Floats]:
    """The figure with s of (1), mm, infinite where it is not known, and (K) d² of its marker.

    Args:
        xyz: (M, K, 3) of markers, and core: (K, 3) of this one, mm.
    """
    place, G = foretold(figure, xyz[figure.near])
    known = distance(core, place, G)
    known = known[np.isfinite(known)]
    if len(known) < LEAST_ROWS:
        return figure._replace(spread=np.inf), np.full(len(place), np.nan)
    s2 = max(LEAST_MM**2, *(float(np.quantile(known, q)) / QUANTILES[q] for q in (0.5, RARE)))
    return figure._replace(spread=s2**0.5), distance(xyz[figure.marker], place, s2 * G)
