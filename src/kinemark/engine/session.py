"""One session: the folder of a recording, its settings, and what was made of it.

A session is opened from its `session.toml`, runs its trials one after the other, and is the object that every face
drives. Nothing that the user gave is changed; everything computed goes below `results/`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ..data import KinemarkError, Rig
from ..io.files import read_json
from ..report.index_page import IndexRow, index_row, write_index
from ..version import __version__
from .digitising.files import Digitising
from .editing.journal import journals_of_no_trial
from .gait.of_session import gait_headline, gait_page, read_gait, update_gait
from .naming.templates import keep_templates, templates_of_trial
from .open_trial import OpenTrial, Workspace, earlier_trials
from .progress import Cancel, Progress, silent
from .session_name import FILE
from .settings import ADVICE, ReportTable, Settings, TrialEntry, read_settings
from .sources import Frames, OperatedImages

INDEX = "index.html"
LISTED = {"report.html": "report", "gaps.html": "gaps", "sensitivity.html": "sensitivity", "quality.json": "figures"}
"""In a trial's folder, with their titles for the reader."""
NONE_FAILED: Mapping[str, KinemarkError] = MappingProxyType({})
"""Every trial could be processed; by definition."""


def update_index(results: Path, settings: Settings, failed: Mapping[str, KinemarkError] = NONE_FAILED) -> Path:
    """Write the index of a session by what is in its results now.

    Args:
        results: of the session. settings: of it.
        failed: by name, why a trial could not be processed just now.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    rows = [_index_row(results, trial.name, failed.get(trial.name)) for trial in settings.trials]
    calibration = _figures(results / "calibration.json")
    gait = read_gait(results) if settings.gait is not None else None
    write_index(
        results / INDEX, session=settings.name, calibration=calibration, rows=rows, version=__version__,
        gait=None if gait is None else (gait_headline(gait), gait_page(results) is not None),
    )  # fmt: skip
    return results / INDEX


def _index_row(results: Path, name: str, failed: KinemarkError | None) -> IndexRow:
    folder = results / name
    there = [(f"{name}/{file}", title) for file, title in LISTED.items() if (folder / file).is_file()]
    c3d = [(f"{name}/{name}.c3d", "C3D")] if (folder / f"{name}.c3d").is_file() else []
    angles = [(page.relative_to(results).as_posix(), "angles") for page in sorted(folder.glob("*/angles.html"))]
    why = "" if failed is None else str(failed)
    return index_row(name, _figures(folder / "quality.json"), [*there, *angles, *c3d], why=why)


def _figures(path: Path) -> dict[str, Any] | None:
    """What a file of figures holds; None where it is absent or of another version."""
    found = read_json(path)
    return found if "verdict" in found else None


@dataclass(frozen=True, slots=True)
class Session(Workspace):
    """An open session; a plain value, so that it can be sent to another process."""

    @classmethod
    def open(
        cls,
        path: Path | str,
        *,
        overrides: Sequence[str] = (),
        results: Path | str | None = None,
        self_contained: bool = False,
    ) -> Session:
        """The session in a folder, or of a session file.

        Args:
            path: of the folder or the file.
            overrides: methods and parameters instead of the file's, as "track.method=kiss_tracking".
            results: where everything computed goes; `results` in the session's folder where None.
            self_contained: each page holds the drawing library, as `[report] self_contained` says it.

        Raises:
            KinemarkError: there is none, or its settings are not understood.
        """
        path = Path(path)
        file = path / FILE if path.is_dir() else path
        if file.is_file() and file.suffix.lower() != ".toml":
            raise KinemarkError(f"{file} is a recording, not a session: write a {FILE} that names it. {ADVICE}")
        settings = read_settings(file, overrides=overrides)
        if self_contained:
            settings = settings.model_copy(update={"report": ReportTable(self_contained=True)})
        return cls(file.parent, settings, Path(results) if results else file.parent / "results")

    @property
    def names(self) -> tuple[str, ...]:
        """Of the trials."""
        return tuple(entry.name for entry in self.settings.trials)

    @property
    def camera_names(self) -> tuple[str, ...]:
        """As the settings say; else as the calibration does.

        Raises:
            KinemarkError: there it takes the names to calibrate, or the calibration cannot be read.
        """
        return self.settings.cameras.names or self.calibrate().rig.names

    def trial(self, name: str) -> OpenTrial:
        """One trial, with nothing run yet.

        Raises:
            KinemarkError: there is no such trial.
        """
        entry = self._entry(name)
        return OpenTrial(self, entry, entry.frames)

    def run(
        self,
        names: Sequence[str] = (),
        *,
        to: str = "write",
        frames: Frames = None,
        keep_going: bool = False,
        progress: Progress = silent,
        cancel: Cancel | None = None,
        threads: int | None = None,
    ) -> dict[str, OpenTrial]:
        """Calibrates, and runs the trials of these names, or all, one at a time, to a stage; does only what changed.

        Then writes the gait report of its walks, `gait/gait.html`, where `[gait]` says so, and its index, `index.html`.
        What comes back holds no arrays: the records of a trial are read when they are asked for.

        Args:
            names: of the trials.
            to: the stage to run to.
            frames: first and last of a stretch of each trial that is run as a preview, counted from 1; None for all.
            keep_going: a trial that cannot be used keeps nobody from the others; its error stands in its `failed`.
            progress: called with each step.
            cancel: stops the run as soon as it is set.
            threads: how many detection may use; all processors where None.

        Raises:
            KinemarkError: the calibration or a trial cannot be used, or a name is none of a trial.
            Cancelled: `cancel` was set.
        """
        if unknown := [name for name in names if name not in self.names]:
            raise KinemarkError(f"There is no trial {', '.join(unknown)}; the session has {', '.join(self.names)}.")
        chosen = [self.trial(name) for name in names or self.names]
        if frames is not None:
            chosen = [trial.preview(*frames) for trial in chosen]
        rig = self.calibrate(progress=progress, cancel=cancel, threads=threads).rig
        if not keep_going:
            for trial in chosen:  # a missing input is reported before hours of work
                trial.source(rig).key()
        done = dict[str, OpenTrial]()
        try:
            for trial in chosen:
                done[trial.name] = _run(
                    trial, to, keep_going=keep_going, progress=progress, cancel=cancel, threads=threads
                )
        finally:  # also where a trial cannot be processed: the others are there to be read
            with suppress(KinemarkError):  # the trials have reported a folder that cannot be written
                self._update_gait()
                failed = {name: trial.failed for name, trial in done.items() if trial.failed is not None}
                update_index(self.results, self.settings, failed)
                self._keep_template()
        return done

    @property
    def journals_of_no_trial(self) -> tuple[Path, ...]:
        """Files of edits that are applied to nothing, as no trial has their name."""
        return journals_of_no_trial(self.root, self.names)

    @property
    def gait(self) -> dict[str, Any] | None:
        """Figures of the walks' gait report as `[gait]` has it, or why there is none; None where there is no report."""
        return read_gait(self.results) if self.settings.gait is not None else None

    def _update_gait(self) -> None:
        update_gait(self.root, self.results, self.settings, self_contained=self.assets is None)

    def _keep_template(self) -> None:
        """Write what the session's trials show of the subject, where they were to be named."""
        if self.settings.label is not None:
            earlier = earlier_trials(self, None, self.calibrate())
            keep_templates(self.results, self.settings, templates_of_trial(self.root, self.settings, earlier))

    def digitising(self, name: str, rig: Rig) -> Digitising:
        """What an operator needs to digitise a trial.

        Raises:
            KinemarkError: there is no such trial, it has no answers, or images cannot be used.
        """
        entry = self._entry(name)
        if entry.images is None or entry.answers is None:
            raise KinemarkError(
                f"Trial {name} has no {'images' if entry.images is None else 'answers'}. Write into its [[trials]] "
                f'images = "{name}/{{camera}}.mkv" and answers = "{name}/{{camera}}.csv", where the answers will be '
                "kept, and below [digitise] the names of the markers."
            )
        source = OpenTrial(self, entry).source(rig)
        assert isinstance(source, OperatedImages)  # as the entry has images and answers
        return source.task()

    def _entry(self, name: str) -> TrialEntry:
        found = next((entry for entry in self.settings.trials if entry.name == name), None)
        if found is None:
            raise KinemarkError(f"There is no trial {name}; the session has {', '.join(self.names)}.")
        return found


def _run(trial: OpenTrial, to: str, *, keep_going: bool, **options: Any) -> OpenTrial:
    """The trial with a stage done, or, where its error shall keep nobody from the others, with that."""
    try:
        return trial.run(to, **options)
    except KinemarkError as error:
        if not keep_going:
            raise
        return replace(trial, failed=error)
