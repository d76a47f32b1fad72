"""How well distances between points agree with a template.

For a point taken as label a and a labelled neighbour b at the distance d, the log-likelihood ratio of "a" over "any
point of this volume" is

    l = max( log(0.75 R / (σ √(2π))) − (d − D)² / (2 σ²),  log 0.25 )                                            (1)

with D and σ of the pair and R half the size of the template: (1) is the greater of the two parts of the mixture
0.75 N(d; D, σ) + 0.25 / R. A neighbour that tells nothing gives 0, one that is wrong or oddly placed costs log 0.25;
less where the pair hardly tells anything, in proportion, as postures that the template never showed put many such off.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Floats, Ints
from ..numerics.vectors import lengths

if TYPE_CHECKING:
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
    """Quadruples seen from their members: (H) a member, (H, 3) others, (H) sign of (others, member); (Q, 5) all."""

    label: NDArray[np.int64]
    others: NDArray[np.int64]
    sign: NDArray[np.int64]
    four: NDArray[np.int64]

    @classmethod
    def of(cls, handed: Ints, sign: Ints) -> Hands:
        """Of quadruples (Q, 4); to bring a member to the end changes the sign where it passes an odd number."""
        places = range(4)
        rest = np.concatenate([np.delete(handed, k, axis=1) for k in places])
        signs = np.concatenate([sign * (-1) ** (3 - k) for k in places])
        label = np.concatenate([handed[:, k] for k in places])
        order = np.argsort(label, kind="stable")
        return cls(label[order], rest[order], signs[order], np.column_stack([handed, sign]))

    def of_points(self, xyz: Single, labelled: Single) -> Single:
        """(N, L) nats that points xyz (N, 3) lose as each label beside the labelled (L, 3); 0 where nothing is told."""
        out = np.zeros((len(labelled), len(xyz)), np.float32)
        if len(self.label):
            three = labelled[self.others]
            p = three[:, 0]
            normal = np.cross(three[:, 1] - p, three[:, 2] - p) * self.sign[:, None].astype(np.float32)
            wrong = normal @ xyz.T < (normal * p).sum(-1)[:, None]  # not where one of the three is NaN
            own, first = np.unique(self.label, return_index=True)
            out[own] = -WRONG_HAND * np.add.reduceat(wrong.astype(np.float32), first, axis=0)
        return out.T

    def of_own(self, y: Single) -> Single:
        """(K, L) nats that labels lose as what they are; y (K, L, 3) places, NaN where not seen."""
        four, sign = self.four[:, :4], self.four[:, 4].astype(np.float32)
        p = y[:, four[:, 0]]
        u, v, w = (y[:, four[:, k]] - p for k in (1, 2, 3))
        wrong = (sign * (u * np.cross(v, w)).sum(-1) < 0).astype(np.float32)
        member = np.zeros((len(four), y.shape[1]), np.float32)
        np.put_along_axis(member, four, np.float32(1.0), axis=1)
        return -WRONG_HAND * (wrong @ member)

    def total(self, labelled: Single) -> float:
        """Nats that the labelled (L, 3) lose by all quadruples."""
        return float(hands(labelled, self.four[:, :4], self.four[:, 4]).sum())


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
        """As the template has them, a little wider; with quadruples where its distances are another subject's."""
        plain = cls.of(template.distance, np.hypot(WIDER * template.spread, np.asarray(template.doubt)), template.size)
        if not np.any(template.doubt):
            return plain
        return plain._replace(hands=Hands.of(template.handed, template.sign))

    def at(self, d: Single, a: int | Ints | slice, b: Ints | slice) -> Single:
        """(1) of distances (…) for labels a and b that broadcast with them; 0 where the distance is NaN."""
        z: Single = np.asarray(d - self.distance[a, b])  # in one place in memory, as this is done for millions
        z *= self.inverse[a, b]
        z *= z
        z *= -0.5
        z += self.base[a, b]
        np.maximum(z, self.least[a, b], out=z)
        np.copyto(z, 0.0, where=~np.isfinite(d))
        return z

    def of_points(self, xyz: Single, labelled: Single, own: Ints) -> Single:
        """(N, L) nats: points xyz (N, 3) as each label, by labelled neighbours (L, 3); own (N): a point's label or −1.

        A point's own place among the labelled is no neighbour of it.
        """
        d = distances(xyz, labelled)
        mine = np.flatnonzero(own >= 0)
        seen = np.flatnonzero(np.isfinite(labelled[:, 0]))
        d = d[:, None, seen]
        z = (d - self.distance[:, seen]) * (np.float32(0.5**0.5) * self.inverse[:, seen])
        np.multiply(z, z, out=z)
        np.subtract(self.base[:, seen], z, out=z)
        np.maximum(z, self.least[:, seen], out=z)
        nats = z @ np.ones(len(seen), np.float32)  # a fifth of the time of a sum
        column = np.searchsorted(seen, own[mine])  # what a point gains by its own place is taken off again
        there = (column < len(seen)) & (seen[np.minimum(column, len(seen) - 1)] == own[mine]) if len(seen) else mine < 0
        nats[mine[there]] -= z[mine[there], :, column[there]]
        return nats if self.hands is None else nats + self.hands.of_points(xyz, labelled)

    def of_own(self, y: Single) -> Single:
        """(K, L) nats of labels as what they are, by all others; y (K, L, 3) places, NaN where not seen, which give 0.

        The same as `of_points` has it for each point and its own label.
        """
        d = lengths(y[:, :, None] - y[:, None])
        nats: Single = self.at(d, slice(None), slice(None)).sum(2)
        if self.hands is None:
            return nats
        return np.where(np.isfinite(y[..., 0]), nats + self.hands.of_own(y), np.float32(0.0))

    @property
    def expected(self) -> NDArray[np.float64]:
        """(L, L) mean of (1) where the template holds, nats: (d − D)² is (σ / 1.3)² on average."""
        return np.where(self.inverse > 0, self.base - 0.5 / WIDER**2, 0.0).astype(np.float64)


def distances(a: Single, b: Single) -> Single:
    """(N, M) between points (N, 3) and (M, 3)."""
    return lengths(a[:, None] - b[None])


def hands(xyz: Single, handed: Ints, sign: Ints) -> Single:
    """(Q) nats: what quadruples cost whose orientation is not the template's; xyz (L, 3) labelled points."""
    a = xyz[handed[:, 0]]
    u, v, w = (xyz[handed[:, k]] - a for k in (1, 2, 3))
    wrong = sign * (u * np.cross(v, w)).sum(-1) < 0
    return np.where(wrong, np.float32(-WRONG_HAND), np.float32(0.0))


def frame_fit(y: Single, pairs: PairScore) -> Floats:
    """(K) nats of all pairs of labels in each frame over what the template expects; y (K, L, 3) mm. 0 without pairs."""
    every, out = np.arange(y.shape[1]), np.zeros(len(y))
    for k, xyz in enumerate(y):
        seen = np.isfinite(xyz[:, 0])
        expected = pairs.expected[np.ix_(seen, seen)].sum()
        score = pairs.at(distances(xyz, xyz), every[:, None], every[None]).sum()
        out[k] = score / expected if expected > 0 else 0.0
    return out
