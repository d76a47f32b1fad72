"""Memory for batches of frames that is used again when nobody holds the batch any more.

Fresh memory costs about as much time as reading a batch into it, as the system clears all of it first; with several
cameras at a time more so. Memory that is free is given back to the system when no batch of its size is in use.
"""

from __future__ import annotations

import math
import weakref
from typing import Any

import numpy as np

from .pixels import Image


class BatchMemory:
    """Gives memory of one size, in bytes; whoever keeps a batch, or a part of it, keeps it unchanged."""

    def __init__(self, size: int) -> None:
        """Nothing is taken yet."""
        self._size = size
        self._free: list[Any] = []

    def batch(self, shape: tuple[int, ...], dtype: np.dtype[Any]) -> Image:
        """An array of this shape, which fits, and of any content."""
        memory: Any = self._free.pop() if self._free else np.empty(self._size, np.uint8)
        # of a memoryview: the base of all views is then this array, and it lives as long as any of them
        lent = np.frombuffer(memoryview(memory), dtype, math.prod(shape))
        weakref.finalize(lent, self._take_back, memory).atexit = False
        return lent.reshape(shape)

    def _take_back(self, memory: Any) -> None:
        self._free.append(memory)


_IN_USE: weakref.WeakValueDictionary[int, BatchMemory] = weakref.WeakValueDictionary()


def batch_memory(size: int) -> BatchMemory:
    """The memory for batches of so many bytes, that of all cameras of this size."""
    return _IN_USE.setdefault(size, BatchMemory(size))
