"""All cameras of a recording, several at a time."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import replace
from threading import Event, Lock
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ..data import Detections, KinemarkError
from ..data.array_types import GreyLevels
from ..data.masks import Masks
from ..data.method import Method
from ..numerics.blas_threads import one_blas_thread
from .blobs import Blobs, joined
from .centroids_method import Centroids
from .detect_frames import detect_frames, find_suspects
from .frame_source import BATCH, FrameSource, prefetched
from .ground import Ground
from .learning import learned
from .levels import levelled_by_first
from .masks import check_masks, masked
from .separate import Suspects, separated
from .stage import DETECT

WAITING = 1 << 18
"""Pixels of suspected groups that are kept until they are explained together; chosen for memory."""

FEWER = 0.03
"""Share of the frames that a camera may lack, which began or stopped apart, or lost some: findings say so. Chosen:
rates of cameras differ by 4 % and more, as 24 and 25 Hz."""


@one_blas_thread()
def detect(
    sources: Sequence[FrameSource],
    *,
    cameras: Sequence[str],
    rate: float,
    method: Method | None = None,
    of_cameras: Mapping[str, Method] = MappingProxyType({}),
    masks: Masks | None = None,
    progress: Callable[[int], None] | None = None,
    threads: int | None = None,
    equal_lengths: bool = True,
) -> Detections:
    """Markers in the recordings of all cameras, at `rate` Hz.

    Args:
        sources: what each camera recorded; the next images are decoded while markers are looked for.
        cameras: their names.
        rate: frames a second, Hz.
        method: one of `DETECT`, `Centroids()` where None; a relative threshold is measured once a camera, in the first
            frames that show something.
        of_cameras: methods of single cameras by their names, in its place.
        masks: where nothing is a marker, for some or all of the cameras.
        progress: called with the number of frames done so far, all cameras together, from the threads that do them.
        threads: how many cameras are looked at side by side; as many as there are processors where None.
        equal_lengths: whether all cameras must have equal numbers of frames, but for `FEWER`; cameras of other rates
            have not. A shorter recording has no detections after its end.

    Raises:
        ValueError: not one name a source, or a method of a camera that is not there.
        KinemarkError: the cameras have unequal numbers of frames, a recording ends early, a threshold that lies
            in the noise, or masks of other cameras or of other sizes.
    """
    if len(sources) != len(cameras):
        raise ValueError(f"there are {len(sources)} sources and {len(cameras)} camera names, wanted one each")
    if unknown := [name for name in of_cameras if name not in cameras]:
        raise ValueError(f"of_cameras names {', '.join(unknown)}, and the cameras are {', '.join(cameras)}")
    check_masks(masks, cameras)
    n_frames = _common_length(sources, cameras, equal_lengths)
    done, lock, stopped = [0], Lock(), Event()
    here = copy_context()  # else nobody hears what is told in other threads

    def tell(frames: int) -> None:
        if stopped.is_set():
            raise CancelledError
        with lock:
            done[0] += frames
            if progress:
                here.run(progress, done[0])

    def one(source: FrameSource, name: str) -> tuple[Blobs, bool]:
        mask = masks.pixels(name) if masks and name in masks.cameras else None
        return _detect_camera(source, name, of_cameras.get(name) or method or DETECT.make(), mask, tell)

    with ThreadPoolExecutor(max(1, min(threads or os.cpu_count() or 1, len(sources)))) as pool:
        try:
            found = list(pool.map(one, sources, cameras))
        except BaseException:
            stopped.set()  # the other cameras go no further than their next batch
            raise
    if not found:
        return Detections.build((), rate, np.zeros((0, 0), np.int64), np.zeros((0, 2)))
    all_cameras = joined([blobs for blobs, _ in found])
    counts = np.array([np.pad(blobs.counts, (0, n_frames - len(blobs.counts))) for blobs, _ in found])
    columns = {k: v for k, v in all_cameras._asdict().items() if k != "counts"}
    subtracted = tuple(name for name, (_, taken) in zip(cameras, found, strict=True) if taken)
    return replace(Detections.build(tuple(cameras), rate, counts, **columns), ground_subtracted=subtracted)


def _common_length(sources: Sequence[FrameSource], cameras: Sequence[str], equal: bool) -> int:
    lengths = [source.n_frames for source in sources]
    if equal and min(lengths, default=0) < (1 - FEWER) * max(lengths, default=0):
        found = ", ".join(f"{name} {n}" for name, n in zip(cameras, lengths, strict=True))
        raise KinemarkError(
            f"The cameras have different numbers of frames: {found}. Synchronised cameras have equal ones. "
            "Where one began late or stopped early, cut the others at that end. Where one lost images in between, put "
            "black ones in their places: cut at an end, its later images would stand in wrong frames. Where rates "
            "differ, state rates_hz in [cameras]."
        )
    return max(lengths, default=0)


def _detect_camera(
    source: FrameSource, name: str, method: Method, mask: NDArray[np.bool_] | None, tell: Callable[[int], None]
) -> tuple[Blobs, bool]:
    """One camera's detections, batch by batch, and whether its ground was subtracted.

    Raises:
        KinemarkError: more or fewer frames come than the source has announced, or see `detect_frames`.
    """
    method, ground = for_camera(method, source)
    camera = _Camera(source, name, mask, ground)
    ready, shows = levels_of(method, source, ground)
    first, size = 0, None
    for images in prefetched(source):
        if size is None:
            size = images.shape[1:]
            _check_mask(mask, size, name)
        _check_size(images, size, f"{name}: frame {first + 1} of {source.n_frames}")
        # where nothing has stood out from the background so far, there was no marker either
        camera.look(images, first, ready if first + len(images) > shows else None)
        first += len(images)
        tell(len(images))
    if first != source.n_frames:
        raise KinemarkError(
            f"Camera {name}: {first} frames could be read of the {source.n_frames} that the recording announces. "
            "Copy the recording again, or cut all cameras to the frames that are there."
        )
    return camera.blobs(), ground is not None


class _Camera:
    """What is found in the batches of a camera; suspected groups of several batches are explained together."""

    def __init__(self, source: FrameSource, name: str, mask: NDArray[np.bool_] | None, ground: Ground | None) -> None:
        """Take what holds for all batches."""
        self.source, self.name, self.mask, self.ground = source, name, mask, ground
        self.frames = 0
        self.parts = [_none(0)]
        self.waiting: list[Suspects] = []
        self.method = Centroids()

    def look(self, images: NDArray[np.uint8 | np.uint16], first: int, method: Method | None) -> None:
        """Take a batch, of which the first frame has this number; without a method there is nothing in it."""
        if not isinstance(method, Centroids):
            self._add(detect_frames(images, method=method) if method else _none(len(images)))
            return
        self.method = method
        try:
            self.waiting += [*find_suspects(images, method=method, first=first, ground=self.ground)]
        except KinemarkError as error:
            raise KinemarkError(
                f"Camera {self.name}, batch from frame {first + 1} of {self.source.n_frames} on: {error}"
            ) from None
        if sum(len(part.pixels.grey) for part in self.waiting if part.pixels) > WAITING:
            self._explain()

    def blobs(self) -> Blobs:
        """All that was found."""
        self._explain()
        return joined(self.parts)

    def _explain(self) -> None:
        waiting, self.waiting = self.waiting, []
        if waiting:
            self._add(separated(waiting, method=self.method))

    def _add(self, blobs: Blobs) -> None:
        """Note what was found in the next frames: grey levels of the recording, masked, fields on one plane."""
        frames = self.frames + np.arange(len(blobs.counts))
        self.frames += len(frames)
        if (ground := self.ground) is not None:
            blobs = blobs._replace(peak=ground.recorded(blobs.peak, blobs.uv, np.repeat(frames, blobs.counts)))
        blobs = blobs if self.mask is None else masked(blobs, self.mask)
        offset = np.repeat([self.source.v_offset(f) for f in frames.tolist()], blobs.counts)
        self.parts.append(blobs._replace(uv=blobs.uv + np.stack([np.zeros(len(offset)), offset], -1)))


def for_camera(method: Method, source: FrameSource) -> tuple[Method, Ground | None]:
    """The method with what it leaves to the camera: threshold, sizes, form of markers in fields; and the ground."""
    if not isinstance(method, Centroids):
        return method, None
    if method.aspect is None:
        fields = source.v_offset(0) != source.v_offset(1)
        method = replace(method, aspect=0.5 if fields else 1.0)
    return learned(method, source)


def levels_of(method: Method, source: FrameSource, ground: Ground | None) -> tuple[Method | None, int]:
    """The method with the threshold that a relative one means for a camera, None where nothing shows; from which frame.

    A method without one is returned as it is, from frame 0 on.
    """
    if getattr(method, "relative_threshold", None) is None:
        return method, 0
    return levelled_by_first(method, _under(source, ground))


def _under(source: FrameSource, ground: Ground | None) -> Iterator[GreyLevels]:
    """The batches of a source without the ground."""
    first = 0
    for images in source.batches(BATCH):
        yield images if ground is None else ground.taken_from(images, first)
        first += len(images)


def _none(frames: int) -> Blobs:
    """The detections of frames without any."""
    return detect_frames(np.zeros((frames, 1, 1), np.uint8))


def _check_mask(mask: NDArray[np.bool_] | None, size: tuple[int, ...], name: str) -> None:
    if mask is not None and mask.shape != size:
        raise KinemarkError(
            f"Camera {name}: its mask is for images of {_by(mask.shape)}, and they have {_by(size)}. "
            "Masks of interlaced video are in the lines of a field."
        )


def _check_size(images: NDArray[np.uint8 | np.uint16], size: tuple[int, ...], where: str) -> None:
    if images.shape[1:] != size:
        raise KinemarkError(
            f"Camera {where} has {_by(images.shape[1:])}, and the first one {_by(size)}. "
            "Export the recording again, all frames in one size."
        )


def _by(shape: tuple[int, ...]) -> str:
    return f"{shape[1]} × {shape[0]} px"
