"""Force plates, EMG and other channels, as they were recorded."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .array_types import Floats
from .arrays import column, set_columns
from .short_repr import ShortRepr


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Analog(ShortRepr):
    """A channels of N samples at one rate.

    Attributes:
        names: (A).
        units: (A) as the source states them: "N", "N·mm", "V", …
        rate: samples a second, Hz.
        values: (A, N), channel-major, NaN where missing.
        start: time of the first sample after the first frame, s.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    rate: float
    values: Floats
    start: float = 0.0

    def __post_init__(self) -> None:
        n = len(self.names)
        set_columns(
            self,
            names=tuple(self.names),
            units=tuple(self.units),
            values=column("values", self.values, np.float64, n, None),
        )
        if len(self.units) != n:
            raise ValueError(f"units has {len(self.units)} entries, wanted {n}")

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, name: str) -> Floats:
        """(N) the samples of one channel."""
        if name not in self.names:
            raise KeyError(f"no channel {name!r}; there are {', '.join(self.names)}")
        return self.values[self.names.index(name)]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ForcePlate(ShortRepr):
    """One force plate.

    Attributes:
        type: as C3D numbers them: 1 force and pressure centre, 2 six components, 3 Kistler's eight channels,
            4 type 2 with a calibration matrix, …
        corners: (4, 3) in the world, mm.
        origin: (3) true origin in the plate's frame, mm.
        channels: names of its channels, in the order of its type.
        calibration: (6, 6) for type 4, else None.
        zero_frames: (2) first and last frame of the trial, from 0, in which nothing stands on it; None: none is said.
    """

    type: int
    corners: Floats
    origin: Floats
    channels: tuple[str, ...]
    calibration: Floats | None = field(default=None)
    zero_frames: Floats | None = field(default=None)

    def __post_init__(self) -> None:
        set_columns(
            self,
            corners=column("corners", self.corners, np.float64, 4, 3),
            origin=column("origin", self.origin, np.float64, 3),
            channels=tuple(self.channels),
        )
        if self.calibration is not None:
            set_columns(self, calibration=column("calibration", self.calibration, np.float64, None, None))
        if self.zero_frames is not None:
            set_columns(self, zero_frames=column("zero_frames", self.zero_frames, np.float64, 2))
