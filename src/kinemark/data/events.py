"""What happened when."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .array_types import Floats
from .arrays import column, set_columns
from .short_repr import ShortRepr


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Events(ShortRepr):
    """E events, in the order of their source.

    Attributes:
        label: (E) what, such as "Foot Strike".
        side: (E) "Left", "Right", "General" or "".
        time: (E) s from the start of the recording (frame 1 of a C3D file).
    """

    label: tuple[str, ...] = ()
    side: tuple[str, ...] = ()
    time: Floats = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        set_columns(
            self,
            label=tuple(self.label),
            side=tuple(self.side),
            time=column("time", self.time, np.float64, len(self.label)),
        )
        if len(self.side) != len(self.label):
            raise ValueError(f"side has {len(self.side)} entries, wanted {len(self.label)}")

    def __len__(self) -> int:
        return len(self.label)
