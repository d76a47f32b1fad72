"""What a bundle adjustment's points belong to: sticks, single points, points at known places.

Each part consists of n bodies with K markers and D degrees of freedom. A stick with markers at s_k mm along it has

    X_k = m + s_k a,   |a| = 1                                           (1)

and five: three of m, and two turns of a towards unit vectors e₁, e₂ across it,

    d X_k = d m + s_k (e₁ d₁ + e₂ d₂)                                    (2)

A turn about itself changes nothing. A single point has three, a point at a held place none, and one at a place known
with covariance Q has three and the further residual X − X₀, weighed by Q⁻¹ (3).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...numerics.vectors import perpendicular_pair


@dataclass(frozen=True, slots=True, eq=False)
class Sticks:
    """n poses of one stick.

    Attributes:
        centre: (n, 3) m of (1), mm.
        direction: (n, 3) a of (1).
        along: (K) s of (1), mm.
    """

    centre: Floats
    direction: Floats
    along: Floats

    degrees = 5
    known = False

    @property
    def xyz(self) -> Floats:
        """(n, K, 3) the markers, mm."""
        return self.centre[:, None] + self.along[:, None] * self.direction[:, None]  # (1)

    def tangents(self) -> Floats:
        """(n, K, 3, 5) of (2)."""
        perpendicular = perpendicular_pair(self.direction)
        J = np.zeros((len(self.centre), len(self.along), 3, 5))
        J[..., :3] = np.eye(3)
        J[..., 3:] = self.along[:, None, None] * perpendicular[:, None]
        return J

    def moved(self, step: Floats) -> Sticks:
        """After steps (n, 5)."""
        direction = self.direction + np.einsum("nij,nj->ni", perpendicular_pair(self.direction), step[:, 3:])
        direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
        return replace(self, centre=self.centre + step[:, :3], direction=direction)

    def prior(self) -> tuple[Floats, Floats, float]:
        """What is known beforehand: nothing."""
        return _nothing(len(self.centre), self.degrees)

    def supported(self, views: Ints) -> Bools:
        """(n) whether two markers are seen by two cameras each, from how many cameras see each marker (n, K)."""
        return np.asarray((views >= 2).sum(1) >= 2)

    def placed(self, R: Floats, t: Floats, scale: float) -> Sticks:
        """In a world where X is scale · R X + t, R (3, 3), t (3) mm."""
        return Sticks(scale * self.centre @ R.T + t, self.direction @ R.T, scale * self.along)

    def take(self, rows: Ints) -> Sticks:
        """Those in some rows (n)."""
        return replace(self, centre=self.centre[rows], direction=self.direction[rows])


@dataclass(frozen=True, slots=True, eq=False)
class FreePoints:
    """n single points anywhere.

    Attributes:
        at: (n, 3) mm.
        surveyed: (n, 3) X₀ of (3), mm; None where nothing is known of their places.
        information: (n, 3, 3) Q⁻¹ of (3), 1/mm², in the units of the centroids' covariances.
    """

    at: Floats
    surveyed: Floats | None = None
    information: Floats | None = None

    degrees = 3

    @property
    def known(self) -> bool:
        """Whether their places tie the world down."""
        return self.surveyed is not None

    @property
    def xyz(self) -> Floats:
        """(n, 1, 3) mm."""
        return self.at[:, None]

    def tangents(self) -> Floats:
        """(n, 1, 3, 3)."""
        return np.tile(np.eye(3), (len(self.at), 1, 1, 1))

    def moved(self, step: Floats) -> FreePoints:
        """After steps (n, 3)."""
        return replace(self, at=self.at + step)

    def prior(self) -> tuple[Floats, Floats, float]:
        """(3): its share of the normal matrix (n, 3, 3), of the right side (n, 3) and of χ²."""
        if self.surveyed is None or self.information is None:
            return _nothing(len(self.at), 3)
        difference = self.surveyed - self.at
        pull = np.einsum("nij,nj->ni", self.information, difference)
        return self.information, pull, float((difference * pull).sum())

    def supported(self, views: Ints) -> Bools:
        """(n) whether they are seen often enough, from how many cameras see each (n, 1)."""
        return np.asarray(views[:, 0] >= (1 if self.known else 2))

    def placed(self, R: Floats, t: Floats, scale: float) -> FreePoints:
        """In a world where X is scale · R X + t, R (3, 3), t (3) mm."""
        surveyed = None if self.surveyed is None else scale * self.surveyed @ R.T + t
        information = None if self.information is None else R @ self.information @ R.T / scale**2
        return FreePoints(scale * self.at @ R.T + t, surveyed, information)

    def take(self, rows: Ints) -> FreePoints:
        """Those in some rows (n)."""
        optional = (None if a is None else a[rows] for a in (self.surveyed, self.information))
        return FreePoints(self.at[rows], *optional)


@dataclass(frozen=True, slots=True, eq=False)
class KnownPoints:
    """n points at known places.

    Attributes:
        at: (n, 3) mm.
    """

    at: Floats

    degrees = 0
    known = True

    @property
    def xyz(self) -> Floats:
        """(n, 1, 3) mm."""
        return self.at[:, None]

    def tangents(self) -> Floats:
        """(n, 1, 3, 0): they cannot move."""
        return np.zeros((len(self.at), 1, 3, 0))

    def moved(self, step: Floats) -> KnownPoints:
        """The same."""
        return self

    def placed(self, R: Floats, t: Floats, scale: float) -> KnownPoints:
        """In a world where X is scale · R X + t, R (3, 3), t (3) mm."""
        return KnownPoints(scale * self.at @ R.T + t)

    def prior(self) -> tuple[Floats, Floats, float]:
        """Nothing that could change."""
        return _nothing(len(self.at), 0)

    def supported(self, views: Ints) -> Bools:
        """(n) whether a camera sees them."""
        return np.asarray(views[:, 0] >= 1)

    def take(self, rows: Ints) -> KnownPoints:
        """Those in some rows (n)."""
        return KnownPoints(self.at[rows])


Part = Sticks | FreePoints | KnownPoints


def complete(x: Floats) -> Bools:
    """(…) whether points (…, d) have no NaN."""
    return np.asarray(np.isfinite(x).all(-1))


def all_points(parts: tuple[Part, ...]) -> Floats:
    """(N, 3) the points of all parts, one body after the other, mm."""
    return np.concatenate([part.xyz.reshape(-1, 3) for part in parts])


def slices(parts: tuple[Part, ...]) -> list[slice]:
    """Which of the N points are each part's."""
    ends = np.cumsum([0] + [part.xyz.shape[0] * part.xyz.shape[1] for part in parts])
    return [slice(int(a), int(b)) for a, b in pairwise(ends)]


def supported(parts: tuple[Part, ...], seen: Bools) -> Bools:
    """`seen` (C, N) without the points of bodies that too few cameras see."""
    good = []
    for part, at in zip(parts, slices(parts), strict=True):
        n, K = part.xyz.shape[:2]
        whole = part.supported(seen[:, at].sum(0).reshape(n, K)) & complete(part.xyz).all(1)
        good.append(np.repeat(whole, K))
    return seen & np.concatenate(good)


def sticks_through(xyz: Floats, along: Floats) -> Sticks:
    """The sticks nearest to markers (n, K, 3), NaN where missing; NaN with fewer than two of them."""
    there = complete(xyz)
    n = np.maximum(there.sum(1), 1)
    s = np.where(there, along, 0.0)
    s_mean, mean = s.sum(1) / n, np.where(there[..., None], xyz, 0.0).sum(1) / n[:, None]
    centred = np.where(there, along - s_mean[:, None], 0.0)
    direction = (centred[..., None] * np.where(there[..., None], xyz - mean[:, None], 0.0)).sum(1)
    length = np.linalg.norm(direction, axis=1)
    direction = direction / np.where((there.sum(1) >= 2) & (length > 0), length, np.nan)[:, None]
    return Sticks(mean - s_mean[:, None] * direction, direction, np.asarray(along, np.float64))


def _nothing(n: int, degrees: int) -> tuple[Floats, Floats, float]:
    return np.zeros((n, degrees, degrees)), np.zeros((n, degrees)), 0.0
