"""One session: the folder of a recording, its settings, and what was made of it.

A session is opened from its `session.toml`, runs its trials, and is the object that every face drives. Nothing that the
user gave is changed; everything computed goes below `results/`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .calibrate import calibrate_control_frame, calibrate_control_points
from .data import Camera, Detections, KinemarkError, Rig, Step, Trajectories, Trial
from .detect import Centroids, detect
from .geometry import camera_from_dlt
from .io.control_points import read_control_points
from .io.detections_csv import read_detections_csv
from .io.dlt_csv import read_dlt_csv
from .io.images import ImageSource, open_images
from .io.records import load
from .io.rig_toml import read_rig_toml, write_rig_toml
from .io.rods_toml import read_rods
from .io.tdf import read_tdf
from .ledger import Ledger, digest, file_key
from .pipeline import Methods, Progress, Results, Source, run, silent
from .settings import ADVICE, Settings, TrialEntry, read_settings

FILE = "session.toml"
MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}


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
    def open(cls, path: Path | str) -> Session:
        """The session in a folder, or of a session file.

        Raises:
            KinemarkError: there is none, or its settings are not understood.
        """
        path = Path(path)
        file = path / FILE if path.is_dir() else path
        if file.is_file() and file.suffix.lower() != ".toml":
            raise KinemarkError(f"{file} is a recording, not a session: write a {FILE} that names it. {ADVICE}")
        return cls(file.parent, read_settings(file))

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
        rig, steps = self.calibrate(progress=progress)
        chosen = [trials[name] for name in names or trials]
        sources = {trial.name: self.source(trial, rig) for trial in chosen}  # all inputs are looked at before any work
        s = self.settings
        methods = Methods(s.detect, s.match, s.reconstruct, s.track)
        return {
            name: run(
                source,
                rig,
                self.results / name,
                session=s.name,
                methods=methods,
                calibration=steps,
                progress=progress,
            )
            for name, source in sources.items()
        }

    def calibrate(self, *, progress: Progress = silent) -> tuple[Rig, tuple[Step, ...]]:
        """The calibrated cameras, read or computed, and the step that made them; writes `results/rig.toml`.

        Raises:
            KinemarkError: the calibration is absent or unusable, or has fewer than two cameras.
        """
        from_file = self.settings.calibration.file is not None
        ledger = Ledger.open(self.results)
        rig, _ = ledger.do(
            "calibrate",
            None if from_file else self.settings.calibrate,
            self._calibration_key(),
            file="rig.toml",
            make=lambda: self._rig_of_file() if from_file else self._rig_of_images(progress),
            save=write_rig_toml,
            load=read_rig_toml,
        )
        if len(rig) < 2:
            raise KinemarkError(
                f"The calibration has {len(rig)} camera, and a point in space needs two. Calibrate another camera."
            )
        return rig, tuple(ledger.steps)

    def source(self, trial: TrialEntry, rig: Rig) -> Source:
        """Where a trial's detections come from.

        Raises:
            KinemarkError: files are missing, or contradict the calibration or the settings.
        """
        if trial.images is None:
            return self._detections_source(self.root / str(trial.detections), trial, rig)
        images = self._images(trial.images, rig.names)
        rate = self._rate(trial, next(iter(images.values())).rate)
        for camera in rig:
            _check_size(camera, images[camera.name], self.settings.cameras.interlaced is not False)

        def detections(method: Centroids, progress: Progress) -> Detections:
            total = sum(source.n_frames for source in images.values())
            return detect(
                list(images.values()),
                cameras=rig.names,
                rate=rate,
                method=method,
                progress=lambda done: progress("detect", done, total),
            )

        files = [path for source in images.values() for path in source.paths]
        key = digest(file_key(*files), rig.names, rate, str(self.settings.cameras.first_field))
        return Source(key, detections, doubts=_doubts(images, rate))

    def _detections_source(self, path: Path, trial: TrialEntry, rig: Rig) -> Source:
        """Detections that were made before, by us or by another system."""
        beside = None
        if path.suffix.lower() == ".tdf":
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
        return Source(
            digest(file_key(path), rig.names, found.rate),
            lambda method, progress: found.select(rig.names),
            beside=beside,
        )

    def _rate(self, trial: TrialEntry, stated: float | None) -> float:
        """Frames a second: as the settings say, else as the file does."""
        rate = self.settings.rate_hz or stated
        if not rate:
            raise KinemarkError(f"Trial {trial.name!r} does not say its frame rate. Set rate_hz in {FILE}.")
        return rate

    def _images(self, pattern: str, names: Sequence[str]) -> dict[str, ImageSource]:
        """The frames of each camera."""
        if "{camera}" not in pattern and len(names) > 1:
            raise KinemarkError(f"images = {pattern!r} has no {{camera}} in it: all cameras would be one. Put it in.")
        images = {}
        for name in names:
            try:
                path = self.root / pattern.replace("{camera}", name)
                images[name] = open_images(path, interlaced=self.settings.cameras.first_field)
            except KinemarkError as error:
                raise KinemarkError(f"Camera {name!r} of [cameras] has no usable images: {error}") from error
        return images

    def _calibration_key(self) -> str:
        """A key of all that the calibration depends on."""
        s, way = self.settings, self.settings.calibration
        points, frame = way.control_points, way.control_frame
        files = [way.file, points and points.points, frame and frame.rods]
        paths = [self.root / path for path in files if path]
        patterns = [w.images for w in (points, frame) if w and w.images]
        for pattern in patterns:
            paths += [path for source in self._images(pattern, s.cameras.names).values() for path in source.paths]
        said = [s.cameras.model_dump(), way.model_dump(), s.volume_mm, str(s.detect) if patterns else ""]
        return digest(file_key(*paths), said)

    def _rig_of_file(self) -> Rig:
        """A ready-made calibration."""
        s, file = self.settings, self.root / str(self.settings.calibration.file)
        unit = s.calibration.length_unit
        if file.suffix.lower() == ".tdf":
            found = read_tdf(file, parts=("rig",)).rig
            if found is None:
                raise KinemarkError(f"{file} has no calibration. Name the file of the session's calibration.")
            rig = found
        elif file.suffix.lower() == ".csv":
            rig = rig_of_dlt(file, s.cameras.names, unit)
        else:
            rig = read_rig_toml(file, unit)
        if s.cameras.names:
            if missing := [name for name in s.cameras.names if name not in rig.names]:
                have, lack = ", ".join(rig.names), ", ".join(missing)
                raise KinemarkError(f"{file} has cameras {have}, not {lack}. Correct names in [cameras].")
            rig = rig.select(s.cameras.names)
        return self._with_volume(rig)

    def _rig_of_images(self, progress: Progress) -> Rig:
        """A calibration from control points or a control frame."""
        s, way = self.settings, self.settings.calibration
        names = s.cameras.names
        if not names:
            raise KinemarkError("[cameras] names is empty. Name the cameras, so that their images can be found.")
        pattern = next((w.images for w in (way.control_frame, way.control_points) if w), None)
        images = self._images(pattern, names) if pattern else {}
        seen = None
        if images:
            seen = detect(
                list(images.values()),
                cameras=names,
                rate=1.0,
                method=s.detect,
                progress=lambda done: progress("calibrate", done, len(names)),
            )
        sizes = np.array([images[name].size if images else (0, 0) for name in names])
        if way.control_frame and seen is not None:
            rods = read_rods(self.root / way.control_frame.rods)
            return self._with_volume(calibrate_control_frame(seen, rods, sizes=sizes, method=s.calibrate))
        assert way.control_points is not None  # the settings see to it
        points = read_control_points(self.root / way.control_points.points, names, seen)
        return self._with_volume(
            calibrate_control_points(names, sizes, points.xyz, points.uv, cov=points.cov, method=s.calibrate)
        )

    def _with_volume(self, rig: Rig) -> Rig:
        """The rig with the control volume of the settings, where they have one."""
        return rig if self.settings.volume_mm is None else replace(rig, volume=np.array(self.settings.volume_mm))


def _doubts(images: dict[str, ImageSource], rate: float) -> tuple[str, ...]:
    """Where the videos' own frame rates contradict the one that is used."""
    others = {name: s.rate for name, s in images.items() if s.rate and abs(s.rate - rate) > 0.01 * rate}
    if not others:
        return ()
    said = ", ".join(f"{name} {stated:g} Hz" for name, stated in others.items())
    return (
        f"The session says {rate:g} Hz and the videos say otherwise: {said}. Times and speeds are as right as rate_hz; "
        "high-speed cameras often store a slower rate, and a field of interlaced video is a frame.",
    )


def rig_of_dlt(file: Path, names: Sequence[str], unit: str | None) -> Rig:
    """A rig from eleven parameters a camera, whose unit of length the file does not say."""
    if unit is None:
        raise KinemarkError(f"{file} does not say its unit of length. Set length_unit in [calibration].")
    L = read_dlt_csv(file)
    names = names or tuple(f"cam{c + 1}" for c in range(len(L)))
    if len(names) != len(L):
        raise KinemarkError(f"{file} has {len(L)} columns and [cameras] {len(names)} names. Name one a column.")
    mm = MILLIMETRES[unit]
    scaled = L / np.array([mm, mm, mm, 1, mm, mm, mm, 1, mm, mm, mm])
    cameras = (camera_from_dlt(name, row) for name, row in zip(names, scaled, strict=True))
    return Rig(tuple(cameras), f"DLT of {file.name}")


def _check_size(camera: Camera, source: ImageSource, interlaced: bool) -> None:
    """Images and calibration must be of one size, or every pixel means another direction."""
    if camera.size.any() and tuple(camera.size) != source.size:
        kind = "fields" if interlaced else "images"
        raise KinemarkError(
            f"Camera {camera.name!r} was calibrated at {camera.size[0]} × {camera.size[1]} px and its {kind} are "
            f"{source.size[0]} × {source.size[1]}. Use images of the calibrated size, or check interlaced in [cameras]."
        )
