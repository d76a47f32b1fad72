"""What every way of calibrating is given and gives."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from ...calibrate.quality import Evidence
from ...data import KinemarkError, Rig
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
