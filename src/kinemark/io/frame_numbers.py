"""The numbers of the frames of a table of trajectories."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..data.array_types import Floats
from .number_text import bad_line, whole


def first_frame(path: Path | str, lines: Sequence[int], numbers: Floats) -> tuple[int, tuple[str, ...]]:
    """The number of the first frame, and what is odd about the numbers (F), which stand in these lines.

    Raises:
        KinemarkError: frames are missing between others, or a number is none.
    """
    if not len(numbers) or np.isnan(numbers).all():
        return 1, ()
    frame = whole(path, lines, numbers, "the frame")
    steps = np.diff(frame)
    if steps.size and (steps == steps[0]).all() and steps[0] > 1:
        return int(frame[0]), (f"only every {steps[0]}th frame is numbered; they are read as one after the other",)
    if (jump := np.flatnonzero(steps != 1)).size:
        line = lines[int(jump[0]) + 1]
        raise bad_line(path, line, "the frame does not follow the one before. Export every frame.")
    return int(frame[0]), ()
