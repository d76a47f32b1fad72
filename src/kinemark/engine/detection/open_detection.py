"""The images of a trial and what is detected in one frame of each camera, while thresholds and sizes are being chosen.

What is tried stands in a `Draft`, which says what `[detect]`, `[detect.cameras.NAME]` and the file of `[masks]` would
say; nothing is written before `detection_file.apply`. A frame is detected as a run would detect it: what is left open
is learned from the camera's recording, and its static ground is subtracted (1).
"""

from __future__ import annotations

import threading
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...data import KinemarkError
from ...data.array_types import Bools, Floats, GreyLevels, Ints
from ...data.errors import users_mistake
from ...data.masks import Masks
from ...data.method import Method
from ...detect import Blobs, Centroids, combined_masks, detect_frames
from ...detect.centroids_method import grey_scale
from ...detect.detect_frames import find_suspects
from ...detect.detect_recording import for_camera, levels_of
from ...detect.ground import Ground
from ...detect.levels import levelled
from ...detect.masks import masked
from ...detect.separate import separated
from ...io.exact_frames import ExactImages
from ...io.images import ImageSource, png_bytes
from ...io.masks_toml import read_masks
from ..recordings import masks_of, open_cameras
from ..session import Session
from ..session_name import FILE
from ..settings import method_of
from ..settings.method_tables import methods_of_cameras
from ..sources.excerpt import Excerpt

KEPT = 64
"""Methods with what was learned that are remembered; chosen: eight tries of eight cameras."""


@dataclass(frozen=True, slots=True)
class Draft:
    """What a person tries; what it does not say is as `session.toml` has it.

    Attributes:
        every: parameters of `[detect]`; None: leave it open.
        cameras: parameters of `[detect.cameras.NAME]`; None: as for all cameras.
        masks: polygons (n, 2) px of the cameras whose drawn masks are others.
    """

    every: Mapping[str, Any] = field(default_factory=dict)
    cameras: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    masks: Mapping[str, tuple[Floats, ...]] = field(default_factory=dict)


def with_draft(table: dict[str, Any], draft: Draft) -> dict[str, Any]:
    """The table `[detect]` of a session file, that of its cameras within, as a draft would have it."""
    own = {name: dict(of) for name, of in table.get("cameras", {}).items()}
    for name, of in draft.cameras.items():
        own[name] = _stated({**own.get(name, {}), **of})
    every = _stated({key: value for key, value in table.items() if key != "cameras"} | dict(draft.every))
    own = {name: of for name, of in own.items() if of}
    return every | ({"cameras": own} if own else {})


def _stated(table: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in table.items() if value is not None}


class InFrame(NamedTuple):
    """What is detected in one frame of a camera.

    Attributes:
        image: (H, W) as it was recorded; seen: the same without the ground, where one is subtracted.
        method: as it was used, with nothing left open; None where nothing stands out in the whole recording.
        ground: whether a static ground was subtracted.
        blobs: the detections, v in lines of this image. mask: (H, W) of the camera, where it has one.
    """

    image: GreyLevels
    seen: GreyLevels
    method: Method | None
    ground: bool
    blobs: Blobs
    mask: Bools | None

    @property
    def level(self) -> float:
        """The threshold in the image's own grey levels."""
        return threshold_of(self.method) * grey_scale(self.image.dtype) if self.method else np.inf

    @property
    def inverted(self) -> bool:
        """Whether pixels darker than the threshold are white."""
        return bool(getattr(self.method, "inverted", False))

    @property
    def white(self) -> Bools:
        """(H, W) which pixels are white."""
        return np.asarray(self.seen < self.level if self.inverted else self.seen > self.level)


def threshold_of(method: Method) -> float:
    """Of a method with nothing left open, grey levels of 8 bits."""
    return float(method.limits.threshold if isinstance(method, Centroids) else getattr(method, "threshold"))  # noqa: B009


class _Learned(NamedTuple):
    method: Method | None
    ground: Ground | None


class _Remembered:
    """A recording whose frames that are learned from are decoded once, however often something is tried."""

    def __init__(self, source: ImageSource | Excerpt) -> None:
        self._source, self._known = source, dict[bytes, tuple[Ints, GreyLevels]]()
        self.n_frames, self.v_offset, self.batches = source.n_frames, source.v_offset, source.batches
        self.frames_at = source.frames_at

    def frames_near(self, wanted: Ints) -> tuple[Ints, GreyLevels]:
        """As that of `FrameSource`."""
        key = wanted.tobytes()
        if key not in self._known:
            self._known[key] = self._source.frames_near(wanted)
        return self._known[key]


class OpenDetection:
    """The images of a trial, and its detection.

    Attributes:
        session: that the trial is of. table: `[detect]` of its file.
        sources: the images of each camera. first: number of the first frame, n_frames: of the stretch.
        every: one frame of so many of the recording is taken, and counted.
        operated: whether an operator digitises it, so that nothing is learned from the recording.
    """

    def __init__(self, root: Path, trial: str) -> None:
        """Open the images.

        Raises:
            KinemarkError: the session cannot be read, or the trial has no images.
        """
        self.session = Session.open(root)
        self.table: dict[str, Any] = tomllib.loads((root / FILE).read_text("utf-8-sig")).get("detect", {})
        entry = self.session.trial(trial).entry
        if entry.images is None:
            raise KinemarkError(f"{trial} has no images: its detections were made elsewhere.")
        self.every, names = entry.every, self.session.camera_names
        self.sources = open_cameras(root, self.session.settings, entry.images, names, every=entry.every)
        shortest = min(source.n_frames for source in self.sources.values())
        self.first, last = entry.frames or (1, shortest)
        self.n_frames = min(last, shortest) - self.first + 1
        self._excerpt, self.operated = entry.frames, entry.answers is not None
        self._exact: dict[str, ExactImages] = {}
        self._locks = {name: threading.Lock() for name in self.sources}
        self._learning = {name: threading.Lock() for name in self.sources}
        self._learned: dict[tuple[str, Method], _Learned] = {}
        self._recordings: dict[str, _Remembered] = {}

    def image(self, camera: str, frame: int) -> GreyLevels:
        """(H, W) of a frame by its number in the recording, as it was recorded.

        Raises:
            KinemarkError: there is no such camera or frame, or it is damaged.
        """
        if camera not in self.sources:
            raise KinemarkError(f"There is no camera {camera}; there are {', '.join(self.sources)}.")
        if not 1 <= frame <= self.sources[camera].n_frames:
            raise KinemarkError(f"{camera} has frames 1 to {self.sources[camera].n_frames}, and {frame} was asked for.")
        with self._locks[camera]:
            if camera not in self._exact:
                self._exact[camera] = ExactImages(self.sources[camera])
            return self._exact[camera].frame(frame - 1).copy()  # the decoder's own memory otherwise

    def picture(self, camera: str, frame: int) -> bytes:
        """The same as PNG of 8 bits, as a screen shows it."""
        image = self.image(camera, frame)
        if image.dtype != np.uint8:
            image = (image >> self.shift(image)).clip(0, 255).astype(np.uint8)
        return png_bytes(image)

    @staticmethod
    def shift(image: GreyLevels) -> int:
        """Bits of a deeper image above the eight that are shown."""
        return max(int(image.max()).bit_length() - 8, 0) if image.dtype != np.uint8 else 0

    def methods(self, draft: Draft) -> dict[str, Method]:
        """The method of each camera, as a draft would have it; open parameters are open.

        Raises:
            KinemarkError: it says what cannot be.
        """
        if unknown := [name for name in (*draft.cameras, *draft.masks) if name not in self.sources]:
            raise KinemarkError(f"There is no camera {unknown[0]}; there are {', '.join(self.sources)}.")
        table = with_draft(self.table, draft)
        with users_mistake():
            every = method_of("detect", {key: value for key, value in table.items() if key != "cameras"})
            of_cameras = methods_of_cameras(
                {k: v for k, v in table.items() if k != "cameras"}, table.get("cameras", {})
            )
        return {name: of_cameras.get(name, every) for name in self.sources}

    def detected(self, camera: str, frame: int, draft: Draft) -> InFrame:
        """What a run would detect in a frame, by its number in the recording; (1).

        Raises:
            KinemarkError: as `image` and `methods`, or the threshold lies in the noise.
        """
        image, source = self.image(camera, frame), self.sources[camera]
        method, ground = self._of_camera(camera, self.methods(draft)[camera])
        seen = image if ground is None else ground.taken_from(image[None], frame - self.first)[0]
        if method is not None and self.operated:  # each image is measured by itself
            method = levelled(method, image[None])
        empty = np.zeros((1, 1, 1), np.uint8)
        if ground is not None and isinstance(method, Centroids):
            suspects = find_suspects(image[None], method=method, first=frame - self.first, ground=ground)
            blobs = separated([*suspects], method=method)
        else:
            blobs = detect_frames(seen[None] if method else empty, method=method)
        mask = self._mask(camera, draft)
        if mask is not None:
            if mask.shape != image.shape:
                raise KinemarkError(f"The mask of {camera} is for images of another size. Draw it anew.")
            blobs = masked(blobs, mask)
        offset = np.array([0.0, source.v_offset(frame - 1)])
        return InFrame(image, seen, method, ground is not None, blobs._replace(uv=blobs.uv + offset), mask)

    def drawn(self) -> Masks | None:
        """The masks of the file that `[masks]` names; None where it names none."""
        way = self.session.settings.masks
        return read_masks(self.session.root / way.file) if way and way.file else None

    def size(self, camera: str) -> tuple[int, int]:
        """Width and height, px; of a field where interlaced."""
        return self.sources[camera].size

    def _mask(self, camera: str, draft: Draft) -> Bools | None:
        """(H, W) what is drawn, as a draft has it, and learned; None where there is nothing."""
        masks = self._masks(draft, camera)
        return masks.pixels(camera) if masks and camera in masks.cameras else None

    def _masks(self, draft: Draft, camera: str) -> Masks | None:
        settings, root = self.session.settings, self.session.root
        if camera not in draft.masks:
            return masks_of(root, settings, tuple(self.sources))
        candidate = Masks((camera,), np.array([self.size(camera)]), (tuple(draft.masks[camera]),))
        way = settings.masks
        if way is None or way.empty is None:
            return candidate
        alone = settings.model_copy(update={"masks": way.model_copy(update={"file": None})})
        learned = masks_of(root, alone, tuple(self.sources))
        return candidate if learned is None else combined_masks(candidate, learned)

    def _of_camera(self, camera: str, method: Method) -> _Learned:
        """The method with what it leaves open, learned once, however many ask for it meanwhile."""
        key = camera, method
        if self.operated and isinstance(method, Centroids):
            fields = 0.5 if self.sources[camera].interlaced else 1.0
            return _Learned(replace(method, aspect=method.aspect or fields), None)
        with self._learning[camera]:
            learned = self._learned.get(key)
            if learned is None:
                source = self._recording(camera)
                found, ground = for_camera(method, source)
                ready, _ = levels_of(found, source, ground)
                self._learned[key] = learned = _Learned(ready, ground)
        while len(self._learned) > KEPT:
            self._learned.pop(next(iter(self._learned)), None)
        return learned

    def _recording(self, camera: str) -> _Remembered:
        """The stretch that a run would learn from."""
        if camera not in self._recordings:
            source = self.sources[camera]
            whole = self._excerpt is None
            first = self.first - 1
            self._recordings[camera] = _Remembered(source if whole else Excerpt(source, first, first + self.n_frames))
        return self._recordings[camera]
