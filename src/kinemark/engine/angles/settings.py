"""How joint angles are taken from a trial: by `kinemark angles`, and by `[angles]` of a session."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...data import KinemarkError
from ...kinematics import SMOOTH, InverseCosines, SignedAngles


@dataclass(frozen=True, slots=True)
class AngleSettings:
    """How angles are taken from a trial.

    Attributes:
        side: of the limb; where none is given the model's own, or the one whose markers the trial has.
        inverse_cosines: take angles as the thesis UM²AS does, without the sign of the first and third.
        lock_deg: how near to gimbal lock a frame is flagged.
        smoothing: of the markers before, "none" or a method that `kinemark methods smooth` lists.
        cutoff_hz: of the smoothing; by residual analysis or cross-validation where none is given.
        marker_sd_mm: standard deviation of a marker along an axis, where its file states none; estimated from the
            markers' unsteadiness where none is given.
        cycle: beginning and end of each cycle, s, as "0-2.5".
        cycle_event: events from one of which to the next a cycle goes, such as "Foot Strike".
        cycle_side: of these events.
        rate_hz: frames a second of a file that is silent or wrong about it.
        length_unit: of such a file.
        partial: read what there is of a damaged file.

    Raises:
        KinemarkError: a number is out of range, or two settings do not go together.
    """

    side: Literal["right", "left"] | None = None
    inverse_cosines: bool = False
    lock_deg: float = 10.0
    smoothing: str = "none"
    cutoff_hz: float | None = None
    marker_sd_mm: float | None = None
    cycle: tuple[str, ...] = ()
    cycle_event: str | None = None
    cycle_side: str | None = None
    rate_hz: float | None = None
    length_unit: Literal["mm", "cm", "m", "in"] | None = None
    partial: bool = False

    def __post_init__(self) -> None:
        if self.smoothing != "none" and self.smoothing not in SMOOTH:
            raise KinemarkError(f"There is no smoothing {self.smoothing!r}. There are none, {', '.join(SMOOTH)}.")
        if self.cutoff_hz is not None and self.smoothing == "none":
            raise KinemarkError("A cut-off is given without a smoothing. Say --smoothing butterworth or woltring.")
        if self.cycle and self.cycle_event:
            raise KinemarkError("Cycles are given both as times and by an event. Choose one.")
        if not 0 <= self.lock_deg < 90:
            raise KinemarkError(f"--lock-deg is {self.lock_deg}, wanted 0 up to 90.")
        for name in ("cutoff_hz", "marker_sd_mm", "rate_hz"):
            value = getattr(self, name)
            if value is not None and not 0 < value < np.inf:
                raise KinemarkError(f"--{name.replace('_', '-')} is {value}, wanted a number above 0.")

    @property
    def method(self) -> SignedAngles | InverseCosines:
        """How angles are read from rotations."""
        return InverseCosines(lock_deg=self.lock_deg) if self.inverse_cosines else SignedAngles(lock_deg=self.lock_deg)
