"""What detection asks of a recording."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..numerics.evenly import evenly

BATCH = 16  # frames read in one go; chosen for memory


class FrameSource(Protocol):
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


@runtime_checkable
class RandomAccess(Protocol):
    """A source that gives single frames without decoding all before them."""

    def frames_at(self, wanted: NDArray[np.int64], /) -> NDArray[np.uint8 | np.uint16]:
        """The frames (n, H, W) of these numbers (n), which rise."""
        ...

    def frames_near(self, wanted: NDArray[np.int64], /) -> tuple[NDArray[np.int64], NDArray[np.uint8 | np.uint16]]:
        """Numbers (n) of frames near these rising ones, and the frames, at the least cost of decoding."""
        ...


def spread(source: FrameSource, n: int) -> tuple[NDArray[np.int64], NDArray[np.uint8 | np.uint16]]:
    """Numbers of at most n frames of a recording, spread about evenly, and these (n, H, W): see `spread_at`."""
    wanted = evenly(source.n_frames, n)
    return source.frames_near(wanted) if isinstance(source, RandomAccess) else spread_at(source, wanted)


def spread_at(
    source: FrameSource, wanted: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.uint8 | np.uint16]]:
    """Frames (n, H, W) of these rising numbers, and the numbers.

    There are fewer where the recording ends early, or the size of its frames changes.
    """
    if isinstance(source, RandomAccess):
        return wanted, source.frames_at(wanted)
    found: dict[int, NDArray[np.uint8 | np.uint16]] = {}
    first = 0
    for batch in source.batches(BATCH):
        found |= {k: batch[k - first] for k in wanted.tolist() if first <= k < first + len(batch)}
        first += len(batch)
        if first > wanted[-1]:
            break
    if not found:
        return wanted[:0], np.zeros((0, 1, 1), np.uint8)
    shape = next(iter(found.values())).shape
    same = {k: image for k, image in found.items() if image.shape == shape}
    return np.array(list(same), np.int64), np.stack(list(same.values()))


def prefetched(source: FrameSource) -> Iterator[NDArray[np.uint8 | np.uint16]]:
    """The batches of a source, of which the next is decoded by another thread while one is in use."""
    batches = iter(source.batches(BATCH))
    with ThreadPoolExecutor(1) as pool:
        coming = pool.submit(next, batches, None)
        while (images := coming.result()) is not None:
            coming = pool.submit(next, batches, None)
            yield images
