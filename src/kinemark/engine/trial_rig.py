"""The cameras that a trial was reconstructed with: those that were given, and what its own images told of them.

A calibration is what tracking begins with. Where the images tell that lens terms are missing, that a camera was turned
since, or takes its images later than the others, points are solved by what they tell. All that comes after tracking
asks these cameras and these times, or it would contradict the points. The world is that of the given calibration.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..data import Detections, KinemarkError, Rig
from ..data.array_types import Floats
from ..io.rig_toml import read_rig_toml, write_rig_toml
from ..signal.common_time import moved_in_time
from ..track.simultaneous.rig.moved_cameras import MovedCamera, as_calibrated
from ..track.simultaneous.rig.unfitting_stretches import Stretch, without_stretches
from ..track.simultaneous.tracker import TrackingResult

RIG = "rig.toml"
"""The file of the cameras among a trial's results, which any session may name as its calibration."""


class TrialRig(NamedTuple):
    """What a trial was reconstructed with.

    Attributes:
        rig: the C cameras.
        delay, line: (C) s by which each takes its images later than the others, and its last row later than its middle.
        left_out: stretches of frames, from 0, in which a camera fits the others no more.
        moved: stretches in which a camera that was knocked has its images where it would have had them before.
    """

    rig: Rig
    delay: Floats
    line: Floats
    left_out: tuple[Stretch, ...] = ()
    moved: tuple[MovedCamera, ...] = ()

    @classmethod
    def given(cls, rig: Rig) -> TrialRig:
        """Cameras as they were given, all in time."""
        return cls(rig, np.zeros(len(rig)), np.zeros(len(rig)))

    @classmethod
    def of_result(cls, result: TrackingResult) -> TrialRig:
        """Cameras as Kinemark's own tracker had them in the end."""
        return cls(result.rig, result.times.delay, result.times.line, result.unfitting, result.moved)

    @property
    def in_time(self) -> bool:
        """Whether all cameras take their images at once."""
        return not (self.delay.any() or self.line.any())

    def timed(self, detections: Detections) -> Detections:
        """The same rows, where they would be at the times of the frames for the cameras as they are in `rig`."""
        detections = as_calibrated(detections, self.rig, self.moved)
        if self.in_time:
            return detections
        camera = detections.camera
        height = np.maximum(np.array([one.size[1] for one in self.rig]), 1)
        row = np.clip(2 * detections.uv[:, 1] / height[camera] - 1, -1.0, 1.0)
        return moved_in_time(detections, np.nan_to_num(self.delay[camera] + self.line[camera] * row))

    def seen(self, detections: Detections) -> Detections:
        """The same rows in time; those of cameras that fit no more are not valid."""
        return without_stretches(self.timed(detections), self.left_out)

    def left_out_of(self, first_frame: int) -> tuple[tuple[str, int, int], ...]:
        """`left_out` by cameras' names, first and last frame, numbers in a recording that begins with `first_frame`."""
        return tuple(
            (self.rig.names[one.camera], one.first + first_frame, one.stop - 1 + first_frame) for one in self.left_out
        )

    def as_dict(self) -> dict[str, Any]:
        """All but the rig, for a file."""
        return {
            "delay_s": self.delay.tolist(),
            "line_s": self.line.tolist(),
            "left_out": [list(one) for one in self.left_out],
            "moved": [[*one[:3], one.map.tolist()] for one in self.moved],
        }

    def save(self, folder: Path) -> None:
        """Write the cameras among a trial's results."""
        write_rig_toml(folder / RIG, self.rig)

    @classmethod
    def load(cls, folder: Path, said: Mapping[str, Any]) -> TrialRig:
        """Cameras from the results of a trial, and what `as_dict` said.

        Raises:
            KinemarkError: the file is absent or damaged, or is of other cameras.
            ValueError, TypeError, KeyError: what is said is damaged.
        """
        rig = read_rig_toml(folder / RIG)
        delay, line = (np.array(said[name], np.float64) for name in ("delay_s", "line_s"))
        if not len(rig) == len(delay) == len(line):
            raise KinemarkError(f"{folder / RIG} has {len(rig)} cameras, wanted {len(delay)}. Delete it.")
        left_out = tuple(Stretch(*map(int, one)) for one in said["left_out"])
        moved = tuple(MovedCamera(int(c), int(a), int(b), np.array(H, np.float64)) for c, a, b, H in said["moved"])
        return cls(rig, delay, line, left_out, moved)
