"""Images that a camera lost, or took twice, within a wand's film: from there on it shows other moments than the rest.

By cameras that are nearly right, as those of a part of the film are, the ends of the wand that camera c shows if it has
skipped n images ahead are off the epipolar lines of another camera b, by Sampson's distances d. In frame f

    e_f(n) = min(median over b of Σ d² / s², `STRONGEST`),   0 where no other camera sees it         (1)

with s from the median over all frames of the least d. The n of the frames are those that make

    Σ_f e_f(n_f) + `CHANGE` · (how often n_f changes)                                                (2)

least, which is found frame by frame (Viterbi 1967). The camera for which (2) falls most by its changes is put in time
first, then the others are asked again. A change is believed where both stretches beside it fit `CLEAR` times worse by
each other's n (3). At the end n counts from the (lower) median of the cameras: most lose nothing at that moment.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...data import Detections, Rig
from ...data.array_types import Bools, Floats, Ints
from ...data.detections import NOT_ROWS
from ...geometry import undistort
from ...geometry.epipolar import fundamental
from ...geometry.two_view import sampson_distance
from ...numerics.later_frames import in_later_frames

LEAST_SPREAD = 0.3
"""px; noise below which epipolar distances are not believed; chosen, as for a wand's ends."""
MOST = 8
"""Images lost, or taken twice, in all, to both sides; chosen: more hardly get lost."""
STRONGEST = 9.0
"""Bound of (1); chosen: three standard deviations."""
CHANGE = 80.0
"""Of (2); chosen: nine frames that do not fit at all, as no markers are mistaken so often one after the other."""
CLEAR = 4.0
"""Of the mean squares of (3); chosen, as for delays."""
BETTER = 0.8
"""Share of the frames in (3); chosen: strays and mistaken rows are fewer than the rest."""
ABOUT = 2
"""Frames to both sides of a change whose images of the camera are left out, or as many as it lost, as nothing shows
these; chosen: else it is told to one or two."""


class LostImages(NamedTuple):
    """A camera lost images, or took some twice.

    Attributes:
        camera: its name.
        alone: whether it is known which camera it was; of two cameras it is not.
        first, last: its images, from 0, one of which is the first after those that were lost or taken twice.
        images: how many it lost; below 0 how many it took twice.
    """

    camera: str
    alone: bool
    first: int
    last: int
    images: int


def images_ahead(rig: Rig, uv: Floats, late: Floats) -> Ints | None:
    """By how many images (C, F) cameras are ahead of their film at the frames; None where that never changes.

    Args:
        rig: C cameras, nearly right.
        uv: (C, F, K, 2) px; markers in the order of the wand or the opposite one, NaN where not seen.
        late: (C) images by which cameras are late all the time.
    """
    ends = np.stack([undistort(camera, each[:, [0, -1]]) for camera, each in zip(rig, uv, strict=True)])
    C, F = uv.shape[:2]
    ahead = np.repeat(np.rint(late).astype(np.int64)[:, None], F, axis=1)
    for _ in range(C):
        squares = np.stack([_squares(rig, ends, ahead, c) for c in range(C)])
        s2 = max(float(np.nanmedian(np.fmin.reduce(squares, axis=1))), LEAST_SPREAD**2)
        paths, gain = _paths(np.nan_to_num(np.minimum(squares / s2, STRONGEST)))
        c = int(gain.argmax())
        believed = _believed(paths[c], squares[c]) - MOST
        if not believed.any():
            break
        ahead[c] += believed
    ahead -= np.sort(ahead, axis=0)[(C - 1) // 2]
    return ahead if np.diff(ahead).any() else None


def changes(names: Sequence[str], ahead: Ints, seen: Bools) -> Iterator[LostImages]:
    """Where and by how much cameras (C, F) lose images, as far as the images (C, F) tell that show markers."""
    F = ahead.shape[1]
    source = np.arange(F) - ahead
    placed = np.take_along_axis(seen, np.clip(source, 0, F - 1), 1) & (source >= 0) & (source < F)
    told = placed & (placed.sum(0) >= 2)
    for c, f in zip(*(axis.tolist() for axis in np.nonzero(np.diff(ahead))), strict=True):
        before, after = np.flatnonzero(told[c, : f + 1]), f + 1 + np.flatnonzero(told[c, f + 1 :])
        first = int(source[c, before[-1]]) + 1 if len(before) else 0
        last = int(source[c, after[0]]) if len(after) else F - 1
        yield LostImages(names[c], len(names) > 2, min(first, last), last, int(ahead[c, f + 1] - ahead[c, f]))


def in_place(detections: Detections, ahead: Ints) -> Detections:
    """The detections in the frames that they show, without those about a change, by `ahead` (C, F)."""
    C, F = ahead.shape
    source = np.arange(F) - ahead
    for c, f in zip(*(axis.tolist() for axis in np.nonzero(np.diff(ahead))), strict=True):
        about = max(ABOUT, int(abs(ahead[c, f + 1] - ahead[c, f])))
        source[c, max(f + 1 - about, 0) : f + 1 + about] = -1
    there = (source >= 0) & (source < F)
    counts = np.where(there, np.take_along_axis(detections.counts, np.clip(source, 0, F - 1), 1), 0)
    own = (detections.rows(c, int(k)) for c in range(C) for k in source[c, there[c]])
    row = np.concatenate([np.zeros(0, np.int64), *(np.arange(one.start, one.stop) for one in own)])
    columns = {f.name: getattr(detections, f.name)[row] for f in fields(detections) if f.name not in NOT_ROWS}
    return Detections.build(detections.cameras, detections.rate, counts, **columns)


def _squares(rig: Rig, ends: Floats, ahead: Ints, c: int) -> Floats:
    """Σ d² of (1), px² (2 MOST + 1, F), of camera c at n images more than `ahead` (C, F) says."""
    tried = np.stack([in_later_frames(ends[c], ahead[c] + n) for n in range(-MOST, MOST + 1)])
    found = []
    for b in range(len(rig)):
        if b != c:
            other, E = in_later_frames(ends[b], ahead[b]), fundamental(rig[c].P, rig[b].P)
            either = [(sampson_distance(E, tried, one) ** 2).sum(-1) for one in (other, other[:, ::-1])]
            found.append(np.minimum(*either))
    return _median(np.stack(found))


def _median(each: Floats) -> Floats:
    """Along the first axis, of an even number the lower, NaN where there are none."""
    ordered, n = np.sort(each, axis=0), np.isfinite(each).sum(0)
    return np.take_along_axis(ordered, np.maximum(n - 1, 0)[None] // 2, axis=0)[0]


def _paths(e: Floats) -> tuple[Ints, Floats]:
    """n (C, F), as rows of e (C, N, F), that make (2) least, and by how much it is less than with no n but 0."""
    C, N, F = e.shape
    total, came = e[..., 0].copy(), np.zeros((F, C, N), np.int64)
    rows = np.arange(C)
    for f in range(1, F):
        jump = total.argmin(1)
        limit = total[rows, jump][:, None] + CHANGE
        came[f] = np.where(total <= limit, np.arange(N), jump[:, None])
        total = np.minimum(total, limit) + e[..., f]
    path = np.zeros((C, F), np.int64)
    path[:, -1] = total.argmin(1)
    for f in range(F - 1, 0, -1):
        path[:, f - 1] = came[f, rows, path[:, f]]
    return path, e[:, MOST].sum(-1) - total.min(1)


def _believed(path: Ints, squares: Floats) -> Ints:
    """n (F) without the changes that (3) does not bear out: there the shorter stretch goes on as the other."""
    path = path.copy()
    while True:
        edges = [0, *(np.flatnonzero(np.diff(path)) + 1).tolist(), len(path)]
        for one, other in pairwise(slice(i, j) for i, j in pairwise(edges)):
            a, b = path[one.start], path[other.start]
            if not (_clear(squares[:, one], a, b) and _clear(squares[:, other], b, a)):
                shorter = one.stop - one.start < other.stop - other.start
                path[one if shorter else other] = b if shorter else a
                break
        else:
            return path


def _clear(squares: Floats, own: int, other: int) -> bool:
    """(3) of a stretch of squares (N, f) px²."""
    both = np.isfinite(squares[[own, other]]).all(0)
    if not both.any():
        return False
    fits, fits_not = (np.sort(squares[n, both])[: max(int(BETTER * both.sum()), 1)].mean() for n in (own, other))
    return bool(fits_not > CLEAR * max(float(fits), LEAST_SPREAD**2))
