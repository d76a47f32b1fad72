"""One session: the folder of a recording, its settings, and what was made of it.

A session is opened from its `session.toml`, runs its trials, and is the object that every face drives. Nothing that the
user gave is changed; everything computed goes below `results/`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..calibrate.reference_marker import corrected, find_marks, reference_shift
from ..data import Camera, Detections, KinemarkError, Rig, Trajectories, Trial
from ..detect import Centroids, detect
from ..digitise import Identified, identified
from ..io.detections_csv import read_detections_csv
from ..io.images import ImageSource
from ..io.records import load
from ..io.tdf import read_tdf
from ..io.um2as import siblings
from .calibration import Calibrated, calibrate
from .digitising import Digitising, answer_files, digitise_trial, read_digitised, read_figures, write_digitised
from .pipeline import Methods, OperatorIdentities, Progress, Results, TrialSource, rig_key, run, silent
from .recordings import frame_of, masks_key, masks_of, open_cameras
from .settings import ADVICE, Settings, TrialEntry, is_da, read_settings
from .store import digest, file_key

FILE = "session.toml"


@dataclass(frozen=True, slots=True)
class Session:
    """An open session.

    Attributes:
        root: its folder.
        settings: what its `session.toml` says.
    """

    root: Path
    settings: Settings

    @classmethod
    def open(cls, path: Path | str, *, overrides: Sequence[str] = ()) -> Session:
        """The session in a folder, or of a session file.

        Args:
            path: of the folder or the file.
            overrides: methods and parameters instead of the file's, as "track.method=kiss_tracking".

        Raises:
            KinemarkError: there is none, or its settings are not understood.
        """
        path = Path(path)
        file = path / FILE if path.is_dir() else path
        if file.is_file() and file.suffix.lower() != ".toml":
            raise KinemarkError(f"{file} is a recording, not a session: write a {FILE} that names it. {ADVICE}")
        return cls(file.parent, read_settings(file, overrides=overrides))

    @property
    def results(self) -> Path:
        """Where everything computed goes."""
        return self.root / "results"

    def run(self, names: Sequence[str] = (), *, progress: Progress = silent) -> dict[str, Results]:
        """Calibrates, and runs the trials of these names, or all; does only what changed since the last run.

        Raises:
            KinemarkError: the calibration or a trial cannot be used, or a name is none of a trial.
        """
        trials = {trial.name: trial for trial in self.settings.trials}
        if unknown := [name for name in names if name not in trials]:
            raise KinemarkError(f"There is no trial {unknown}; the session has {', '.join(trials)}.")
        calibrated = self.calibrate(progress=progress)
        rig = calibrated.rig
        chosen = [trials[name] for name in names or trials]
        sources = {trial.name: self.source(trial, rig) for trial in chosen}  # all inputs are looked at before any work
        s = self.settings
        methods = Methods(s.detect, s.match, s.reconstruct, s.track, s.fill)
        return {
            name: run(
                source,
                rig,
                self.results / name,
                session=s.name,
                methods=methods,
                calibration=calibrated.steps,
                judged=calibrated.figures,
                progress=progress,
            )
            for name, source in sources.items()
        }

    def calibrate(self, *, progress: Progress = silent) -> Calibrated:
        """The calibrated cameras, read or computed, and how good they are; writes what `calibration` says.

        Raises:
            KinemarkError: the calibration is absent or unusable, or has fewer than two cameras.
        """
        return calibrate(self.root, self.results, self.settings, progress=progress)

    def source(self, trial: TrialEntry, rig: Rig) -> TrialSource:
        """Where a trial's detections come from.

        Raises:
            KinemarkError: files are missing, or contradict the calibration or the settings.
        """
        if trial.images is None:
            return self._detections_source(self.root / str(trial.detections), trial, rig)
        if trial.answers is not None:
            return self._operated_source(trial, rig)
        images = open_cameras(self.root, self.settings, trial.images, rig.names)
        rate = self._rate(trial, next(iter(images.values())).rate)
        for camera in rig:
            _check_size(camera, images[camera.name], self.settings.cameras.interlaced is not False)

        def detections(method: Any, progress: Progress) -> Detections:
            total = sum(source.n_frames for source in images.values())
            found = detect(
                list(images.values()),
                cameras=rig.names,
                rate=rate,
                method=method,
                masks=masks_of(self.root, self.settings, rig.names),
                progress=lambda done: progress("detect", done, total),
            )
            return self._unshifted(found, trial)

        files = [path for source in images.values() for path in source.paths]
        fields = str(self.settings.cameras.first_field)
        masks = masks_key(self.root, self.settings, rig.names)
        key = digest(file_key(*files), rig.names, rate, fields, *self._marks(trial), *masks)
        return TrialSource(
            key,
            detections,
            contradictions=_contradictions(images, rate),
            pictures=lambda frames: [frame_of(images[name], f) for name, f in zip(rig.names, frames, strict=True)],
        )

    def _detections_source(self, path: Path, trial: TrialEntry, rig: Rig) -> TrialSource:
        """Detections that were made before, by us or by another system."""
        beside = operated = None
        others: list[Path] = []
        if is_da(path):
            others = siblings(path, "da")
            given = read_digitised(path, cameras=rig.names, rate=self._rate(trial, None))
            found, names = given.seen.detections, self._names_of(path, given.n_markers)
            operated = OperatorIdentities(lambda: names, lambda: given.seen.marker, dict)
        elif path.suffix.lower() == ".tdf":
            tdf = read_tdf(path)
            if tdf.detections is None:
                raise KinemarkError(f"{path} has no 2D points. Export the trial with its 2D data.")
            found = tdf.detections
            beside = Trial(trial.name, Trajectories((), found.rate), tdf.analog, tdf.plates, tdf.events)
        elif path.suffix.lower() == ".csv":
            found = read_detections_csv(path, rate=self._rate(trial, None))
        else:
            record = load(path)
            if not isinstance(record, Detections):
                raise KinemarkError(f"{path} holds {type(record).__name__}, wanted Detections. Name another file.")
            found = record
        rate = self._rate(trial, found.rate)
        if abs(rate - found.rate) > 0.01 * rate:
            raise KinemarkError(
                f"{path} says {found.rate:g} Hz and session.toml rate_hz = {rate:g}. Correct or remove rate_hz."
            )
        if not len(found):
            raise KinemarkError(f"{path} has no 2D points. Check that it was written to the end.")
        if missing := sorted(set(rig.names) - set(found.cameras)):
            raise KinemarkError(
                f"{path} has cameras {', '.join(found.cameras)}, and the calibration also {', '.join(missing)}. "
                "Call them alike in both, and name in [cameras] those to be used."
            )
        return TrialSource(
            digest(file_key(path, *others), rig.names, found.rate, *self._marks(trial)),
            lambda method, progress: self._unshifted(found.select(rig.names), trial),
            beside=beside,
            operated=operated,
        )

    def _names_of(self, path: Path, n: int) -> Sequence[str]:
        """The names of n digitised markers: those of `[digitise]`, else their numbers."""
        method = self.settings.digitise
        if method is None:
            return [str(m + 1) for m in range(n)]
        if len(method.markers) != n:
            raise KinemarkError(f"{path} has {n} markers, and [digitise] names {len(method.markers)}. Name them all.")
        return method.markers

    def digitising(self, name: str, rig: Rig) -> Digitising:
        """What an operator needs to digitise a trial.

        Raises:
            KinemarkError: there is no such trial, it has no answers, or images cannot be used.
        """
        trial = next((trial for trial in self.settings.trials if trial.name == name), None)
        if trial is None or trial.images is None or trial.answers is None:
            raise KinemarkError(f"{name!r} is no trial with images and answers. Write both into its [[trials]].")
        method, marks = self.settings.digitise, self.settings.calibration.reference_marker
        assert method is not None and isinstance(self.settings.detect, Centroids)  # the settings see to it
        constants = None
        if marks is not None and method.reference is not None:
            constants = places_of(marks, rig.names)[:, 0]
        images = open_cameras(self.root, self.settings, trial.images, rig.names)
        for camera in rig:
            _check_size(camera, images[camera.name], self.settings.cameras.interlaced is not False)
        files = answer_files(self.root, trial.answers, rig.names)
        masks = masks_of(self.root, self.settings, rig.names)
        return Digitising(images, files, rig, method, self.settings.detect, constants, masks)

    def _operated_source(self, trial: TrialEntry, rig: Rig) -> TrialSource:
        """Detections that an operator digitises; his answers are read."""
        task, folder = self.digitising(trial.name, rig), self.results / trial.name
        rate = self._rate(trial, next(iter(task.images.values())).rate)

        def detections(method: Any, progress: Progress) -> Detections:
            try:
                uv, figures = digitise_trial(task, announce=lambda camera: progress(f"digitise {camera}", 0, 1))
            except KinemarkError as error:
                raise KinemarkError(f"{error} Answer it: kinemark digitise {self.root} {trial.name}") from error
            write_digitised(folder, uv, figures)
            return identified(uv, cameras=rig.names, rate=rate).detections

        def digitised() -> Identified:
            return read_digitised(folder / f"{trial.name}.da1", cameras=rig.names, rate=rate).seen

        files = [path for source in task.images.values() for path in source.paths]
        said = file_key(*files, *task.answers.values())
        marks = task.constants if task.constants is not None else 0
        parts = [marks, rig_key(rig), *masks_key(self.root, self.settings, rig.names)]
        return TrialSource(
            digest(said, rig.names, rate, asdict(task.method), *parts),
            detections,
            contradictions=_contradictions(dict(task.images), rate),
            pictures=lambda frames: [frame_of(task.images[n], f) for n, f in zip(rig.names, frames, strict=True)],
            operated=OperatorIdentities(
                lambda: task.method.markers, lambda: digitised().marker, lambda: read_figures(folder)
            ),
        )

    def _marks(self, trial: TrialEntry) -> list[object]:
        """What the session says of fixed marks, for a trial's key; nothing where it says nothing."""
        way = self.settings.calibration
        if way.reference_marker is None:
            return []
        return [way.reference_marker, way.mark_reach_px, way.mark_tolerance_px, trial.reference_marker]

    def _unshifted(self, found: Detections, trial: TrialEntry) -> Detections:
        """The detections as they would be, had no image shifted since the calibration; by fixed marks, where given."""
        way = self.settings.calibration
        if way.reference_marker is None:
            return found
        before, tolerance = places_of(way.reference_marker, found.cameras), way.mark_tolerance_px
        if trial.reference_marker is None:
            now = find_marks(found, before, reach=way.mark_reach_px, still=tolerance)
        else:
            now = places_of(trial.reference_marker, found.cameras)
        try:
            return corrected(found, reference_shift(before, now, tolerance=tolerance, names=found.cameras))
        except ValueError as error:
            raise KinemarkError(
                f"reference_marker of trial {trial.name!r} does not fit that of [calibration]: {error}. Give as many "
                "places for every camera in both."
            ) from error

    def _rate(self, trial: TrialEntry, stated: float | None) -> float:
        """Frames a second: as the settings say, else as the file does."""
        rate = self.settings.rate_hz or stated
        if not rate:
            raise KinemarkError(f"Trial {trial.name!r} does not say its frame rate. Set rate_hz in {FILE}.")
        return rate


def places_of(marks: Mapping[str, Sequence[tuple[float, float]]], names: Sequence[str]) -> NDArray[np.float64]:
    """(C, K, 2) px the fixed marks of each camera, NaN where one has fewer.

    Raises:
        KinemarkError: a camera has none.
    """
    if missing := [name for name in names if not marks.get(name)]:
        raise KinemarkError(f"reference_marker has no place for {', '.join(missing)}. Give one for every camera.")
    places = np.full((len(names), max(len(marks[name]) for name in names), 2), np.nan)
    for c, name in enumerate(names):
        places[c, : len(marks[name])] = marks[name]
    return places


def _contradictions(images: dict[str, ImageSource], rate: float) -> tuple[str, ...]:
    """Where the videos' own frame rates contradict the one that is used."""
    others = {name: s.rate for name, s in images.items() if s.rate and abs(s.rate - rate) > 0.01 * rate}
    if not others:
        return ()
    said = ", ".join(f"{name} {stated:g} Hz" for name, stated in others.items())
    return (
        f"The session says {rate:g} Hz and the videos say otherwise: {said}. Times and speeds are as right as rate_hz; "
        "high-speed cameras often store a slower rate, and a field of interlaced video is a frame.",
    )


def _check_size(camera: Camera, source: ImageSource, interlaced: bool) -> None:
    """Images and calibration must be of one size, or every pixel means another direction."""
    if camera.size.any() and tuple(camera.size) != source.size:
        kind = "fields" if interlaced else "images"
        raise KinemarkError(
            f"Camera {camera.name!r} was calibrated at {camera.size[0]} × {camera.size[1]} px and its {kind} are "
            f"{source.size[0]} × {source.size[1]}. Use images of the calibrated size, or check interlaced in [cameras]."
        )
