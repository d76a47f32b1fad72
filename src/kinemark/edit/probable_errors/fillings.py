"""Fillings: samples of a file that nobody measured. A path stands still or goes on in a straight line, as programs
bridge gaps, and the file does not say so.

What is measured has noise, and accelerates. With the second differences of a path,

    e_k = |x_{k+1} − 2 x_k + x_{k−1}|,                                                                   (1)

a run of samples is looked at where e is below SMALL of its median over the paths that are nearest, or than rounding
makes it (2): a foot that stands is still with all its markers, and a subject who stands as a whole. Samples that lie
between others on a line of (2) may be filled; where they repeat the sample before, the last one too, and where the path
begins so, the first one. What tells is by how much e is less than it is of the path itself outside such runs, and at
the ends of this one: what comes to rest does so by and by, a filling begins and ends with a kink.

Tracks that have images are not looked at: each of their samples was measured.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats
from ...data.progress import tell
from ...numerics.row_quantiles import row_medians
from ...numerics.runs import true_runs
from .carried import BESIDE, left_mm
from .paths import Paths
from .probability import probability

SMALL, FEWEST = 0.05, 3
"""Share of what is usual beside it below which a second difference is small, and how many follow each other at least;
chosen: noise reaches that once in ten thousand samples."""
ROUNDED_MM = 3e-4
"""mm that rounding to single precision makes of a second difference some metres from the origin; by definition."""
BIN_MM, OFTEN = 1e-3, 0.01
"""Bins of components of second differences, mm, and the share of them that one bin has where the numbers of a file are
multiples of a step, the least such bin being that; chosen: of other numbers it has that where all are as small."""
MOVES = 4.0
"""Times what rounding makes of a second difference that it is beside a filling at least; chosen: where a whole body
rests within the step of its file, what does not move tells nothing."""
KINK = -2.0
"""`FillingEvidence.own` and `edge` that a filling has at most; chosen: an eighth, which a marker at rest seldom comes
to from one frame to the next."""
MOST_STEP_MM = 2.0
"""mm that the step of a file is at most; chosen: of whole millimetres."""
STILL = 0.1
"""Share of the path's usual second difference below which a step is none; chosen."""


class FillingEvidence(NamedTuple):
    """What tells of a filling.

    Attributes:
        own: ln of (1) in it over that of the path elsewhere, medians. beside: the same over that of what is near
            meanwhile. edge: the same over the greatest of the samples next to its ends.
        frames: ln of their number.
    """

    own: float
    beside: float
    edge: float
    frames: float


class Filling(NamedTuple):
    """Samples `first` to `last` (frames from 0) of a path that nobody measured: they stand `still` or lie on a straight
    line; how likely that is, and how far off they are, mm."""

    path: int
    first: int
    last: int
    still: bool
    evidence: FillingEvidence
    wrong: float
    mm: float


def fillings(paths: Paths) -> list[Filling]:
    """Those of all paths, by path and frame."""
    if paths.xyz.shape[1] < FEWEST + 2:
        return []
    second = np.full(paths.seen.shape, np.nan)
    second[:, 1:-1] = np.linalg.norm(np.diff(paths.xyz, 2, axis=1), axis=2)  # (1)
    near, rounded = _nearest(paths), _rounded_mm(paths)
    found: list[Filling] = []
    for p in range(len(second)):
        tell(p, len(second))
        if len(near[p]) and not paths.images[p].any():
            found += _of_path(paths, p, second[p], _median(second[near[p]]), rounded)
    return found


def _rounded_mm(paths: Paths) -> float:
    """What rounding makes of a second difference, mm: of a file whose numbers are multiples of a step, twice that."""
    some = np.abs(np.diff(paths.xyz, 2, axis=1)).ravel()
    bins = np.round(some[some < MOST_STEP_MM] / BIN_MM).astype(np.int64)
    often = np.flatnonzero(np.bincount(bins) > OFTEN * len(bins))
    return max([ROUNDED_MM, *(2 * BIN_MM * often[often > 0][:1]).tolist()])


def _nearest(paths: Paths) -> list[list[int]]:
    """Of each path those that are nearest to it, by the medians of their places."""
    middle = np.array(
        [np.median(paths.xyz[p, own], axis=0) if len(own) else [np.nan] * 3 for p, own in enumerate(paths.frames)]
    )
    known = np.flatnonzero(np.isfinite(middle.reshape(-1, 3)).all(1))
    out: list[list[int]] = []
    for p in range(len(middle)):
        order = known[np.argsort(np.linalg.norm(middle[known] - middle[p], axis=1), kind="stable")]
        out.append(order[order != p][:BESIDE].tolist() if len(known) > BESIDE and len(paths.frames[p]) else [])
    return out


def _median(rows: Floats) -> Floats:
    """(F) over what is known; NaN where nothing is."""
    out = np.full(rows.shape[1], np.nan)
    some = np.isfinite(rows).any(0)
    out[some] = row_medians(rows[:, some].T)
    return out


def _of_path(paths: Paths, p: int, second: Floats, beside: Floats, rounded: float) -> Iterator[Filling]:
    """Those of one path with these second differences (F), and those beside it (F)."""
    with np.errstate(invalid="ignore"):
        small: Bools = (second < SMALL * beside + rounded) & (beside > MOVES * rounded)  # (2)
    runs = [(a, b) for a, b in true_runs(small).tolist() if b - a >= FEWEST]
    elsewhere = np.isfinite(second)
    for a, b in runs:
        elsewhere[a - 1 : b + 1] = False
    for a, b in runs:
        usual = second[elsewhere] if elsewhere.any() else beside[a:b]
        own, inside, ends = (float(np.median(some)) for some in (usual, second[a:b], beside[a:b]))
        edge = float(np.nanmax([0.0, *second[max(a - 2, 0) : a], *second[b : b + 2]]))
        step = float(np.linalg.norm(paths.xyz[p, b] - paths.xyz[p, a - 1])) / (b - a + 1)
        still = step <= STILL * own + rounded
        first, last = a, b - 1
        if still:
            first, last = (a - 1, b - 1) if a - 1 == paths.frames[p][0] else (a, b)
        tells = np.log(inside + rounded) - np.log(np.array([own, ends, edge]) + rounded)
        if max(tells[0], tells[2]) < KINK:
            yield _filling(paths, (p, first, last, still), tells)


def _filling(paths: Paths, where: tuple[int, int, int, bool], tells: Floats) -> Filling:
    """Of these samples, with the first three of `FillingEvidence`."""
    p, first, last, still = where
    off = _off_mm(paths, p, first, last)
    own, beside, edge = tells.tolist()
    evidence = FillingEvidence(own, beside, edge, float(np.log(last - first + 1)))
    return Filling(p, first, last, still, evidence, probability("filling", evidence), off)


def _off_mm(paths: Paths, p: int, first: int, last: int) -> float:
    """How far the middle of these samples, or the end of what goes on to the path's end, is from where what is near
    carries it from the samples before and after, mm."""
    around = [f for f in (first - 1, last + 1) if 0 <= f < paths.seen.shape[1] and paths.seen[p, f]]
    if not around:
        return 0.0
    to = (first + last) // 2 if len(around) == 2 else last if around[0] < first else first
    off = left_mm(paths, p, to, *around)
    return 0.0 if np.isnan(off) else off
