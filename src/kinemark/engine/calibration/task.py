"""What every way of calibrating is given and gives, and a calibrated session."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from ...calibrate.quality import Evidence
from ...data import KinemarkError, Rig, Step
from ...data.progress import listening
from ..progress import Watch
from ..recordings import Recorded, recorded
from ..settings import Settings, TargetRecording


class RigWithEvidence(NamedTuple):
    """Calibrated cameras, and what they were made from."""

    rig: Rig
    evidence: Evidence


class Task(NamedTuple):
    """The session's folder and settings, what receives progress and may cancel, and how many threads."""

    root: Path
    settings: Settings
    watch: Watch
    threads: int | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The cameras' names.

        Raises:
            KinemarkError: the session does not say them.
        """
        if not self.settings.cameras.names:
            raise KinemarkError("[cameras] names is empty. Name the cameras, so that their images can be found.")
        return self.settings.cameras.names

    def recorded(self, seen: TargetRecording, what: str, *, masked: bool = True) -> Recorded:
        """What the cameras recorded of a target, called `what` in progress; with the session's masks or without."""
        with listening(self.watch.of(what)):
            return recorded(self.root, self.settings, seen, self.names, masked=masked, threads=self.threads)


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
