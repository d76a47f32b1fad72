"""Quantities through time: joint angles, moments, powers, forces, EMG, each with its own unit, axes, rate and start.

A quantity may be sampled otherwise than the markers; whoever writes a file that cannot hold that maps it there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .array_types import Floats
from .arrays import check_positive, column, set_columns
from .short_repr import ShortRepr

KINDS = ("angle", "moment", "power", "force", "emg", "scalar")
"""What a quantity is; "scalar" is any other number."""
XYZ = ("x", "y", "z")


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Signal(ShortRepr):
    """One quantity of A components at N times.

    Attributes:
        name: its label, such as "LKneeAngles".
        kind: one of `KINDS`.
        unit: as the source states it, such as "deg", "N·m", "N·m/kg"; empty where it states none.
        axes: (A) names of the components, such as "x" or "flexion".
        rate: samples a second, Hz.
        values: (N, A) in `unit`, NaN where missing.
        cov: (N, A, A) in `unit`², NaN where unknown.
        start: time of the first sample after the first frame of the trial, s.
        description: what the source says of it; empty where nothing.
    """

    name: str
    kind: str
    unit: str
    axes: tuple[str, ...]
    rate: float
    values: Floats
    cov: Floats
    start: float = 0.0
    description: str = ""

    def __post_init__(self) -> None:
        n, a = len(self.values), len(self.axes)
        set_columns(
            self,
            axes=tuple(self.axes),
            values=column("values", self.values, np.float64, n, a),
            cov=column("cov", self.cov, np.float64, n, a, a),
        )
        if self.kind not in KINDS:
            raise ValueError(f"signal {self.name}: kind is {self.kind!r}, wanted one of {', '.join(KINDS)}")
        check_positive(rate=self.rate)

    @classmethod
    def of(
        cls, name: str, kind: str, unit: str, values: ArrayLike, *, rate: float, axes: Sequence[str] = XYZ
    ) -> Signal:
        """A quantity from the first frame on whose covariance is unknown; values are (N, A)."""
        table = np.asarray(values, np.float64)
        cov = np.broadcast_to(np.nan, (len(table), len(axes), len(axes)))
        return cls(name, kind, unit, tuple(axes), rate, table, cov)

    def __len__(self) -> int:
        return len(self.values)

    @property
    def sd(self) -> Floats:
        """(N, A) standard deviation of each component, NaN where unknown."""
        return np.sqrt(np.diagonal(self.cov, axis1=-2, axis2=-1))

    @property
    def time(self) -> Floats:
        """(N) seconds after the first frame."""
        return self.start + np.arange(len(self)) / self.rate

    def __getitem__(self, axis: str) -> Floats:
        """(N) one component."""
        if axis not in self.axes:
            raise KeyError(f"{self.name} has no axis {axis!r}; there are {', '.join(self.axes)}")
        return self.values[:, self.axes.index(axis)]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Signals(ShortRepr):
    """The quantities of a trial.

    Attributes:
        signals: one a quantity, of different names; an edit replaces one and shares the others.
    """

    signals: tuple[Signal, ...] = ()

    def __post_init__(self) -> None:
        set_columns(self, signals=tuple(self.signals))
        if len(set(self.names)) != len(self.names):
            raise ValueError(f"names of signals must differ, found {self.names}")

    def __len__(self) -> int:
        return len(self.signals)

    def __iter__(self) -> Iterator[Signal]:
        return iter(self.signals)

    def __getitem__(self, name: str) -> Signal:
        for signal in self.signals:
            if signal.name == name:
                return signal
        raise KeyError(f"no signal {name!r}; there are {', '.join(self.names)}")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the quantities."""
        return tuple(signal.name for signal in self.signals)

    def of_kind(self, kind: str) -> Signals:
        """Only those of one kind.

        Raises:
            ValueError: the kind is none of `KINDS`.
        """
        if kind not in KINDS:
            raise ValueError(f"kind is {kind!r}, wanted one of {', '.join(KINDS)}")
        return Signals(tuple(signal for signal in self.signals if signal.kind == kind))

    def updated(self, new: Signals) -> Signals:
        """These, those of the same names replaced, and the others of `new` after them."""
        by_name = {signal.name: signal for signal in new}
        kept = tuple(by_name.pop(signal.name, signal) for signal in self.signals)
        return Signals((*kept, *by_name.values()))
