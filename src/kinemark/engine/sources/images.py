"""Images or videos of all cameras, in which markers are detected."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...data import Detections, Finding, make_finding
from ...data.array_types import GreyLevels
from ...data.progress import tell
from ...detect import detect
from ...io.images import ImageSource
from ..keys import digest, file_key
from ..pictures.small_videos import watched
from ..recordings import masks_key, masks_of, methods_of
from .excerpt import excerpt_of, pictures_of
from .recording import Recording
from .trial_source import PlainSource


@dataclass(frozen=True, slots=True)
class Images(PlainSource):
    """Images or videos of all cameras, in which markers are detected."""

    of: Recording

    def key(self) -> str:
        """Of the files, the cameras' order, the rate, fields, fixed marks, the cameras' times, masks, and frames."""
        of, images = self.of, self.of.images()
        files = [path for source in images.values() for path in source.paths]
        fields, names = str(of.settings.cameras.first_field), of.rig.names
        masks = masks_key(of.root, of.settings, names)
        taken = of.frames, of.entry.every
        return digest(file_key(*files), names, self._rate(images), fields, of.corrections(), masks, taken)

    def detections(self, threads: int | None = None) -> Detections:
        """By the session's `[detect]`, without what its `[masks]` cover."""
        of, images = self.of, self.of.images()
        taken = {name: excerpt_of(source, of) for name, source in images.items()}
        sources = watched(images, taken, of.first_frame - 1, of.results)
        total = sum(source.n_frames for source in sources)
        method: Any = of.settings.detect
        found = detect(
            sources,
            cameras=of.rig.names,
            rate=self._rate(images),
            method=method,
            of_cameras=methods_of(of.settings, of.rig.names),
            masks=masks_of(of.root, of.settings, of.rig.names),
            progress=lambda done: tell(done, total),
            threads=threads,
            equal_lengths=not of.settings.cameras.rates_hz,
        )
        return of.corrected(found).detections

    def contradictions(self) -> tuple[Finding, ...]:
        """Where the videos' own frame rates contradict the one that is used, and cameras have fewer images."""
        images, stated = self.of.images(), self.of.settings.cameras.rates_hz
        alike = {name: source for name, source in images.items() if name not in stated}
        return (*other_rates(alike, self._rate(images)), *fewer_images(alike))

    def pictures(self, frames: Sequence[int]) -> list[GreyLevels]:
        """The frames, counted within the stretch."""
        return pictures_of(self.of, frames)

    def _rate(self, images: Mapping[str, ImageSource]) -> float:
        return self.of.rate(next(iter(images.values())).rate)


def fewer_images(images: Mapping[str, ImageSource]) -> Iterator[Finding]:
    """Of each camera that has fewer images than the others."""
    most = max((source.n_frames for source in images.values()), default=0)
    for name, source in images.items():
        if source.n_frames < most:
            yield make_finding("camera_fewer_images", cameras=[name], images=source.n_frames, most_images=most)


def other_rates(images: Mapping[str, ImageSource], rate: float) -> tuple[Finding, ...]:
    """Where the videos' own frame rates contradict the one that is used."""
    others = {name: s.rate for name, s in images.items() if s.rate and abs(s.rate - rate) > 0.01 * rate}
    if not others:
        return ()
    return (
        make_finding("frame_rate_contradicted", cameras=others, rate_hz=rate, stated_hz_list=list(others.values())),
    )
