"""Images that one camera lacks where the numbers of files tell it.

A glob takes images in order. Where a camera lost an image that others have, each later one would stand one frame too
early: their numbers say so, also where as many are missing in every camera.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Bools, Ints
from ..io.images import ImageSource

LAST_NUMBER = re.compile(r"(|.*[^0-9])([0-9]{1,15})([^0-9]*)", re.DOTALL)

COUNTED = 0.8
"""Of the steps between numbers, the share that is one and the same where they count images; chosen: numbers that are
times in ms or µs step unevenly, and cameras that lose a fifth of their images are of no use."""

FEWEST = 10  # files whose names may count; chosen: so few are looked through by whoever made them
EVEN = 3  # spacings of longer steps from which they may be those of a clock; chosen
NAMED = 5  # numbers that a message lists; chosen


class Count(NamedTuple):
    """How the files of a camera are numbered: the first number, the usual step, and the place (n) of each in the count,
    from 0."""

    first: int
    step: int
    places: Ints


def check_no_image_lost(images: Mapping[str, ImageSource]) -> None:
    """That synchronous cameras lack no images of which the others have the number.

    Numbers may begin anywhere, and have gaps that all cameras share. Names that do not count tell nothing.

    Args:
        images: of each camera that has the rate of the frames.

    Raises:
        KinemarkError: a camera lacks some, with their numbers.
    """
    counts = {name: count for name, source in images.items() if (count := count_of(source.paths))}
    anywhere = set().union(*(count.places.tolist() for count in counts.values()))
    for name, count in counts.items():
        own = set(count.places.tolist())
        if lost := sorted(k for k in anywhere - own if k < count.places[-1]):
            numbers = ", ".join(str(count.first + k * count.step) for k in lost[:NAMED])
            raise KinemarkError(
                f"Camera {name!r} has no image {numbers}{', …' if len(lost) > NAMED else ''} in "
                f"{images[name].paths[0].parent}, and others have: its later images would stand in wrong frames. "
                "Restore it, or put a black image of that number in its place."
            )


def count_of(paths: Sequence[Path]) -> Count | None:
    """How rising numbers in the names of files count images; None where they do not."""
    found = [match for path in paths if (match := LAST_NUMBER.fullmatch(path.stem))]
    if len(found) < max(len(paths), FEWEST) or len({(m[1], m[3]) for m in found}) > 1:
        return None
    numbers = np.array([int(m[2]) for m in found])
    steps = np.diff(numbers)
    usual = int(np.median(steps))
    if usual < 1 or (steps < 1).any() or (steps % usual).any() or (steps == usual).mean() < COUNTED:
        return None
    if _of_clock(steps != usual):
        return None
    return Count(int(numbers[0]), usual, (numbers - numbers[0]) // usual)


def _of_clock(longer: Bools) -> bool:
    """Whether longer steps come as evenly as those of a clock that is cut to whole numbers, as of ms at 900 Hz."""
    apart = np.diff(np.flatnonzero(longer))
    return bool(len(apart) >= EVEN and np.ptp(apart) <= 1)
