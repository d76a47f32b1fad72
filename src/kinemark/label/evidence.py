"""How well distances between points agree with a template.

For a point taken as label a and a labelled neighbour b at the distance d, the log-likelihood ratio of "a" over "any
point of this volume" is

    l = max( log(0.75 R / (σ √(2π))) − (d − D)² / (2 σ²),  log 0.25 )                                            (1)

with D and σ of the pair and R half the size of the template: (1) is the greater of the two parts of the mixture
0.75 N(d; D, σ) + 0.25 / R. A neighbour that tells nothing gives 0, one that is wrong or oddly placed costs log 0.25;
less where the pair hardly tells anything, in proportion, as postures that the template never showed put many such off.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Ints
from .template import Template

Single = NDArray[np.float32]

INLIERS = 0.75
"""Share of distances that are as the template says; chosen (robust log score)."""
REST = float(np.log(1 - INLIERS))
"""What a distance costs that is not, nats; by definition of (1)."""
WIDER = 1.3
"""By which another trial's spread is greater than the template's; chosen."""
RELATIVE, OF_SIZE = 0.02, 0.002
"""σ is never below these shares of D and of the template's size; chosen: as well are markers placed and seen."""
RIGID = 4.0
"""Base of a pair that hardly moves, nats; chosen. A pair with less costs less where it is off."""
WRONG_HAND = 4.0
"""What a quadruple of the wrong orientation costs, nats; chosen."""


class Hands(NamedTuple):
    """Quadruples seen from each of their members: (H) a member, (H, 3) the others, (H) sign of (others, member)."""

    label: NDArray[np.int64]
    others: NDArray[np.int64]
    sign: NDArray[np.int64]

    @classmethod
    def of(cls, handed: Ints, sign: Ints) -> Hands:
        """Of quadruples (Q, 4); to bring a member to the end changes the sign where it passes an odd number."""
        places = range(4)
        rest = np.concatenate([np.delete(handed, k, axis=1) for k in places])
        signs = np.concatenate([sign * (-1) ** (3 - k) for k in places])
        return cls(np.concatenate([handed[:, k] for k in places]), rest, signs)

    def of_points(self, xyz: Single, labelled: Single) -> Single:
        """(N, L) nats that points xyz (N, 3) lose as each label beside the labelled (L, 3); 0 where nothing is told."""
        three = labelled[self.others]
        seen = np.flatnonzero(np.isfinite(three[..., 0]).all(1))
        p = three[seen, 0]
        normal = np.cross(three[seen, 1] - p, three[seen, 2] - p) * self.sign[seen, None]
        wrong = normal @ xyz.T < (normal * p).sum(-1)[:, None]
        out = np.zeros((len(labelled), len(xyz)), np.float32)
        np.add.at(out, self.label[seen], np.where(wrong, np.float32(-WRONG_HAND), np.float32(0.0)))
        return out.T

    def total(self, labelled: Single) -> float:
        """Nats that the labelled (L, 3) lose by all quadruples."""
        own = len(self.label) // 4
        four = np.concatenate([self.others[:own], self.label[:own, None]], axis=1)
        return float(hands(labelled, four, self.sign[:own]).sum())


class PairScore(NamedTuple):
    """(1) of all pairs of labels, (L, L) each: mm, 1/mm, nats; inverse and base are 0 where nothing is known."""

    distance: Single
    inverse: Single
    base: Single
    least: Single
    hands: Hands | None = None

    @classmethod
    def of(cls, D: NDArray[np.float64], spread: NDArray[np.float64], size: float) -> PairScore:
        """From mean distances and spreads of pairs, mm; NaN where nothing is known."""
        sigma = np.sqrt(spread**2 + (RELATIVE * D) ** 2 + (OF_SIZE * size) ** 2)
        known = np.isfinite(D) & ~np.eye(len(D), dtype=bool)
        base = np.log(INLIERS * 0.5 * size / (np.where(known, sigma, 1.0) * np.sqrt(2 * np.pi)))
        return cls(
            np.where(known, D, 0.0).astype(np.float32),
            np.where(known, 1 / np.where(known, sigma, 1.0), 0.0).astype(np.float32),
            np.where(known, np.maximum(base, 0.0), 0.0).astype(np.float32),
            np.where(known, REST * np.clip(base / RIGID, 0.0, 1.0), 0.0).astype(np.float32),
        )

    @classmethod
    def of_template(cls, template: Template) -> PairScore:
        """As the template has them, a little wider."""
        plain = cls.of(template.distance, np.hypot(WIDER * template.spread, template.doubt), template.size)
        return plain._replace(hands=Hands.of(template.handed, template.sign))

    def at(self, d: Single, a: Ints | slice, b: Ints | slice) -> Single:
        """(1) of distances (…) for labels a and b that broadcast with them; 0 where the distance is NaN."""
        z = (d - self.distance[a, b]) * self.inverse[a, b]
        score = np.maximum(self.base[a, b] - 0.5 * z * z, self.least[a, b])
        return np.where(np.isfinite(d), score, np.float32(0.0)).astype(np.float32)

    def of_points(self, xyz: Single, labelled: Single, own: Ints) -> Single:
        """(N, L) nats: points xyz (N, 3) as each label, by labelled neighbours (L, 3); own (N): a point's label or −1.

        A point's own place among the labelled is no neighbour of it.
        """
        d = distances(xyz, labelled)
        mine = np.flatnonzero(own >= 0)
        d[mine, own[mine]] = np.nan
        seen = np.flatnonzero(np.isfinite(d).any(0))
        d = d[:, None, seen]
        z = (d - self.distance[:, seen]) * self.inverse[:, seen]
        np.multiply(z, z, out=z)
        z *= -0.5
        z += self.base[:, seen]
        np.maximum(z, self.least[:, seen], out=z)
        nats = np.nansum(z, axis=2)
        return nats if self.hands is None else nats + self.hands.of_points(xyz, labelled)

    @property
    def expected(self) -> NDArray[np.float64]:
        """(L, L) mean of (1) where the template holds, nats: (d − D)² is (σ / 1.3)² on average."""
        return np.where(self.inverse > 0, self.base - 0.5 / WIDER**2, 0.0).astype(np.float64)


def distances(a: Single, b: Single) -> Single:
    """(N, M) between points (N, 3) and (M, 3)."""
    return np.sqrt(((a[:, None] - b[None]) ** 2).sum(-1))


def hands(xyz: Single, handed: Ints, sign: Ints) -> Single:
    """(Q) nats: what quadruples cost whose orientation is not the template's; xyz (L, 3) labelled points."""
    a = xyz[handed[:, 0]]
    u, v, w = (xyz[handed[:, k]] - a for k in (1, 2, 3))
    wrong = sign * (u * np.cross(v, w)).sum(-1) < 0
    return np.where(wrong, np.float32(-WRONG_HAND), np.float32(0.0))
