"""What moves in the virtual laboratory: markers whose places are known exactly, and limbs that hide them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..data import Angles, Events, MarkerSet, MarkerTrajectory, Trajectories
from ..data.array_types import Floats, Ints
from ..data.arrays import column, set_columns


@dataclass(frozen=True, slots=True, eq=False)
class Capsules:
    """L limbs over F frames: all points within `radius` of the line from `a` to `b`.

    Attributes:
        names: (L) such as "left thigh".
        a: (L, F, 3) one end of the axis, mm.
        b: (L, F, 3) the other end, mm.
        radius: (L) mm.
    """

    names: tuple[str, ...]
    a: Floats
    b: Floats
    radius: Floats

    def __post_init__(self) -> None:
        n, f = len(self.names), np.shape(self.a)[1]
        set_columns(
            self,
            names=tuple(self.names),
            a=column("a", self.a, np.float64, n, f, 3),
            b=column("b", self.b, np.float64, n, f, 3),
            radius=column("radius", self.radius, np.float64, n),
        )

    def __len__(self) -> int:
        return len(self.names)

    @classmethod
    def none(cls, n_frames: int) -> Capsules:
        """No limbs."""
        return cls((), np.zeros((0, n_frames, 3)), np.zeros((0, n_frames, 3)), np.zeros(0))


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """M markers over F frames, exactly.

    Attributes:
        names: (M).
        rate: frames a second, Hz.
        xyz: (M, F, 3) centres, mm; NaN where a marker is not there.
        radius_mm: (M) of the marker spheres; a single number serves all.
        capsules: the limbs that hide markers.
        links: (K, 2) pairs of markers that a stick figure joins.
        angles: the joint angles that made the motion, where a model made it.
        events: what happened when, as foot strikes.
    """

    names: tuple[str, ...]
    rate: float
    xyz: Floats
    radius_mm: Floats
    capsules: Capsules
    links: Ints = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    angles: Angles | None = None
    events: Events = field(default_factory=Events)

    def __post_init__(self) -> None:
        n = len(self.names)
        set_columns(
            self,
            names=tuple(self.names),
            xyz=column("xyz", self.xyz, np.float64, n, None, 3),
            radius_mm=column("radius_mm", np.broadcast_to(self.radius_mm, n), np.float64, n),
            links=column("links", self.links, np.int64, None, 2),
        )
        if not self.rate > 0 or not (self.radius_mm > 0).all():
            raise ValueError(f"rate and radius_mm must be positive, found {self.rate} and {self.radius_mm}")
        if self.capsules.a.shape[1] != self.n_frames:
            raise ValueError(f"capsules have {self.capsules.a.shape[1]} frames, wanted {self.n_frames}")

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, name: str) -> Floats:
        """(F, 3) the path of one marker, mm."""
        if name not in self.names:
            raise KeyError(f"no marker {name!r}; there are {', '.join(self.names)}")
        return self.xyz[self.names.index(name)]

    @property
    def n_frames(self) -> int:
        """F."""
        return self.xyz.shape[1]

    @property
    def trajectories(self) -> Trajectories:
        """The true paths as the record that every stage ends in."""
        paths = (MarkerTrajectory.measured(name, xyz) for name, xyz in zip(self.names, self.xyz, strict=True))
        return Trajectories(tuple(paths), self.rate)

    @property
    def marker_set(self) -> MarkerSet:
        """Names and links, with the mean length of each link and its standard deviation, mm."""
        span = np.linalg.norm(self.xyz[self.links[:, 0]] - self.xyz[self.links[:, 1]], axis=-1)
        seen = np.isfinite(span).any(1)
        length, spread = np.full(len(span), np.nan), np.full(len(span), np.nan)
        length[seen], spread[seen] = np.nanmean(span[seen], 1), np.nanstd(span[seen], 1)
        return MarkerSet(self.names, links=self.links, length=length, spread=spread)


def pairs(names: tuple[str, ...], *links: tuple[str, str]) -> Ints:
    """(K, 2) indices of linked names."""
    return np.array([[names.index(a), names.index(b)] for a, b in links], np.int64).reshape(-1, 2)


def from_trajectories(trajectories: Trajectories, *, radius_mm: ArrayLike = 7.0) -> Subject:
    """The markers of a recording as a subject without limbs; where a sample is missing, no marker is there."""
    return Subject(
        trajectories.names,
        trajectories.rate,
        trajectories.xyz,
        np.asarray(radius_mm, np.float64),
        Capsules.none(trajectories.n_frames),
    )


def stationary(
    names: tuple[str, ...], xyz: ArrayLike, *, radius_mm: ArrayLike, rate: float = 50.0, n_frames: int = 1
) -> Subject:
    """Points (M, 3) mm that do not move, as a subject: calibration targets."""
    places = np.asarray(xyz, np.float64).reshape(-1, 1, 3)
    path = np.broadcast_to(places, (len(places), n_frames, 3))
    return Subject(names, rate, path, np.asarray(radius_mm, np.float64), Capsules.none(n_frames))
