"""What every source of a trial knows, and what it does to the detections of any of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...calibrate.reference_marker import corrected, find_marks, reference_shift
from ...data import Camera, Detections, KinemarkError, Rig
from ...data.array_types import Floats
from ...io.images import ImageSource
from ...signal.common_time import CommonTime, at_common_time
from ..lost_images import check_no_image_lost
from ..recordings import open_cameras
from ..settings import Settings, TrialEntry

Frames = tuple[int, int] | None
"""First and last frame of a stretch, counted from 1, both included; None means all."""


MAX_RATE_RATIO = 100.0
"""Of a camera's rate to that of the frames, either way: more is a slip of the decimal point; chosen."""


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

    @property
    def first_frame(self) -> int:
        """Number in the recording of the first frame of the stretch."""
        return 1 if self.frames is None else self.frames[0]

    def rate(self, stated: float | None) -> float:
        """Frames a second that are taken: by what the settings say of the recording, else as the file does.

        Raises:
            KinemarkError: neither says it.
        """
        rate = self.settings.rate_hz / self.entry.every if self.settings.rate_hz else stated
        if not rate:
            raise KinemarkError(f"Trial {self.entry.name!r} does not say its frame rate. Set rate_hz in session.toml.")
        return rate

    def images(self) -> dict[str, ImageSource]:
        """The frames of each camera that are taken, of the size that it was calibrated at."""
        entry = self.entry
        images = open_cameras(self.root, self.settings, str(entry.images), self.rig.names, every=entry.every)
        check_no_image_lost({name: i for name, i in images.items() if name not in self.settings.cameras.rates_hz})
        for camera in self.rig:
            _check_size(camera, images[camera.name], self.settings.cameras.interlaced is not False)
        return images

    def corrections(self) -> list[object]:
        """What the session says of fixed marks and of the cameras' times, for a key; nothing where it says nothing."""
        way, cameras = self.settings.calibration, self.settings.cameras
        times: list[object] = [cameras.delays_ms, cameras.rates_hz] if self.own_times else []
        if way.reference_marker is None:
            return times
        return [way.reference_marker, way.mark_reach_px, way.mark_tolerance_px, self.entry.reference_marker, *times]

    @property
    def own_times(self) -> bool:
        """Whether the session says that cameras take their images at times of their own."""
        return bool(self.settings.cameras.delays_ms or self.settings.cameras.rates_hz)

    def corrected(self, found: Detections) -> CommonTime:
        """The detections with fixed marks and the cameras' times taken into account, and the row of each in `found`."""
        return self.at_common_time(self.unshifted(found))

    def at_common_time(self, found: Detections) -> CommonTime:
        """The detections at the times of the frames, by `delays_ms` and `rates_hz`.

        Raises:
            KinemarkError: one of these names a camera that is not there, or a rate is of another order.
        """
        cameras, names = self.settings.cameras, found.cameras
        if not self.own_times:
            return CommonTime(found, np.arange(len(found)))
        if unknown := sorted({*cameras.delays_ms, *cameras.rates_hz} - set(names)):
            raise KinemarkError(
                f"delays_ms and rates_hz of [cameras] name {', '.join(unknown)}, and the cameras are "
                f"{', '.join(names)}. Call them alike."
            )
        delay = [cameras.delays_ms.get(name, 0.0) / 1000 for name in names]
        rate = [self._own_rate(name, found.rate) for name in names]
        if not all(found.rate / MAX_RATE_RATIO <= own <= found.rate * MAX_RATE_RATIO for own in rate):
            raise KinemarkError(
                f"rates_hz of [cameras] are {', '.join(f'{own:g}' for own in rate)}, and frames come at "
                f"{found.rate:g} Hz. "
                f"Give rates within {MAX_RATE_RATIO:g} times of it."
            )
        return at_common_time(found, delay, rate=rate, first_frame=self.first_frame - 1)

    def image_of(self, camera: str, frame: int, source: ImageSource) -> int:
        """Number of the camera's image that is nearest in time to a frame of the stretch, both in the recording."""
        return int(np.clip(self.image_at(camera, frame + self.first_frame - 1, source), 0, source.n_frames - 1))

    def image_at(self, camera: str, frame: int, source: ImageSource) -> int:
        """The same of a frame of the recording, from 0; a number that there is no image of where none was taken."""
        if not self.own_times:
            return frame
        cameras, rate = self.settings.cameras, self.rate(source.rate)
        late, own = cameras.delays_ms.get(camera, 0.0) / 1000, self._own_rate(camera, rate)
        return round((frame / rate - late) * own)

    def _own_rate(self, camera: str, rate: float) -> float:
        """Images a second of a camera that are taken, where the others have so many."""
        stated = self.settings.cameras.rates_hz.get(camera)
        return rate if stated is None else stated / self.entry.every

    def unshifted(self, found: Detections) -> Detections:
        """The detections as they would be, had no image shifted since the calibration; by fixed marks, where given.

        Raises:
            KinemarkError: the marks do not fit those of the calibration, or see `reference_shift`.
        """
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


def _check_size(camera: Camera, source: ImageSource, interlaced: bool) -> None:
    """Images and calibration must be of one size, or every pixel means another direction."""
    if camera.size.any() and tuple(camera.size) != source.size:
        kind = "fields" if interlaced else "images"
        raise KinemarkError(
            f"Camera {camera.name!r} was calibrated at {camera.size[0]} × {camera.size[1]} px and its {kind} are "
            f"{source.size[0]} × {source.size[1]}. Use images of the calibrated size, or check interlaced in [cameras]."
        )
