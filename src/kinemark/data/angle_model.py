"""A cyclic motion as lengths and directions of segments over percent of the cycle (Swamidas 1997, 3.5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .array_types import Floats, Ints
from .arrays import check_positive, column, set_columns
from .short_repr import ShortRepr


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class AngleModel(ShortRepr):
    """S segments, each from one marker to another, at B equal steps of one cycle.

    Attributes:
        names: (M) markers.
        links: (S, 2) their indices, from and to (CONNECT, 3.33).
        bank: (S) segments of one number lie on one rigid body.
        length: (S) mm; spread: (S) its standard deviation in time, mm.
        direction: (S, B, 3) unit vector from the first marker to the second (3.34), the mean of several cycles.
        cov: (S, B, 3, 3) covariance of the direction of single cycles about the mean; NaN where one cycle only was
            seen.
        cycles: (S, B) how many were seen at each step; 0 where the mean bridges a hole.
        period: of a cycle, s.
    """

    names: tuple[str, ...]
    links: Ints
    bank: Ints
    length: Floats
    spread: Floats
    direction: Floats
    cov: Floats
    cycles: Ints
    period: float

    def __post_init__(self) -> None:
        s = len(self.links)
        b = np.shape(self.direction)[1] if np.ndim(self.direction) == 3 else 0
        set_columns(
            self,
            names=tuple(self.names),
            links=column("links", self.links, np.int64, s, 2),
            bank=column("bank", self.bank, np.int64, s),
            length=column("length", self.length, np.float64, s),
            spread=column("spread", self.spread, np.float64, s),
            direction=column("direction", self.direction, np.float64, s, b, 3),
            cov=column("cov", self.cov, np.float64, s, b, 3, 3),
            cycles=column("cycles", self.cycles, np.int64, s, b),
        )
        check_positive(period=self.period)
        if b < 4 or not s:
            raise ValueError(f"there are {s} segments at {b} steps of the cycle, wanted one or more at four or more")
        if len(set(self.names)) != len(self.names):
            raise ValueError(f"marker names must differ, found {self.names}")
        if self.links.min() < 0 or self.links.max() >= len(self.names) or (self.links[:, 0] == self.links[:, 1]).any():
            raise ValueError(f"links must be pairs of different indices below {len(self.names)}")
        if not (np.isfinite(self.length).all() and (self.length > 0).all()):
            raise ValueError("every segment must have a length above 0")
        if not np.allclose(np.linalg.norm(self.direction, axis=-1), 1.0, atol=1e-6):
            raise ValueError("direction must be unit vectors")

    @property
    def angles(self) -> Floats:
        """(S, B, 3) the component angles with the axes x, y and z (3.35), deg."""
        return np.degrees(np.arccos(np.clip(self.direction, -1.0, 1.0)))

    @property
    def deviation(self) -> Floats:
        """(S, B, 3) standard deviation of the component angles, deg: dθ = −d cos θ / sin θ, 90 at most."""
        variance = np.maximum(np.diagonal(self.cov, axis1=-2, axis2=-1), 0.0)
        sine = np.sqrt(np.maximum(1 - self.direction**2, 1e-12))
        return np.minimum(np.degrees(np.sqrt(variance) / sine), 90.0)

    def turned(self, angle: float) -> AngleModel:
        """The same motion turned about the vertical by an angle, deg."""
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return AngleModel(
            self.names, self.links, self.bank, self.length, self.spread,
            self.direction @ R.T, R @ self.cov @ R.T, self.cycles, self.period,
        )  # fmt: skip

    def reversed(self) -> AngleModel:
        """The same motion backwards in time."""
        return AngleModel(
            self.names, self.links, self.bank, self.length, self.spread,
            self.direction[:, ::-1], self.cov[:, ::-1], self.cycles[:, ::-1], self.period,
        )  # fmt: skip
