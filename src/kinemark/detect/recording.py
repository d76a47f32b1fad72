"""All cameras of a recording, several at a time."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Lock
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..data import Detections, KinemarkError
from .blobs import Blobs, joined
from .frames import detect_frames
from .method import Centroids

BATCH = 16


class Source(Protocol):
    """What one camera recorded."""

    @property
    def n_frames(self) -> int:
        """F."""
        ...

    def batches(self, n: int, /) -> Iterator[NDArray[np.uint8 | np.uint16]]:
        """The frames in order, at most n at a time, (n, H, W) grey levels."""
        ...

    def v_offset(self, f: int, /) -> float:
        """What to add to v in frame f, px: half a line in every other field of interlaced video."""
        ...


def detect(
    sources: Sequence[Source],
    *,
    cameras: Sequence[str],
    rate: float,
    method: Centroids | None = None,
    progress: Callable[[int], None] | None = None,
) -> Detections:
    """Markers in the recordings of all cameras, at `rate` Hz.

    `progress` is called with the number of frames done so far, all cameras together, from the threads that do them.

    Raises:
        ValueError: not one name a source.
        KinemarkError: the cameras have unequal numbers of frames, a recording ends early, or a threshold
            that lies in the noise.
    """
    if len(sources) != len(cameras):
        raise ValueError(f"there are {len(sources)} sources and {len(cameras)} camera names, wanted one each")
    n_frames = _common_length(sources, cameras)
    done, lock = [0], Lock()

    def tell(frames: int) -> None:
        with lock:
            done[0] += frames
            if progress:
                progress(done[0])

    def one(source: Source, name: str) -> Blobs:
        return _detect_camera(source, name, method or Centroids(), tell)

    with ThreadPoolExecutor(max(1, min(os.cpu_count() or 1, len(sources)))) as pool:
        parts = list(pool.map(one, sources, cameras))
    if not parts:
        return Detections.build((), rate, np.zeros((0, 0), np.int64), np.zeros((0, 2)))
    all_cameras = joined(parts)
    counts = all_cameras.counts.reshape(len(cameras), n_frames)
    return Detections.build(
        tuple(cameras), rate, counts, **{k: v for k, v in all_cameras._asdict().items() if k != "counts"}
    )


def _common_length(sources: Sequence[Source], cameras: Sequence[str]) -> int:
    lengths = [source.n_frames for source in sources]
    if len(set(lengths)) > 1:
        found = ", ".join(f"{name} {n}" for name, n in zip(cameras, lengths, strict=True))
        raise KinemarkError(
            f"The cameras have different numbers of frames: {found}. Synchronised cameras have equal ones; "
            "cut the recordings to the frames that all cameras share."
        )
    return lengths[0] if lengths else 0


def _detect_camera(source: Source, name: str, method: Centroids, tell: Callable[[int], None]) -> Blobs:
    """One camera's detections, batch by batch.

    Raises:
        KinemarkError: more or fewer frames come than the source has announced, or see `detect_frames`.
    """
    nothing = detect_frames(np.zeros((0, 1, 1), np.uint8), method=method)
    parts, first = [nothing], 0
    for images in source.batches(BATCH):
        parts.append(_detect_batch(source, images, first, name, method))
        first += len(images)
        tell(len(images))
    if first != source.n_frames:
        raise KinemarkError(
            f"Camera {name}: {first} frames could be read of the {source.n_frames} that the recording announces. "
            "Copy the recording again, or cut all cameras to the frames that are there."
        )
    return joined(parts)


def _detect_batch(
    source: Source, images: NDArray[np.uint8 | np.uint16], first: int, name: str, method: Centroids
) -> Blobs:
    try:
        blobs = detect_frames(images, method=method)
    except KinemarkError as error:
        raise KinemarkError(f"Camera {name}, batch from frame {first} on: {error}") from None
    offset = np.array([source.v_offset(first + k) for k in range(len(images))], np.float64)
    return blobs._replace(uv=blobs.uv + np.stack([np.zeros(len(blobs.uv)), np.repeat(offset, blobs.counts)], -1))
