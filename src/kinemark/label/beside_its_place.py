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
from .stretches import GRID_HZ, Stretches
from .sweeps import GOES_ON, continuity, places
from .template import Template

CORE = 0.5
"""Share of a marker's samples that its core has; by definition of a label that is right, as `margin.MOST_OF_LABEL`."""
LEAST_ROWS = 8
"""Of the sampled frames in which the core must be seen for s to be known; chosen: half a second."""
RARE = max(QUANTILES)
"""The quantile of (1); by definition."""


def beside_their_places(stretches: Stretches, label: Ints, template: Template) -> Bools:
    """(T) whether pieces lie beside the place of the marker that they are called; label (T), −1 for none."""
    out = np.zeros(len(label), bool)
    own = np.unique(label[label >= 0])
    core = _core(stretches, label)
    goes_on = continuity(stretches, label, len(template))[np.arange(len(label)), label]
    asked = np.flatnonzero((label >= 0) & (label != core) & (goes_on < GOES_ON))
    if not len(asked):
        return out
    xyz, known = (places(stretches, of, len(template))[:, own].swapaxes(0, 1).astype(float) for of in (label, core))
    for figure in figures(xyz, own, template, GRID_HZ, np.searchsorted(own, label[asked])):
        square = _squares(figure, xyz, known[figure.marker])
        for t in asked[label[asked] == own[figure.marker]].tolist():
            rows = square[np.isfinite(stretches.xyz[t, :, 0])]
            rows = rows[np.isfinite(rows)]
            out[t] = len(rows) > 0 and np.median(rows) > QUANTILES[RARE]
    return out


def _core(stretches: Stretches, label: Ints) -> Ints:
    """(T) labels of the longest pieces, that have half of their label's samples; −1 of the others."""
    n, core = stretches.seen.sum(1), np.full(len(label), -1)
    for a in np.unique(label[label >= 0]).tolist():
        of = np.flatnonzero(label == a)
        of = of[np.argsort(-n[of], kind="stable")]
        core[of[np.cumsum(n[of]) - n[of] < CORE * n[of].sum()]] = a
    return core


def _squares(figure: Figure, xyz: Floats, core: Floats) -> Floats:
    """(K) d² of (1) of a marker by its figure; NaN where that is not known. xyz (M, K, 3) and its core (K, 3) mm."""
    place, G = foretold(figure, xyz[figure.near])
    known = distance(core, place, G)
    known = known[np.isfinite(known)]
    if len(known) < LEAST_ROWS:
        return np.full(len(place), np.nan)
    s2 = max(np.quantile(known, q) / QUANTILES[q] for q in (0.5, RARE))
    return np.asarray(distance(xyz[figure.marker], place, max(s2, LEAST_MM**2) * G))
