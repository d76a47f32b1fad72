"""A trial as an open document: settings, what the operator said, and the records that follow from both.

Everything but settings and answers is derived, kept under keys of content, and can be thrown away. A trial holds no
arrays itself: its records are read from the folder of results when they are asked for.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..data import Detections, KinemarkError, Rig, Step, Tracks, Trajectories
from ..edit import cropped
from ..numerics.blas_threads import one_blas_thread
from ..report.drawing_library import ASSETS, relink
from .calibration import calibrate
from .calibration.task import Calibrated
from .editing.stage import stage_before_edits
from .graph import Graph
from .naming import ABSENT, Earlier, before
from .naming.earlier import check_files_of_names
from .progress import Cancel, Progress, Watch, check_threads, silent
from .settings import Settings, TrialEntry
from .sources import Frames, Recording, TrialSource, identifies, source_of
from .store import WAITING, Store
from .trial_graph import REPORT, trial_graph
from .trial_inputs import TrialInputs, detections_of, edits_of, filled_of, tracks_of, trial_rig


@dataclass(frozen=True, slots=True)
class Workspace:
    """Where a session is.

    Attributes:
        root: its folder.
        settings: what its `session.toml` says.
        results: where everything computed goes.
    """

    root: Path
    settings: Settings = field(repr=False)
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


PREVIEW = "preview"
"""Folder, in that of a trial, of what was computed of a stretch of its frames."""


@dataclass(frozen=True, slots=True)
class OpenTrial:
    """One trial of a session.

    Attributes:
        workspace: the session that it belongs to.
        entry: its table in session.toml.
        frames: first and last frame of the stretch that is looked at, counted from 1; None for all.
        steps: the stages that were run, in their order, each with its key.
        computed: those of them that had to be computed in the last run; the others were unchanged.
        failed: why it could not be run, where a session runs its trials whatever becomes of one.
    """

    workspace: Workspace
    entry: TrialEntry
    frames: Frames = None
    steps: tuple[Step, ...] = field(default=(), repr=False)
    computed: tuple[str, ...] = ()
    failed: KinemarkError | None = None

    @property
    def name(self) -> str:
        """Of the trial."""
        return self.entry.name

    @property
    def folder(self) -> Path:
        """Where its results are."""
        whole = self.workspace.results / self.name
        return whole if self.frames == self.entry.frames else whole / PREVIEW

    @property
    def _lock(self) -> Path:
        """Whoever has this file works on the trial."""
        return self.workspace.results / f".{self.name}.lock"

    @property
    def stages(self) -> tuple[str, ...]:
        """The names of its stages, in order."""
        return self._graph(self.workspace.calibrate()).names

    def preview(self, first: int, last: int) -> OpenTrial:
        """The same trial, of frames first … last only, counted from 1; its results are kept apart.

        Raises:
            KinemarkError: that is no stretch of frames.
        """
        if not 1 <= first <= last:
            raise KinemarkError(
                f"frames {first} to {last} are no stretch: give the first, counted from 1, then the last."
            )
        return replace(self, frames=(first, last), steps=(), computed=())

    def run(
        self,
        to: str = "write",
        *,
        progress: Progress = silent,
        cancel: Cancel | None = None,
        threads: int | None = None,
    ) -> OpenTrial:
        """The trial with a stage done and all that it needs; what is unchanged is read instead of computed.

        Args:
            to: the stage.
            progress: called with each step.
            cancel: stops the run as soon as it is set; what was finished is kept, and the next run goes on there.
            threads: how many detection may use; all processors where None.

        Raises:
            KinemarkError: the input cannot be used; the message says what to do.
            Cancelled: `cancel` was set.
        """
        check_threads(threads)
        watch = Watch(progress, cancel)
        calibrated = self.workspace.calibrate(progress=progress, cancel=cancel, threads=threads)
        earlier = self._earlier(calibrated, progress=progress, cancel=cancel, threads=threads)
        return self.run_after(earlier, to, calibrated, watch, threads)

    def run_after(
        self, earlier: tuple[Earlier, ...], to: str, calibrated: Calibrated, watch: Watch, threads: int | None
    ) -> OpenTrial:
        """The same, where the trials before this one are named; raises as `run` does."""
        source, graph = self.source(calibrated.rig), self._graph(calibrated, earlier)
        if any(stage.name == "label" for stage in graph.to(to)) and not identifies(source):
            check_files_of_names(self.workspace.root, self.workspace.settings, self.entry)
        with one_blas_thread(), Store.open(self.folder, self._lock, watch.of(WAITING)) as store:
            s = self.workspace
            inputs = TrialInputs(
                self.name, self.folder, s.settings, source, calibrated, store, threads, s.assets, earlier
            )
            graph.run(to, inputs, store, watch)
            relink(self.folder / REPORT, s.results / ASSETS, self_contained=s.assets is None)
            return replace(self, steps=tuple(store.steps), computed=tuple(store.computed))

    def before_edits(self) -> tuple[OpenTrial, TrialInputs, dict[str, Any]]:
        """The trial processed as far as edits need it, with what the stages are given and the records so far.

        Raises:
            KinemarkError: the input cannot be used.
        """
        last = stage_before_edits(self.stages)
        done = self.run(last)
        return done, done._inputs(), done._records(last)

    def state(self) -> dict[str, bool]:
        """Each stage, and whether its record is there and up to date."""
        graph = self._graph(self.workspace.calibrate())
        store, keys = Store.read(self.folder), graph.keys(graph.names[-1])
        return {stage.name: store.holds(stage.name, keys[stage.name], stage.files) for stage in graph.stages}

    def outdated(self) -> tuple[str, ...]:
        """Stages of former runs whose settings, input or version of Kinemark are no longer those of now."""
        graph, old = self._graph(self.workspace.calibrate()), Store.read(self.folder).old
        keys = graph.keys(graph.names[-1])
        return tuple(stage for stage in graph.names if stage in old and old[stage].input != keys[stage])

    def done(self, stage: str) -> bool:
        """Whether the run came as far as this stage; of a trial that was only opened, whether its record is there."""
        return any(step.stage == stage for step in self._known())

    def summary(self) -> dict[str, Any]:
        """The last run for a machine: every figure, or the stages done where it stopped earlier, or its error."""
        if self.failed is not None:
            return {"trial": self.name, "error": str(self.failed)}
        return self.quality if self.done("quality") else {"trial": self.name, "stages": [s.stage for s in self.steps]}

    def record(self, stage: str) -> Any:
        """The record of a stage that was run.

        Raises:
            KinemarkError: it was not run, is not up to date, or its file was changed or deleted since.
        """
        return self._records(stage)[stage]

    @property
    def rig(self) -> Rig:
        """The cameras that the trial was reconstructed with; as they were calibrated before it is tracked."""
        return trial_rig(self._records("track")).rig if self.done("track") else self.workspace.calibrate().rig

    @property
    def detections(self) -> Detections:
        """What the cameras saw."""
        return self.record("detect")

    @property
    def detections_in_time(self) -> Detections:
        """What the cameras saw, where it was at the times of the frames: the same rows, which `tracks` count in."""
        last = "retrack" if self.done("retrack") else "track"
        records = self._records(last)
        return trial_rig(records).timed(detections_of(records))

    @property
    def tracks(self) -> Tracks:
        """Points with an identity, that of markers where they were labelled."""
        return tracks_of(self._records(next(s for s in ("label", "retrack", "track") if s == "track" or self.done(s))))

    @property
    def trajectories(self) -> Trajectories:
        """The markers, filled where `[fill]` says how."""
        last = next(
            stage for stage in ("fill", "edit", "label", "retrack", "track") if stage == "track" or self.done(stage)
        )
        inputs, records = self._inputs(), self._records(last)
        return cropped(filled_of(inputs, records).trajectories, edits_of(inputs, records))

    @property
    def quality(self) -> dict[str, Any]:
        """Every figure of the report."""
        return self.record("quality")

    def source(self, rig: Rig) -> TrialSource:
        """Where its detections come from."""
        s = self.workspace
        return source_of(Recording(s.root, s.settings, self.entry, rig, self.frames, self.folder))

    def _inputs(self) -> TrialInputs:
        """What the stages are given, to look at what they left."""
        calibrated = self.workspace.calibrate()
        source, store = self.source(calibrated.rig), Store.read(self.folder)
        return TrialInputs(self.name, self.folder, self.workspace.settings, source, calibrated, store)

    def _graph(self, calibrated: Calibrated, earlier: tuple[Earlier, ...] | None = None) -> Graph[TrialInputs]:
        known = self._earlier(calibrated) if earlier is None else earlier
        return trial_graph(self.name, self.workspace.settings, self.source(calibrated.rig), calibrated, known)

    def _earlier(self, calibrated: Calibrated, **options: Any) -> tuple[Earlier, ...]:
        return earlier_trials(self.workspace, self.entry, calibrated, **options)

    def label_key(self, calibrated: Calibrated, earlier: tuple[Earlier, ...]) -> str:
        """Of the trial's names, where they are there and up to date."""
        try:
            graph = self._graph(calibrated, earlier)
        except KinemarkError:  # its recording cannot be read
            return ABSENT
        key, stage = graph.keys("label")["label"], graph.to("label")[-1]
        return key if Store.read(self.folder).holds("label", key, stage.files) else ABSENT

    def _known(self) -> tuple[Step, ...]:
        """The stages that were run; of a trial that was only opened, those of former runs that are up to date."""
        if self.steps or self.failed is not None:
            return self.steps
        old = Store.read(self.folder).old
        return tuple(old[stage] for stage, done in self.state().items() if done) if old else ()

    def _records(self, stage: str) -> dict[str, Any]:
        """The records of a stage and of all that it needs, as the run left them."""
        keys = {step.stage: step.input for step in self._known()}
        store, found = Store.read(self.folder), {}
        for needed in self._graph(self.workspace.calibrate()).to(stage):
            if needed.name not in keys:
                raise KinemarkError(f"Trial {self.name!r} has no {needed.name} yet: run it to {stage!r} first.")
            if not store.holds(needed.name, keys[needed.name], needed.files):
                raise KinemarkError(f"{self.folder / needed.files[0]} was changed since trial {self.name!r} was run.")
            found[needed.name] = needed.load(self.folder / needed.files[0])
        return found


def earlier_trials(
    workspace: Workspace,
    entry: TrialEntry | None,
    calibrated: Calibrated,
    *,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
    threads: int | None = None,
) -> tuple[Earlier, ...]:
    """The trials by whose names another's are found; with `progress` they are named first where they were not.

    One that cannot be run names nobody, which it says itself when it is run.

    Args:
        workspace: the session. entry: the other trial; all trials that help any where None.
        calibrated: the cameras. progress, cancel, threads: as `OpenTrial.run` has them.
    """
    found: tuple[Earlier, ...] = ()
    for one in before(workspace.root, workspace.settings, entry):
        trial = OpenTrial(workspace, one, one.frames)
        if progress is not None and trial.label_key(calibrated, found) == ABSENT:
            with suppress(KinemarkError):
                trial.run_after(found, "label", calibrated, Watch(progress, cancel), threads)
        found += (Earlier(trial.name, one.kind, trial.folder, trial.label_key(calibrated, found)),)
    return found
