"""Markers that sit beside the place where the template has them: another one is worn there, or the same put on anew.

A marker worn where an absent one belongs keeps its distances to its neighbours, but at other lengths than the
template's, and one displacement δ explains them all. With r_b what the mean distance from label a to its neighbour b is
off by, u_b the direction from b's place to a's in `shape` (1), and σ_b how well the template foretells that mean,

    r_b = u_b · δ + noise of σ_b,   σ_b² = (0.6 √(S² + s²) + |S − s|)² + (0.007 D)² + (0.0015 H)²                (1)

with D and S of `template` (1), s the same as S in this trial, and H the template's size: where a distance varies as
much as it did there, its mean comes back well, where it does not, as of a head that nods, the posture is another. Where
δ is normal with standard deviation τ on each axis, r has the log density

    e(τ) = ½ gᵀ (A + I/τ²)⁻¹ g − ½ log det(I + τ² A) + const,   A = Σ u_b u_bᵀ/σ_b²,   g = Σ u_b r_b/σ_b²        (2)

Markers are put on anew from day to day, all of them, so that the trial itself tells what is usual: τ₀ is the one at
which the median of (2) over all labels is greatest. A label sits beside its place by

    e(√(τ₀² + τ₁²)) − e(τ₀),   τ₁ = 0.013 H                                                                       (3)

nats, where δ is not small and the three stiffest distances are off by themselves: a posture moves the others together.
As a marker that is off spoils its neighbours' distances too, those by which (3) is above 3, and more than by the label
itself, are left out as its neighbours, and all is done once more.

Names are as sure as without it: nothing in a trial tells another marker from the same one that was put on anew. What
is told is where to look. By another subject's template nothing is: its markers sit elsewhere by as much.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from ..data import Trajectories
from ..data.array_types import Bools, Floats, Ints
from ..numerics.evenly import evenly_rounded
from .evidence import Single, distances
from .labels import Labels
from .shape import Shapes
from .stretches import Stretches, stretches_of
from .sweeps import places
from .template import Template

ALIKE, RELATIVE, OF_SIZE = 0.6, 0.007, 0.0015
"""Of (1); measured on 10 000 distances of rows of benchmarks/labelling_cases.py: where they vary alike, nine in ten
means are off by less than 0.5 to 1 times √(S² + s²), or 2 mm; elsewhere by 1.1 to 1.6 times."""
FRAMES = 40
"""In which distances are looked at; chosen, as in `held`."""
LEAST = 3
"""Neighbours seen, below which nothing is told; by definition: three tell a displacement."""
USUAL = (0.0005, 0.001, 0.002, 0.003, 0.004, 0.006, 0.008, 0.011, 0.016)
"""Shares of H that are tried for τ₀; chosen: less than 1 mm to 24 mm."""
BESIDE = 0.013
"""Of (3); chosen: 20 mm of 1.5 m."""
FAR = 0.006
"""Of |δ| as a share of H, below which nothing is said; chosen: 9 mm of 1.5 m."""
SQUARES = 8.0
"""Of the three stiffest r over σ, below which nothing is said; by definition: 95 % of three normal ones have less."""
CLEARLY_OFF = 3.0
"""Nats (3) from which on a label tells nothing of its neighbours; chosen."""
TOLD = 2.0
"""Nats (3) from which on a marker is told; chosen: of 1 567 right names of 36 rows three have more, and two of these
were put on anew."""


class _Off(NamedTuple):
    """A (L, 3, 3) and g (L, 3) of (2), in shares of H; (L) whether they tell anything; (L) Σ r²/σ² of the stiffest
    distances."""

    A: Floats
    g: Floats
    told: Bools
    stiffest: Floats

    def nats(self, tau: float) -> Floats:
        """(L) e(τ) of (2)."""
        fitted = 0.5 * (self.g * self.delta(tau)).sum(1)
        return np.asarray(fitted - 0.5 * np.linalg.slogdet(np.eye(3) + tau**2 * self.A)[1])

    def delta(self, tau: float) -> Floats:
        """(L, 3) the most probable δ, in shares of H."""
        return np.asarray(np.einsum("lij,lj->li", np.linalg.inv(self.A + np.eye(3) / tau**2), self.g))


class Beside(NamedTuple):
    """(L) nats (3) by which labels sit beside their places, and by how many mm; 0 where nothing is told."""

    nats: Floats
    mm: Floats


def markers_beside(
    tracks: Trajectories, labels: Labels, template: Template, stated: Collection[str] = ()
) -> tuple[tuple[str, float], ...]:
    """Markers that sit beside the places where the template has them, and by how many mm, the farthest first.

    Args:
        tracks: of a trial. labels: of them, by the template.
        template: of the subject. stated: tracks whose names a person stated; these are where they are.
    """
    if labels.another is not None or labels.undecided is not None:
        return ()
    number = {name: a for a, name in enumerate(template.names)}
    label = np.array([number.get(str(name), -1) for name in labels.names], np.int64)
    beside = beside_places(stretches_of(tracks, template.size), label, template)
    known = {labels.names[t] for t, name in enumerate(tracks.names) if name in stated}
    found = [(name, float(beside.mm[a])) for name, a in number.items() if beside.nats[a] > TOLD and name not in known]
    return tuple(sorted(found, key=lambda one: -one[1]))


def beside_places(stretches: Stretches, label: Ints, template: Template) -> Beside:
    """Of each label by (3), from its track or tracks.

    Args:
        label: (T) of tracks, −1 for none.
    """
    L = len(template)
    beside = Beside(np.zeros(L), np.zeros(L))
    if np.any(template.doubt) or not (label >= 0).any():
        return beside
    shapes = Shapes.of(template, by_body=True)
    r, spread = _off_by(places(stretches, label, L), template)
    for _ in range(2):
        tells = (beside.nats < CLEARLY_OFF) | (beside.nats < beside.nats[:, None])
        off = _told_of(r, spread, shapes, template, tells)
        if not off.told.any():
            return Beside(np.zeros(L), np.zeros(L))
        usual = max(USUAL, key=lambda tau: float(np.median(off.nats(tau)[off.told])))
        other = float(np.hypot(usual, BESIDE))
        by = np.linalg.norm(off.delta(other), axis=1)
        far = (by >= FAR) & (off.stiffest >= SQUARES) & off.told
        nats = np.where(far, off.nats(other) - off.nats(usual), 0.0)
        beside = Beside(nats, np.where(far, template.size * by, 0.0))
    return beside


def _off_by(y: Single, template: Template) -> tuple[Floats, Floats]:
    """(L, L) what mean distances of places (K, L, 3) are off by, NaN where two are never seen together, and s, mm."""
    some = y[evenly_rounded(len(y), FRAMES)]
    d = np.stack([distances(xyz, xyz) for xyz in some]).astype(float)
    seen = np.isfinite(d)
    n = np.maximum(seen.sum(0), 1)
    mean = np.where(seen, d, 0.0).sum(0) / n
    s = np.sqrt(np.where(seen, (d - mean) ** 2, 0.0).sum(0) / n)
    return np.where(seen.any(0), mean - template.distance, np.nan), s


def _told_of(r: Floats, spread: Floats, shapes: Shapes, template: Template, tells: Bools) -> _Off:
    """What (2) needs of all labels, by neighbours that tell them (L, L) anything."""
    own, H = np.arange(len(template))[:, None], template.size
    u = shapes.place[:, :1] - shapes.place[:, 1:]
    u = u / np.maximum(np.linalg.norm(u, axis=2, keepdims=True), 1e-9)
    near, D = shapes.near, template.distance[own, shapes.near]
    S, s = template.spread[own, near], spread[own, near]
    there = np.isfinite(r[own, near]) & np.isfinite(S) & tells[own, near]
    moved = ALIKE * np.hypot(S, s) + np.abs(S - s)
    sigma = np.sqrt(moved**2 + (RELATIVE * D) ** 2 + (OF_SIZE * H) ** 2) / H
    w = np.where(there, 1 / np.where(there, sigma, 1.0) ** 2, 0.0)
    A = np.einsum("lm,lmi,lmj->lij", w, u, u)
    g = np.einsum("lm,lmi,lm->li", w, u, np.where(there, r[own, near], 0.0) / H)
    squares = w * np.where(there, r[own, near] / H, 0.0) ** 2
    first = there & (np.cumsum(there, axis=1) <= LEAST)
    return _Off(A, g, there.sum(1) >= LEAST, (squares * first).sum(1))
