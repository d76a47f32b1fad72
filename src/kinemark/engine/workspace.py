"""The folder of a session: what was recorded, what its settings say, and where results go."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..report.drawing_library import ASSETS
from .calibration import calibrate
from .calibration.task import Calibrated
from .progress import Cancel, Progress, Watch, silent
from .settings import Settings


@dataclass(frozen=True, slots=True)
class Workspace:
    """Where a session is.

    Attributes:
        root: its folder.
        settings: what its `session.toml` says.
        results: where everything computed goes.
    """

    root: Path
    settings: Settings
    results: Path

    @property
    def assets(self) -> Path | None:
        """Folder of what pages share; None where each page is to hold it."""
        return None if self.settings.report.self_contained else self.results / ASSETS

    def calibrate(
        self, *, progress: Progress = silent, cancel: Cancel | None = None, threads: int | None = None
    ) -> Calibrated:
        """The calibrated cameras, read or computed, and how good they are; writes what `calibration` says.

        Raises:
            KinemarkError: the calibration is absent or unusable, or has fewer than two cameras.
            Cancelled: `cancel` was set.
        """
        return calibrate(self.root, self.results, self.settings, watch=Watch(progress, cancel), threads=threads)
