"""Where the component angle model has markers, and whether it agrees with where they are said to be (Swamidas 1997,
3.5.2).

A segment from marker a to marker b passes at phase φ where each of its component angles lies within what the model's
angle is anywhere within a share of the cycle about φ, ±5 % in the thesis (1), and, where it is asked for, where its
length is right. A marker is placed from markers that are known, in steps along the segments,

    x_b = x_a + ℓ d(φ),   x_a = x_b − ℓ d(φ)                                                     (2)

with the model's direction d and length ℓ; where several neighbours are known their mean is taken.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..data import AngleModel
from ..data.array_types import Bools, Floats
from .learn_angle_model import template_of
from .segment_directions import component_angles


class ModelPlaces:
    """The model's segments at any phase.

    Args:
        model: with links between the markers that are asked about.
        phase_tolerance: of (1), cycles.
        segment_tolerance: share by which a segment may be longer or shorter before it fails; None: angles alone.
    """

    def __init__(self, model: AngleModel, *, phase_tolerance: float, segment_tolerance: float | None) -> None:
        steps = model.direction.shape[1]
        self._link, self._length, self._stretch = model.links, model.length, segment_tolerance or np.inf
        self._curve, self._steps = template_of(model)[0], steps
        variance = np.nan_to_num(np.trace(model.cov, axis1=2, axis2=3) / 3, nan=0.01)
        self._variance = model.length[:, None] ** 2 * variance + model.spread[:, None] ** 2
        width = 2 * round(phase_tolerance * steps) + 1
        self._low, self._high = (
            f(model.angles, width, axis=1, mode="wrap")
            for f in (scipy.ndimage.minimum_filter1d, scipy.ndimage.maximum_filter1d)
        )

    def wrong(self, at: Floats, phase: float) -> Bools:
        """(M) markers of places (M, 3) mm that belong to a segment that fails (1) at a phase in cycles."""
        wrong = np.zeros(len(at), bool)
        wrong[self._link[self.fails(at, phase)]] = True
        return wrong

    def fails(self, at: Floats, phase: float) -> Bools:
        """(S) segments between places (M, 3) mm that fail (1); those with an unknown end, NaN, do not."""
        way = at[self._link[:, 1]] - at[self._link[:, 0]]
        with np.errstate(invalid="ignore", divide="ignore"):
            length = np.linalg.norm(way, axis=1)
            angle = component_angles(way / length[:, None])
            b = self._step(phase)
            fails = ((angle < self._low[:, b]) | (angle > self._high[:, b])).any(1)
            return np.asarray(fails | (np.abs(length - self._length) > self._stretch * self._length))

    def place(self, at: Floats, seen: Bools, phase: float) -> tuple[Floats, Floats]:
        """(2): where the model has all markers (M, 3) mm, NaN where nothing seen (M) is joined to them, and variances
        (M) mm²; of those seen `at` is kept."""
        placed, variance = np.where(seen[:, None], at, np.nan), np.where(seen, 0.0, np.nan)
        known = seen & ~np.isnan(at[:, 0])
        way, own = self._way(phase), self._variance[:, self._step(phase)]
        while True:
            total, spread, n = np.zeros_like(placed), np.zeros(len(at)), np.zeros(len(at))
            for source, target, sign in ((0, 1, 1.0), (1, 0, -1.0)):
                a, b = self._link[:, source], self._link[:, target]
                use = known[a] & ~known[b]
                np.add.at(total, b[use], placed[a[use]] + sign * way[use])
                np.add.at(spread, b[use], variance[a[use]] + own[use])
                np.add.at(n, b[use], 1.0)
            new = n > 0
            if not new.any():
                return placed, variance
            placed[new], variance[new] = total[new] / n[new, None], spread[new] / n[new]
            known = known | new

    def _way(self, phase: float) -> Floats:
        way = self._curve(np.asarray(phase)).reshape(-1, 3)
        return np.asarray(way * (self._length / np.linalg.norm(way, axis=1))[:, None])

    def _step(self, phase: float) -> int:
        return round(phase * self._steps) % self._steps
