"""Markers through time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .array_types import Bools, Floats, Ints
from .arrays import column, set_columns
from .nearest_word import some_names
from .short_repr import ShortRepr


class Origin(IntEnum):
    """Where a sample comes from."""

    MISSING = 0
    MEASURED = 1
    FILLED = 2
    EDITED = 3


@dataclass(frozen=True, slots=True, eq=False, repr=False, weakref_slot=True)
class MarkerTrajectory(ShortRepr):
    """One marker over F frames.

    Attributes:
        name: its label; `*1`, `*2`, … for tracks without one.
        xyz: (F, 3) mm, NaN where missing.
        cov: (F, 3, 3) mm², NaN where unknown.
        origin: (F) an `Origin` each.
        residual: (F) how far the rays of its cameras pass from it, RMS, mm; as a C3D file states it; NaN where unknown.
        cameras: (F) bit c is set when camera c saw the marker; 0 where unknown. From `detection` where that is known.
        detection: (F, C) index in `Detections` of each camera's image, −1 where it has none of this sample; (F, 0)
            where the images are not known, as in files of other systems.
    """

    name: str
    xyz: Floats
    cov: Floats
    origin: NDArray[np.uint8]
    residual: Floats
    cameras: NDArray[np.uint32]
    detection: Ints = field(default_factory=lambda: np.zeros((0, 0), np.int64))

    def __post_init__(self) -> None:
        n = len(self.xyz)
        known = np.ndim(self.detection) != 2 or np.shape(self.detection)[1] > 0
        set_columns(
            self, detection=column("detection", self.detection if known else np.zeros((n, 0)), np.int64, n, None)
        )
        set_columns(
            self,
            xyz=column("xyz", self.xyz, np.float64, n, 3),
            cov=column("cov", self.cov, np.float64, n, 3, 3),
            origin=column("origin", self.origin, np.uint8, n),
            residual=column("residual", self.residual, np.float64, n),
            cameras=column("cameras", camera_bits(self.detection) if known else self.cameras, np.uint32, n),
        )
        missing = np.isnan(self.xyz).any(1)
        if (missing != (self.origin == Origin.MISSING)).any():
            raise ValueError(f"marker {self.name}: xyz must be NaN exactly where origin is MISSING")

    @classmethod
    def measured(cls, name: str, xyz: ArrayLike, **columns: ArrayLike) -> MarkerTrajectory:
        """A path whose finite samples are all measured; a partly NaN sample is missing; other columns are unknown."""
        xyz = np.array(xyz, np.float64)
        missing = ~np.isfinite(xyz).all(1)
        xyz[missing] = np.nan
        return cls(
            name=name,
            xyz=xyz,
            cov=np.asarray(columns.get("cov", np.full((len(xyz), 3, 3), np.nan)), np.float64),
            origin=np.where(missing, Origin.MISSING, Origin.MEASURED).astype(np.uint8),
            residual=np.asarray(columns.get("residual", np.full(len(xyz), np.nan)), np.float64),
            cameras=np.asarray(columns.get("cameras", np.zeros(len(xyz))), np.uint32),
            detection=np.asarray(columns.get("detection", np.zeros((len(xyz), 0))), np.int64),
        )

    def __len__(self) -> int:
        return len(self.xyz)

    @property
    def gaps(self) -> list[tuple[int, int]]:
        """First and last-plus-one frame of each run of missing samples between two seen ones."""
        seen = np.flatnonzero(self.origin != Origin.MISSING)
        before = np.flatnonzero(np.diff(seen) > 1)
        return list(zip((seen[before] + 1).tolist(), seen[before + 1].tolist(), strict=True))

    def frames(self, first: int, stop: int) -> MarkerTrajectory:
        """Frames first … stop − 1, counted from 0; their images are still rows of the same detections."""
        names = ("xyz", "cov", "origin", "residual", "cameras", "detection")
        return replace(self, **{name: getattr(self, name)[first:stop] for name in names})

    def only(self, rows: Bools) -> MarkerTrajectory:
        """The samples of some frames (F); the others are missing, with all that was known of them."""
        blank = {
            "xyz": np.nan, "cov": np.nan, "origin": Origin.MISSING, "residual": np.nan, "cameras": 0, "detection": -1
        }  # fmt: skip
        columns = {}
        for name, value in blank.items():
            columns[name] = getattr(self, name).copy()
            columns[name][~rows] = value
        return replace(self, **columns)


def camera_bits(detection: Ints) -> NDArray[np.uint32]:
    """(F) bit c is set where camera c of the first 32 has an image in `detection` (F, C)."""
    bits = np.left_shift(np.uint32(1), np.arange(min(detection.shape[1], 32), dtype=np.uint32))
    return np.asarray(((detection[:, :32] >= 0) * bits).sum(1), np.uint32)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Trajectories(ShortRepr):
    """All markers of a trial, of one length and rate.

    Attributes:
        paths: one a marker; an edit replaces one and shares the others.
        rate: frames a second, Hz.
        first_frame: number of the first frame in the recording it came from, as C3D counts, from 1.
    """

    paths: tuple[MarkerTrajectory, ...]
    rate: float
    first_frame: int = 1

    def __post_init__(self) -> None:
        set_columns(self, paths=tuple(self.paths))
        if len({len(path) for path in self.paths}) > 1:
            raise ValueError(f"paths must be of one length, found {sorted({len(p) for p in self.paths})}")

    def __len__(self) -> int:
        return len(self.paths)

    def __iter__(self) -> Iterator[MarkerTrajectory]:
        return iter(self.paths)

    def __getitem__(self, name: str) -> MarkerTrajectory:
        for path in self.paths:
            if path.name == name:
                return path
        raise KeyError(f"no marker {name!r}; there are {some_names(self.names)}")

    @property
    def names(self) -> tuple[str, ...]:
        """(M) markers' names."""
        return tuple(path.name for path in self.paths)

    @property
    def n_frames(self) -> int:
        """F."""
        return len(self.paths[0]) if self.paths else 0

    @property
    def xyz(self) -> Floats:
        """(M, F, 3) mm, marker-major, NaN where missing."""
        return np.array([path.xyz for path in self.paths]).reshape(len(self.paths), self.n_frames, 3)

    @property
    def time(self) -> Floats:
        """(F) seconds from the first frame."""
        return np.arange(self.n_frames) / self.rate

    def frames(self, first: int, stop: int) -> Trajectories:
        """Frames first … stop − 1, counted from 0."""
        first, stop, _ = slice(first, stop).indices(self.n_frames)
        return replace(
            self,
            paths=tuple(path.frames(first, max(first, stop)) for path in self.paths),
            first_frame=self.first_frame + first,
        )

    def select(self, names: Sequence[str]) -> Trajectories:
        """Only the markers of these names, in this order.

        Raises:
            KeyError: a name is none of a marker.
        """
        return replace(self, paths=tuple(self[name] for name in names))
