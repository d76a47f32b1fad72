"""A stretch of a recording: of images, of detections, and of what was recorded beside them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from ...data import Analog, Detections, Events, Trial
from ...data.array_types import GreyLevels, Ints
from ...io.images import ImageSource
from .recording import Recording


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

    def frames_at(self, wanted: Ints) -> GreyLevels:
        """Frames (n, H, W) of these rising numbers within the excerpt."""
        return self.source.frames_at(self.first + wanted)

    def frames_near(self, wanted: Ints) -> tuple[Ints, GreyLevels]:
        """Numbers (n) of frames near these rising ones, and the frames, those of the excerpt alone."""
        numbers, images = self.source.frames_near(self.first + wanted)
        inside = numbers >= self.first
        return (numbers[inside] - self.first, images[inside]) if inside.any() else (wanted, self.frames_at(wanted))

    def v_offset(self, f: int) -> float:
        """What to add to v in frame f of the excerpt, px."""
        return self.source.v_offset(self.first + f)


def frame_of(source: ImageSource, f: int) -> GreyLevels:
    """One frame (H, W) of a camera."""
    return source.frames_at(np.array([f]))[0]


def excerpt_of(source: ImageSource, of: Recording) -> ImageSource | Excerpt:
    """The stretch of a camera's images that is asked for."""
    return source if of.frames is None else Excerpt(source, *of.stretch(source.n_frames))


def within(found: Detections, of: Recording) -> Detections:
    """The stretch of detections that is asked for."""
    return found if of.frames is None else found.frames(*of.stretch(found.n_frames))


def pictures_of(of: Recording, frames: Sequence[int]) -> list[GreyLevels]:
    """One image of each camera, of the frames (C) of the stretch."""
    images = of.images()
    return [
        frame_of(images[name], of.image_of(name, f, images[name])) for name, f in zip(of.rig.names, frames, strict=True)
    ]


def cut(trial: Trial, frames: tuple[int, int], rate: float) -> Trial:
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
