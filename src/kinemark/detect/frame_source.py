"""What detection asks of a recording."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

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


def prefetched(source: FrameSource) -> Iterator[NDArray[np.uint8 | np.uint16]]:
    """The batches of a source, of which the next is decoded by another thread while one is in use."""
    batches = iter(source.batches(BATCH))
    with ThreadPoolExecutor(1) as pool:
        coming = pool.submit(next, batches, None)
        while (images := coming.result()) is not None:
            coming = pool.submit(next, batches, None)
            yield images
