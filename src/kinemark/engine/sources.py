"""Where the detections of a trial come from: images, a file of detections, or images that an operator digitises.

A source is a plain value: the session's folder and settings, the trial's entry, the cameras. It opens what it names
when it is asked, so that it can be sent to another process.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any, ClassVar, Protocol

import numpy as np

from ..calibrate.reference_marker import corrected, find_marks, reference_shift
from ..data import Analog, Camera, Detections, Events, Finding, KinemarkError, Rig, Trajectories, Trial, make_finding
from ..data.array_types import Floats, GreyLevels, Ints
from ..data.progress import tell
from ..detect import Centroids, detect
from ..digitise import identified
from ..io.detections_csv import read_detections_csv
from ..io.images import ImageSource
from ..io.records import load
from ..io.tdf import read_tdf
from ..io.um2as import siblings
from .digitising import Digitising, answer_files, digitise_trial, read_digitised, read_figures, write_digitised
from .keys import digest, file_key, rig_key
from .recordings import masks_key, masks_of, open_cameras
from .settings import Settings, TrialEntry, is_da

FILE = "session.toml"

Frames = tuple[int, int] | None
"""First and last frame of a stretch, counted from 1, both included; None means all."""


@dataclass(frozen=True, slots=True)
class Recording:
    """What every source of a trial knows.

    Attributes:
        root: the session's folder.
        settings: what its session.toml says.
        entry: the trial's own table in it.
        rig: the calibrated cameras.
        frames: the stretch that is asked for.
        results: the trial's folder of results.
    """

    root: Path
    settings: Settings
    entry: TrialEntry
    rig: Rig
    frames: Frames
    results: Path

    def rate(self, stated: float | None) -> float:
        """Frames a second: as the settings say, else as the file does."""
        rate = self.settings.rate_hz or stated
        if not rate:
            raise KinemarkError(f"Trial {self.entry.name!r} does not say its frame rate. Set rate_hz in {FILE}.")
        return rate

    def images(self) -> dict[str, ImageSource]:
        """The frames of each camera, of the size that it was calibrated at."""
        images = open_cameras(self.root, self.settings, str(self.entry.images), self.rig.names)
        for camera in self.rig:
            _check_size(camera, images[camera.name], self.settings.cameras.interlaced is not False)
        return images

    def marks(self) -> list[object]:
        """What the session says of fixed marks, for a key; nothing where it says nothing."""
        way = self.settings.calibration
        if way.reference_marker is None:
            return []
        return [way.reference_marker, way.mark_reach_px, way.mark_tolerance_px, self.entry.reference_marker]

    def unshifted(self, found: Detections) -> Detections:
        """The detections as they would be, had no image shifted since the calibration; by fixed marks, where given."""
        way = self.settings.calibration
        if way.reference_marker is None:
            return found
        before, tolerance = places_of(way.reference_marker, found.cameras), way.mark_tolerance_px
        if self.entry.reference_marker is None:
            now = find_marks(found, before, reach=way.mark_reach_px, still=tolerance)
        else:
            now = places_of(self.entry.reference_marker, found.cameras)
        try:
            return corrected(found, reference_shift(before, now, tolerance=tolerance, names=found.cameras))
        except ValueError as error:
            raise KinemarkError(
                f"reference_marker of trial {self.entry.name!r} does not fit that of [calibration]: {error}. Give as "
                "many places for every camera in both."
            ) from error

    def stretch(self, n_frames: int) -> tuple[int, int]:
        """First frame and last-plus-one, from 0, of the stretch in a recording of so many frames.

        Raises:
            KinemarkError: the recording ends before.
        """
        if self.frames is None:
            return 0, n_frames
        first, last = self.frames
        if last > n_frames:
            raise KinemarkError(
                f"Trial {self.entry.name!r} has {n_frames} frames, and frames = [{first}, {last}] were asked for. "
                f"Ask for frames from 1 to {n_frames}."
            )
        return first - 1, last


class TrialSource(Protocol):
    """Where the detections of a trial come from."""

    @property
    def of(self) -> Recording:
        """What is recorded, and where."""
        ...

    def key(self) -> str:
        """Changes when the input does."""
        ...

    def detections(self, threads: int | None = None) -> Detections:
        """Reads or makes them."""
        ...

    def contradictions(self) -> tuple[Finding, ...]:
        """What contradicts itself in the input."""
        ...

    def beside(self) -> Trial | None:
        """Analog channels, force plates and events of the same recording, in a trial without markers."""
        ...

    def pictures(self, frames: Sequence[int]) -> list[GreyLevels] | None:
        """One image (H, W) of each camera, of the frames (C) asked for; None where there are no images."""
        ...

    def operated(self) -> OperatorIdentities | None:
        """Which marker each detection is, where an operator said it; then nothing is matched or tracked."""
        ...


@dataclass(frozen=True, slots=True)
class OperatorIdentities:
    """What an operator said of a trial.

    Attributes:
        names: (M) of its markers.
        marker: (D) the marker of each detection, −1 for none.
        figures: how much the operator had to do; empty where it is not known.
    """

    names: tuple[str, ...]
    marker: Ints
    figures: Mapping[str, Any]


def source_of(of: Recording) -> TrialSource:
    """The source that a trial's entry names."""
    if of.entry.images is None:
        return DigitisedFiles(of) if is_da(of.root / str(of.entry.detections)) else DetectionFile(of)
    return OperatedImages(of) if of.entry.answers is not None else Images(of)


@dataclass(frozen=True, slots=True)
class Images:
    """Images or videos of all cameras, in which markers are detected."""

    of: Recording

    def key(self) -> str:
        """Of the files, the cameras' order, the rate, the fields, fixed marks and masks."""
        of, images = self.of, self.of.images()
        files = [path for source in images.values() for path in source.paths]
        fields, names = str(of.settings.cameras.first_field), of.rig.names
        masks = masks_key(of.root, of.settings, names)
        return digest(file_key(*files), names, self._rate(images), fields, of.marks(), masks, of.frames)

    def detections(self, threads: int | None = None) -> Detections:
        """By the session's `[detect]`, without what its `[masks]` cover."""
        of, images = self.of, self.of.images()
        sources = [_excerpt(source, of) for source in images.values()]
        total = sum(source.n_frames for source in sources)
        method: Any = of.settings.detect
        found = detect(
            sources,
            cameras=of.rig.names,
            rate=self._rate(images),
            method=method,
            masks=masks_of(of.root, of.settings, of.rig.names),
            progress=lambda done: tell(done, total),
            threads=threads,
        )
        return of.unshifted(found)

    def contradictions(self) -> tuple[Finding, ...]:
        """Where the videos' own frame rates contradict the one that is used."""
        images = self.of.images()
        return _other_rates(images, self._rate(images))

    def beside(self) -> Trial | None:
        """Nothing was recorded beside."""
        return None

    def pictures(self, frames: Sequence[int]) -> list[GreyLevels]:
        """The frames, counted within the stretch."""
        return _pictures(self.of, frames)

    def operated(self) -> OperatorIdentities | None:
        """Nobody did."""
        return None

    def _rate(self, images: Mapping[str, ImageSource]) -> float:
        return self.of.rate(next(iter(images.values())).rate)


@dataclass(frozen=True, slots=True)
class DetectionFile:
    """Detections that were made before, by Kinemark or by another system: TDF, CSV or HDF5."""

    of: Recording
    others: ClassVar[tuple[Path, ...]] = ()

    @property
    def path(self) -> Path:
        """The file."""
        return self.of.root / str(self.of.entry.detections)

    def key(self) -> str:
        """Of the file, the cameras' order, the rate and fixed marks."""
        of = self.of
        if not self.path.is_file():
            raise KinemarkError(f"{self.path} is not a file. Check detections of trial {of.entry.name!r}.")
        rate = of.rate(None) if self.path.suffix.lower() == ".csv" else of.settings.rate_hz
        return digest(file_key(self.path), of.rig.names, rate, of.marks(), of.frames)

    def detections(self, threads: int | None = None) -> Detections:
        """Those of the calibrated cameras.

        Raises:
            KinemarkError: the file holds none, contradicts the rate, or lacks a camera.
        """
        of = self.of
        found = self._read()
        rate = of.rate(found.rate)
        if abs(rate - found.rate) > 0.01 * rate:
            raise KinemarkError(
                f"{self.path} says {found.rate:g} Hz and session.toml rate_hz = {rate:g}. Correct or remove rate_hz."
            )
        if not len(found):
            raise KinemarkError(f"{self.path} has no 2D points. Check that it was written to the end.")
        if missing := sorted(set(of.rig.names) - set(found.cameras)):
            raise KinemarkError(
                f"{self.path} has cameras {', '.join(found.cameras)}, and the calibration also {', '.join(missing)}. "
                "Call them alike in both, and name in [cameras] those to be used."
            )
        return of.unshifted(_between(found.select(of.rig.names), of))

    def _read(self) -> Detections:
        """All that the file holds."""
        path, suffix = self.path, self.path.suffix.lower()
        if suffix == ".csv":
            return read_detections_csv(path, rate=self.of.rate(None))
        found = read_tdf(path).detections if suffix == ".tdf" else load(path)
        if found is None:
            raise KinemarkError(f"{path} has no 2D points. Export the trial with its 2D data.")
        if not isinstance(found, Detections):
            raise KinemarkError(f"{path} holds {type(found).__name__}, wanted Detections. Name another file.")
        return found

    def contradictions(self) -> tuple[Finding, ...]:
        """None is known."""
        return ()

    def beside(self) -> Trial | None:
        """What a TDF holds besides its 2D points, within the stretch."""
        if self.path.suffix.lower() != ".tdf":
            return None
        tdf = read_tdf(self.path)
        if tdf.detections is None:
            return None
        rate = tdf.detections.rate
        whole = Trial(self.of.entry.name, Trajectories((), rate), tdf.analog, tdf.plates, tdf.events)
        return whole if self.of.frames is None else _cut(whole, self.of.frames, rate)

    def pictures(self, frames: Sequence[int]) -> None:
        """There are no images."""
        return

    def operated(self) -> OperatorIdentities | None:
        """Nobody did."""
        return None


@dataclass(frozen=True, slots=True)
class DigitisedFiles:
    """A set of UM²AS's files of digitised centroids, one a camera, of which the entry names one."""

    of: Recording

    @property
    def path(self) -> Path:
        """The file that is named."""
        return self.of.root / str(self.of.entry.detections)

    def key(self) -> str:
        """Of all files of the set, the cameras' order, the rate and fixed marks."""
        of, files = self.of, (self.path, *siblings(self.path, "da"))
        return digest(file_key(*files), of.rig.names, of.settings.rate_hz, of.marks(), of.frames)

    def detections(self, threads: int | None = None) -> Detections:
        """Of all markers that the files have."""
        of = self.of
        found = read_digitised(self.path, cameras=of.rig.names, rate=of.rate(None)).seen.detections
        if not len(found):
            raise KinemarkError(f"{self.path} has no 2D points. Check that it was written to the end.")
        return of.unshifted(_between(found, of))

    def contradictions(self) -> tuple[Finding, ...]:
        """None is known."""
        return ()

    def beside(self) -> Trial | None:
        """Nothing was recorded beside."""
        return None

    def pictures(self, frames: Sequence[int]) -> None:
        """There are no images."""
        return

    def operated(self) -> OperatorIdentities:
        """The markers by the columns of the files, with the names of `[digitise]`, else their numbers."""
        of = self.of
        given = read_digitised(self.path, cameras=of.rig.names, rate=of.rate(None))
        return OperatorIdentities(self._names(given.n_markers), _marker_between(given.seen, of), {})

    def _names(self, n: int) -> tuple[str, ...]:
        """The names of n digitised markers."""
        method = self.of.settings.digitise
        if method is None:
            return tuple(str(m + 1) for m in range(n))
        if len(method.markers) != n:
            raise KinemarkError(
                f"{self.path} has {n} markers, and [digitise] names {len(method.markers)}. Name them all."
            )
        return tuple(method.markers)


@dataclass(frozen=True, slots=True)
class OperatedImages:
    """Images in which an operator points at markers; the answers are read, and what they do not say is an error."""

    of: Recording

    def task(self) -> Digitising:
        """What an operator needs to digitise the trial.

        Raises:
            KinemarkError: images or answers cannot be used.
        """
        of = self.of
        method, marks = of.settings.digitise, of.settings.calibration.reference_marker
        assert method is not None and isinstance(of.settings.detect, Centroids)  # the settings see to it
        constants: Floats | None = None
        if marks is not None and method.reference is not None:
            constants = places_of(marks, of.rig.names)[:, 0]
        files = answer_files(of.root, str(of.entry.answers), of.rig.names)
        masks = masks_of(of.root, of.settings, of.rig.names)
        return Digitising(of.images(), files, of.rig, method, of.settings.detect, constants, masks)

    def key(self) -> str:
        """Of images and answers, the cameras, the rate, how markers are digitised, and masks."""
        of, task = self.of, self.task()
        files = [path for source in task.images.values() for path in source.paths]
        masks = masks_key(of.root, of.settings, of.rig.names)
        said = file_key(*files, *task.answers.values())
        return digest(said, of.rig.names, self._rate(task), task.method, task.constants, rig_key(of.rig), masks)

    def detections(self, threads: int | None = None) -> Detections:
        """What the operator's answers give; `.da` files and figures are written beside.

        Raises:
            KinemarkError: a question has no answer yet.
        """
        of, task = self.of, self.task()
        if of.frames is not None:
            raise KinemarkError(f"Trial {of.entry.name!r} is digitised from its first frame on: leave out frames.")
        try:
            uv, figures = digitise_trial(task, announce=lambda camera: tell(0, 1))
        except KinemarkError as error:
            raise KinemarkError(f"{error} Answer it: kinemark digitise {of.root} {of.entry.name}") from error
        write_digitised(of.results, uv, figures)
        return identified(uv, cameras=of.rig.names, rate=self._rate(task)).detections

    def contradictions(self) -> tuple[Finding, ...]:
        """Where the videos' own frame rates contradict the one that is used."""
        task = self.task()
        return _other_rates(task.images, self._rate(task))

    def beside(self) -> Trial | None:
        """Nothing was recorded beside."""
        return None

    def pictures(self, frames: Sequence[int]) -> list[GreyLevels]:
        """The frames."""
        return _pictures(self.of, frames)

    def operated(self) -> OperatorIdentities:
        """The markers that the operator was asked for."""
        of, task = self.of, self.task()
        file = of.results / f"{of.entry.name}.da1"
        marker = read_digitised(file, cameras=of.rig.names, rate=self._rate(task)).seen.marker
        return OperatorIdentities(tuple(task.method.markers), marker, read_figures(of.results))

    def _rate(self, task: Digitising) -> float:
        return self.of.rate(next(iter(task.images.values())).rate)


@dataclass(frozen=True, slots=True)
class Excerpt:
    """Frames first … stop − 1, from 0, of a camera's images."""

    source: ImageSource
    first: int
    stop: int

    @property
    def n_frames(self) -> int:
        """How many there are."""
        return self.stop - self.first

    def batches(self, n: int) -> Iterator[GreyLevels]:
        """The frames, at most n at a time (n, H, W); those before are decoded and passed over."""
        frames = islice(self.source.frames(), self.first, self.stop)
        while batch := list(islice(frames, n)):
            yield np.stack(batch)

    def v_offset(self, f: int) -> float:
        """What to add to v in frame f of the excerpt, px."""
        return self.source.v_offset(self.first + f)


def places_of(marks: Mapping[str, Sequence[tuple[float, float]]], names: Sequence[str]) -> Floats:
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


def frame_of(source: ImageSource, f: int) -> GreyLevels:
    """One frame (H, W) of a camera; all before it are decoded as well."""
    return next(islice(source.frames(), f, None))


def _excerpt(source: ImageSource, of: Recording) -> ImageSource | Excerpt:
    """The stretch of a camera's images that is asked for."""
    return source if of.frames is None else Excerpt(source, *of.stretch(source.n_frames))


def _between(found: Detections, of: Recording) -> Detections:
    """The stretch of detections that is asked for."""
    return found if of.frames is None else found.frames(*of.stretch(found.n_frames))


def _marker_between(seen: Any, of: Recording) -> Ints:
    """The markers of the detections in the stretch that is asked for."""
    if of.frames is None:
        return seen.marker
    first, stop = of.stretch(seen.detections.n_frames)
    frame = seen.detections.frame
    return seen.marker[(frame >= first) & (frame < stop)]


def _pictures(of: Recording, frames: Sequence[int]) -> list[GreyLevels]:
    """One image of each camera, of the frames (C) of the stretch."""
    images, first = of.images(), 0 if of.frames is None else of.frames[0] - 1
    return [frame_of(images[name], first + f) for name, f in zip(of.rig.names, frames, strict=True)]


def _cut(trial: Trial, frames: tuple[int, int], rate: float) -> Trial:
    """Analog channels and events of frames first … last, from 1, at `rate` Hz; times of events stay as they are."""
    begin, end = (frames[0] - 1) / rate, frames[1] / rate
    within = (trial.events.time >= begin) & (trial.events.time < end)
    kept = np.flatnonzero(within).tolist()
    events = Events(
        tuple(trial.events.label[e] for e in kept),
        tuple(trial.events.side[e] for e in kept),
        trial.events.time[within],
    )
    return replace(trial, analog=tuple(_cut_channels(a, begin, end) for a in trial.analog), events=events)


def _cut_channels(analog: Analog, begin: float, end: float) -> Analog:
    """The samples from `begin` to `end`, s after the first frame."""
    first = max(0, int(np.ceil((begin - analog.start) * analog.rate - 1e-6)))
    stop = max(first, int(np.ceil((end - analog.start) * analog.rate - 1e-6)))
    start = max(0.0, analog.start + first / analog.rate - begin)
    return replace(analog, values=analog.values[:, first:stop], start=0.0 if start < 1e-9 else start)


def _other_rates(images: Mapping[str, ImageSource], rate: float) -> tuple[Finding, ...]:
    """Where the videos' own frame rates contradict the one that is used."""
    others = {name: s.rate for name, s in images.items() if s.rate and abs(s.rate - rate) > 0.01 * rate}
    if not others:
        return ()
    return (
        make_finding("frame_rate_contradicted", cameras=others, rate_hz=rate, stated_hz_list=list(others.values())),
    )


def _check_size(camera: Camera, source: ImageSource, interlaced: bool) -> None:
    """Images and calibration must be of one size, or every pixel means another direction."""
    if camera.size.any() and tuple(camera.size) != source.size:
        kind = "fields" if interlaced else "images"
        raise KinemarkError(
            f"Camera {camera.name!r} was calibrated at {camera.size[0]} × {camera.size[1]} px and its {kind} are "
            f"{source.size[0]} × {source.size[1]}. Use images of the calibrated size, or check interlaced in [cameras]."
        )
