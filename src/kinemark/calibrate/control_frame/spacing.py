"""Which rod a row of points in an image is, and from which end: by its spacings.

A point of a rod at s mm along it is seen along the image of the rod at

    q = (a s + b) / (c s + 1)                                            (1)

a projective map of the line with three parameters, linear in them once multiplied out:

    s a + b − q s c = q                                                  (2)

So k markers leave k − 3 residuals, which vanish for the right rod taken in the right direction and for no
other with different spacings (four points have one cross-ratio each way). The residual of (1) in pixels,

    e² = Σ (q − (a s + b) / (c s + 1))² / (k − 3)                        (3)

is judged for every choice of k points of the row, k markers of every rod, and direction; the rod must lie
before the camera, c s + 1 > 0, and its far end at most `DEPTH` times as far as its near one (4).

For given markers only q changes from choice to choice. With s of zero mean and N an orthonormal basis of what is at
right angles to (s, 1) in k dimensions, (2) leaves one unknown,

    |Nᵀ q + c Nᵀ (s q)|² → min,    c = −w·y / w·w,    y = Nᵀ q,  w = Nᵀ (s q)     (5)

and the residuals of (2) are N (y + c w), those of (1) the same over c s + 1 up to the scale of q, which its mean and
spread fix (6). So a pattern of markers is held against all choices of points at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints

DEPTH = 4.0  # times as far the far end of a rod may be as its near one; chosen
NO_FIT = 1e9  # px; stands for an error beyond all limits; a sentinel, by definition


class Reading(NamedTuple):
    """A row read as a rod: index of the point for each marker of the rod, −1 where missing (K), and (3), px."""

    rod: int
    points: tuple[int, ...]
    error: float

    @property
    def seen(self) -> int:
        """How many markers have a point."""
        return sum(p >= 0 for p in self.points)


def readings(rows: Sequence[Ints], uv: Floats, along: Floats, *, tolerance: float) -> list[Reading]:
    """Readings of rows of points, each in order along it, as rods (R, K) mm, NaN where a rod has no more markers.

    Of rows (m) into `uv` (n, 2) px: those whose error is at most `tolerance` px, with one marker missing at most and
    five seen (four of a rod that has no more); the best of each row, rod and number of markers.
    """
    found = []
    whole = np.isfinite(along).sum(1)
    for k in range(int(whole.max()), 3, -1):
        rods = [r for r in range(len(along)) if fewest_markers(int(whole[r])) <= k <= whole[r]]
        row_of, chosen = choices(rows, k)
        if not rods or len(chosen) == 0:
            continue
        distinct, which = _distinct(chosen)
        q = _places(uv[distinct])
        for rod in rods:
            error, pattern, marks = _best_patterns(along[rod, : whole[rod]], q, k, tolerance)
            error, pattern = error[which], pattern[which]
            for z in _best_of_each(row_of, error, tolerance):
                points = np.full(along.shape[1], -1)
                points[marks[pattern[z]]] = chosen[z]
                found.append(Reading(rod, tuple(int(p) for p in points), float(error[z])))
    return found


def fewest_markers(whole: int) -> int:
    """How many markers must be seen of a rod that has `whole`."""
    return max(min(5, whole), whole - 1)


def choices(rows: Sequence[Ints], k: int) -> tuple[Ints, Ints]:
    """All choices of k points in order from each row: the row of each (Z), and the points (Z, k)."""
    row_of, chosen = [np.zeros(0, np.int64)], [np.zeros((0, k), np.int64)]
    for m in sorted({len(row) for row in rows if len(row) >= k}):
        which = np.array([i for i, row in enumerate(rows) if len(row) == m], np.int64)
        places = np.array(list(combinations(range(m), k)), np.int64)
        chosen.append(np.array([rows[i] for i in which])[:, places].reshape(-1, k))
        row_of.append(np.repeat(which, len(places)))
    return np.concatenate(row_of), np.concatenate(chosen)


def _distinct(chosen: Ints) -> tuple[Ints, Ints]:
    """The choices (U, k) that differ, and which of them each one is (Z): rows share most of their points."""
    narrow = np.ascontiguousarray(chosen, np.uint16)  # one key of bytes a choice sorts faster than its columns
    _, first, which = np.unique(narrow.view(f"V{2 * chosen.shape[1]}").ravel(), return_index=True, return_inverse=True)
    return chosen[first], which


def _places(points: Floats) -> Floats:
    """(U, k) place of points (U, k, 2) along the line from the first to the last, px."""
    axis = points[:, -1] - points[:, 0]
    axis = axis / (np.linalg.norm(axis, axis=1, keepdims=True) + 1e-12)
    return np.einsum("uki,ui->uk", points - points[:, :1], axis)


def _best_patterns(s: Floats, q: Floats, k: int, limit: float) -> tuple[Floats, Ints, Ints]:
    """For choices at q (U, k) px: the error, and which row of `marks`, k markers at s mm, fits best, either way."""
    forward = np.array(list(combinations(range(len(s)), k)), np.int64)
    marks = np.concatenate([forward, forward[:, ::-1]])
    best, pattern = np.full(len(q), NO_FIT), np.zeros(len(q), np.int64)
    z, scale = _normalised(q)
    for m, chosen in enumerate(marks):
        error = _errors(s[chosen], z, scale, limit)
        better = error < best
        best[better], pattern[better] = error[better], m
    return best, pattern, marks


def _best_of_each(row_of: Ints, error: Floats, tolerance: float) -> Ints:
    """The choice with the least error of each row that has one within the tolerance."""
    near = np.flatnonzero(error <= tolerance)
    near = near[np.lexsort((error[near], row_of[near]))]
    return near[np.unique(row_of[near], return_index=True)[1]]


def spacing_errors(s: Floats, q: Floats, *, limit: float = float("inf")) -> Floats:
    """(3) of points at q (U, k) px as markers at s (k) mm, or `NO_FIT` where it exceeds `limit` or (4) is violated."""
    return _errors(s, *_normalised(q), limit)


def _normalised(q: Floats) -> tuple[Floats, Floats]:
    """q (U, k) with zero mean and unit spread, and the spread (U), px."""
    centred = q - q.mean(-1, keepdims=True)
    scale = np.sqrt((centred**2).mean(-1)) + 1e-12
    return centred / scale[:, None], scale


def _errors(s: Floats, z: Floats, scale: Floats, limit: float) -> Floats:
    k = len(s)
    s = (s - s.mean()) / s.std()
    N = np.linalg.svd(np.column_stack([s, np.ones(k)]))[0][:, 2:]
    y, w = z @ N, z @ (s[:, None] * N)  # (5)
    ww = np.einsum("ui,ui->u", w, w) + 1e-12
    c = -np.einsum("ui,ui->u", y, w) / ww
    ends = 1 + np.outer([s.min(), s.max()], c)
    near, far = ends.min(0), ends.max(0)
    left = np.maximum(np.einsum("ui,ui->u", y, y) - c**2 * ww, 0.0)  # Σ of (2)², at most far² times that of (1)
    hopeful = (near > 0) & (far < DEPTH * near) & (scale**2 * left <= (limit * far) ** 2 * max(k - 3, 1))  # (4)
    rows = np.flatnonzero(hopeful)
    residual = ((y[rows] + c[rows, None] * w[rows]) @ N.T) / (1 + np.outer(c[rows], s))  # (6)
    error = np.full(len(z), NO_FIT)
    error[rows] = scale[rows] * np.sqrt((residual**2).sum(-1) / max(k - 3, 1))
    return np.where(error <= limit, error, NO_FIT)
