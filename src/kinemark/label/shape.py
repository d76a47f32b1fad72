"""Where a marker should be, beside its neighbours: the places that a template foretells.

A marker that sits elsewhere on another subject changes all of its distances alike, so that their sum (`evidence`)
takes one displacement for fifty proofs. Here it counts once. Each label a has a shape: itself and the M labels whose
distances to it vary least, placed by classical scaling of the template's distances

    B = −½ J D² J,  J = 1 − 1/n,  B = X Xᵀ                                                                       (1)

(Torgerson 1952), turned by the template's quadruples to the hand that it has. Laid over the neighbours that are seen,
by the rotation of least squares (Kabsch 1976) with weights against those that are off, it foretells x̂_a, and a point x
is a rather than any point of a volume V near the body with the log-likelihood ratio

    l = max( log( V / ((2π)^³⁄² σ³) ) − |x − x̂_a|² / (2 σ²),  −4 )                                               (2)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from ..geometry import polar_rotations
from .evidence import WIDER, Single
from .template import Template

NEIGHBOURS = 8
"""That foretell a place; chosen: about two segments."""
LEAST = 4
"""Neighbours seen, below which nothing is foretold; by definition: three leave the hand to their noise."""
VOLUME = 0.3
"""Edge of V as a share of the body's size; chosen: a third of the body is where a wrong marker would be."""
PLACED = 0.016
"""σ is never below this share of the body's size; chosen: 24 mm of 1.5 m."""
FLOOR = -4.0
"""What a place costs that is off, nats; chosen."""
ALL = slice(None)
"""Of labels; by definition."""
ROUNDS = 2
"""Of weights against neighbours that are off; chosen."""


class Shapes(NamedTuple):
    """(L, M) neighbours of each label, (L, M + 1, 3) places with its own first, mm, (L) σ, mm, and which are known."""

    near: Ints
    place: Floats
    sigma: Floats
    known: Bools
    base: Floats

    @classmethod
    def of(cls, template: Template, *, by_body: bool = False) -> Shapes:
        """Of all labels; with fewer than `LEAST` neighbours, or where no quadruple tells the hand, unknown.

        Args:
            by_body: where no quadruple lies within a shape, the figure of the whole body tells.
        """
        L = len(template)
        spread = np.hypot(WIDER * template.spread, np.asarray(template.doubt))
        rank = np.where(np.isfinite(template.distance), spread, np.inf) + np.diag(np.full(L, np.inf))
        M = min(NEIGHBOURS, L - 1)
        near = np.argsort(rank, axis=1, kind="stable")[:, :M]
        whole = np.concatenate([np.arange(L)[:, None], near], axis=1)
        D = template.distance[whole[:, :, None], whole[:, None]]
        place = _scaled(np.where(np.isfinite(D), D, np.nanmean(D, axis=(1, 2), keepdims=True)))
        vote = np.array([_vote(template, own, xyz) for own, xyz in zip(whole, place, strict=True)])
        if by_body and (vote == 0).any() and np.isfinite(template.distance).all():
            vote = np.where(vote == 0, _votes_of_body(template, whole, place), vote)
        place[vote < 0] *= [1.0, 1.0, -1.0]
        around = np.take_along_axis(rank, near, axis=1)
        known = np.isfinite(around).all(1) & (vote != 0) & (M >= LEAST)
        sigma = np.maximum(np.where(known, np.median(np.where(np.isfinite(around), around, 0.0), axis=1), 1.0),
                           PLACED * template.size)  # fmt: skip
        base = 3 * np.log(VOLUME * template.size / (sigma * np.sqrt(2 * np.pi)))
        return cls(near, place, sigma, known, np.maximum(base, 0.0))

    def foretold(self, y: Single, at: Ints | slice = ALL) -> Floats:
        """(K, n, 3) places of labels, all or some, from those of their neighbours in y (K, L, 3); NaN where too few are
        seen."""
        seen = y[:, self.near[at]].astype(float)
        there = np.isfinite(seen[..., 0]) & self.known[at, None]
        seen = np.where(there[..., None], seen, 0.0)
        weight = there.astype(float)
        place, sigma = self.place[at], self.sigma[at]
        around = place[:, 1:]
        for _ in range(1 + ROUNDS):
            rotation, own, other = _laid(around, seen, weight)
            off = (around - own[..., None, :]) @ rotation + other[..., None, :] - seen
            weight = there / (1.0 + (off**2).sum(-1) / sigma[:, None] ** 2)
        out = ((place[:, 0] - own)[..., None, :] @ rotation)[..., 0, :] + other
        return np.where((there.sum(-1) >= LEAST)[..., None], out, np.nan)

    def nats(self, x: Floats, foretold: Floats, at: Ints | slice = ALL) -> Floats:
        """(…, N, n) (2) of points x (…, N, 3) beside places (…, n, 3) of labels, all or some; NaN where either is."""
        square = ((x[..., :, None, :] - foretold[..., None, :, :]) ** 2).sum(-1)
        return np.maximum(self.base[at] - 0.5 * square / self.sigma[at] ** 2, FLOOR)

    def nats_of_own(self, y: Single, at: Ints | slice = ALL) -> Floats:
        """(K, n) (2) of labels, all or some, where they are in y (K, L, 3); NaN where one is not seen or foretold."""
        square = ((y[:, at] - self.foretold(y, at)) ** 2).sum(-1)
        return np.maximum(self.base[at] - 0.5 * square / self.sigma[at] ** 2, FLOOR)


def _scaled(D: Floats) -> Floats:
    """(L, n, 3) places of which D (L, n, n) are the distances (1)."""
    J = np.eye(D.shape[1]) - 1 / D.shape[1]
    values, vectors = np.linalg.eigh(-0.5 * J @ (D**2) @ J)
    return np.asarray(vectors[..., -3:] * np.sqrt(np.maximum(values[:, None, -3:], 0.0)))


def _votes_of_body(template: Template, whole: Ints, place: Floats) -> Floats:
    """(L) 1 where shapes (L, n, 3) of the labels (L, n) have the hand of the whole body's figure, −1 otherwise."""
    body = _scaled(template.distance[None])[0]
    body[:, 2] *= 1 if _vote(template, np.arange(len(body)), body) >= 0 else -1
    own, of_body = (xyz - xyz.mean(1, keepdims=True) for xyz in (place, body[whole]))
    return np.sign(np.linalg.det(np.swapaxes(own, 1, 2) @ of_body))


def _vote(template: Template, own: Ints, xyz: Floats) -> float:
    """Above 0 where places of the labels `own` have the hand that the template's quadruples say, below 0 otherwise."""
    index = np.full(len(template), -1)
    index[own] = np.arange(len(own))
    four = index[template.handed]
    inside = (four >= 0).all(1)
    a, b, c, d = (xyz[four[inside, k]] for k in range(4))
    return float((template.sign[inside] * np.sign(((b - a) * np.cross(c - a, d - a)).sum(-1))).sum())


def _laid(around: Floats, seen: Floats, weight: Floats) -> tuple[Floats, Floats, Floats]:
    """(K, L) rotations and both centres that lay places (L, M, 3) over points (K, L, M, 3), right-handed.

    Any rotation where the points do not tell one.
    """
    share = (weight / np.maximum(weight.sum(-1, keepdims=True), 1e-12))[..., None]
    own, other = (share * around).sum(-2), (share * seen).sum(-2)
    H = (share * (around - own[..., None, :])).mT @ (seen - other[..., None, :])
    R = np.broadcast_to(np.eye(3), H.shape).copy()
    told = (weight > 0).sum(-1) >= LEAST
    R[told] = polar_rotations(H[told])
    return np.where(np.isfinite(R), R, np.eye(3)), own, other
