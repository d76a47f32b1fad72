"""The image in which a flash lights the whole view, by which recordings that were started apart are put together.

UM²AS's first version synchronised its tapes so (Giles 1994, 1). An image is divided into `BLOCKS` × `BLOCKS` parts, of
which b(i, f) is the mean grey level in frame f. Of a flash of L frames that begins in frame f

    r(i, f, L) = min b(i, f … f + L − 1) − max(b(i, f − 1), b(i, f + L))                                    (1)
    R(f) = max over L ≤ `LONGEST` of the lower quartile of r over the parts                                 (2)

is large: three quarters of the image are brighter than just before *and* just after. Markers, people and lamps that
move light a few parts; a lamp that is switched on stays, and is not brighter than after. It is a flash where

    R(f) ≥ max(`LEAST`, `SIGMAS` σ),    σ = 1.4826 median |D|,    D(f) = median over i of b(i, f) − b(i, f − 1)   (3)

with σ what the light of the room changes from frame to frame. A flash that two images share counts in the brighter one.
Where two flashes have more than half of the greatest R, or there is none, the recording does not tell when it was.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats, GreyLevels, Ints
from ..data.progress import tell
from ..numerics.robust import SD_PER_MEDIAN
from .centroids_method import grey_scale
from .frame_source import BATCH, FrameSource

BLOCKS = 8
"""Parts along each side; chosen: a person near a camera covers fewer than a quarter of 64."""
LONGEST = 5
"""Frames that a flash lights at most; chosen: a tenth of a second at 50 Hz."""
LEAST = 1.0
"""Grey levels of 8 bits that a flash adds at least; chosen: a tenth of what a usual dark background has."""
SIGMAS = 10.0
"""Of (3); chosen: lamps that flicker with the mains, and automatic gain, stay below."""


class Flash(NamedTuple):
    """A flash of a recording: the frame (from 0) in which it begins, its frames, and R of (2) at most, grey levels."""

    frame: int
    n_frames: int
    rise: float


def block_levels(source: FrameSource) -> Floats:
    """(F, B²) b of a recording, grey levels of 8 bits.

    Raises:
        KinemarkError: an image is damaged.
    """
    found: list[Floats] = []
    for images in source.batches(BATCH):
        tell(sum(map(len, found)), source.n_frames)
        found.append(_levels(images))
    return np.concatenate(found) if found else np.zeros((0, BLOCKS * BLOCKS))


def _levels(images: GreyLevels) -> Floats:
    """(n, B²) of images (n, H, W); smaller ones have a part a pixel."""
    rows, columns = (np.linspace(0, n, min(BLOCKS, n) + 1).astype(np.int64) for n in images.shape[1:])
    sums = np.add.reduceat(np.add.reduceat(images, rows[:-1], axis=1, dtype=np.int64), columns[:-1], axis=2)
    area = np.outer(np.diff(rows), np.diff(columns))
    return np.asarray((sums / area).reshape(len(images), -1) / grey_scale(images.dtype))


def rises_of(levels: Floats) -> Floats:
    """(`LONGEST`, F) the lower quartile of (1) by L − 1 and f, of block levels (F, P); −inf at the ends."""
    n = len(levels)
    rise = np.full((LONGEST, n), -np.inf)
    for L in range(1, min(LONGEST, n - 2) + 1):
        lit = np.lib.stride_tricks.sliding_window_view(levels[1:-1], L, axis=0).min(-1)
        rise[L - 1, 1 : n - L] = np.quantile(lit - np.maximum(levels[: n - L - 1], levels[L + 1 :]), 0.25, axis=1)
    return rise


def find_flash(source: FrameSource) -> Flash:
    """The one flash of a recording.

    Raises:
        KinemarkError: there is none, or there are several; it says which frames (from 1) were lit.
    """
    levels = block_levels(source)
    rises = rises_of(levels)
    if not np.isfinite(rises).any():
        raise KinemarkError(f"no flash lights the whole image; {len(levels)} frames are too few")
    change = np.median(np.diff(levels, axis=0), axis=1)
    lit = _flashes(rises, max(LEAST, SIGMAS * SD_PER_MEDIAN * float(np.median(np.abs(change)))))  # (3)
    if not lit:
        raise KinemarkError(f"no flash lights the whole image; the greatest rise is {rises.max():.2g} grey levels")
    equal = [one for one in lit if one.rise >= lit[0].rise / 2]
    if len(equal) > 1:
        frames = ", ".join(str(frame + 1) for frame in sorted(one.frame for one in equal)[:5])
        raise KinemarkError(f"{len(equal)} flashes light the whole image, in frames {frames}")
    return lit[0]


def _flashes(rises: Floats, limit: float) -> list[Flash]:
    """The brightest first; what is within `LONGEST` frames of a brighter one is part of it."""
    rise, length, found = rises.max(0), rises.argmax(0) + 1, list[Flash]()
    for f in np.argsort(-rise, kind="stable")[: int((rise >= limit).sum())].tolist():
        if all(abs(f - one.frame) > LONGEST for one in found):
            found.append(Flash(f, int(length[f]), float(rise[f])))
    return found


def flash_offsets(flashes: Sequence[Flash]) -> Ints:
    """(C) how many images later each camera was started than the first, as `match.StartOffsets` has it.

    A camera that was started k images later sees the flash k images earlier.
    """
    frames = np.array([one.frame for one in flashes], np.int64)
    return np.asarray(frames[:1] - frames) if len(frames) else frames
