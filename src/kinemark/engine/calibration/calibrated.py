"""A calibrated session."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...data import Rig, Step


@dataclass(frozen=True, slots=True, eq=False)
class Calibrated:
    """A session's calibration.

    Attributes:
        rig: the cameras.
        figures: how good they are; what calibration.json holds.
        steps: how they were made.
        computed: whether this had to be computed; else it was unchanged.
        folder: where it is on disk.
    """

    rig: Rig
    figures: dict[str, Any]
    steps: tuple[Step, ...]
    computed: bool
    folder: Path
