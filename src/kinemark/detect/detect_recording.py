"""All cameras of a recording, several at a time."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import nullcontext
from contextvars import copy_context
from dataclasses import replace
from threading import Event, Lock
from types import MappingProxyType

import numpy as np

from ..data import Detections, KinemarkError
from ..data.masks import Masks
from ..data.method import Method
from ..numerics.blas_threads import one_blas_thread
from .blobs import joined
from .camera_process import camera_processes
from .detect_camera import detect_camera
from .frame_source import FrameSource, InFiles
from .masks import check_masks
from .stage import DETECT

PROCESSES_FROM = 3000
"""Images of all cameras together from which on processes of their own are worth their start; chosen by
benchmarks/detection_speed.py."""


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
        threads: how many cameras are looked at side by side; as many as there are processors where None. Long
            recordings in files are, in processes of their own.
        equal_lengths: whether all cameras must have equal numbers of frames; cameras of other rates have not, and a
            shorter recording then has no detections after its end.

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

    number = max(1, min(threads or os.cpu_count() or 1, len(sources)))
    methods = [of_cameras.get(name) or method or DETECT.make() for name in cameras]
    pixels = [masks.pixels(name) if masks and name in masks.cameras else None for name in cameras]
    alone = number == 1 or not _worth_processes(sources, methods)
    with nullcontext(detect_camera) if alone else camera_processes(number) as one, ThreadPoolExecutor(number) as pool:
        try:
            found = list(pool.map(one, sources, cameras, methods, pixels, [tell] * len(sources)))
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
    if equal and len(set(lengths)) > 1:
        found = ", ".join(f"{name} {n}" for name, n in zip(cameras, lengths, strict=True))
        raise KinemarkError(
            f"The cameras have different numbers of frames: {found}. Synchronised cameras have equal ones; "
            "cut the recordings to the frames that all cameras share, or state rates_hz in [cameras] where rates "
            "differ."
        )
    return max(lengths, default=0)


def _worth_processes(sources: Sequence[FrameSource], methods: Sequence[Method]) -> bool:
    """Whether there is much to do, and another interpreter can be told what."""
    known = all(type(part).__module__ != "__main__" for part in (*sources, *methods))
    in_files = all(isinstance(source, InFiles) for source in sources)
    return bool(sys.executable) and known and in_files and sum(s.n_frames for s in sources) >= PROCESSES_FROM
