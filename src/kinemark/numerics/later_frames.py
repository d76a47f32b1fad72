"""What a camera that is late shows, in the frames of the others."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Ints

T = TypeVar("T", bound=np.generic)


def in_later_frames(rows: NDArray[T], late: int | Ints, missing: float = np.nan) -> NDArray[T]:
    """(F, …) row f − late of `rows` (F, …) in frame f, `missing` where there is none; late, images, or (F) of each."""
    source: Ints = np.arange(len(rows)) - late
    out = np.full_like(rows, missing)
    there = (source >= 0) & (source < len(rows))
    out[there] = rows[source[there]]
    return out
