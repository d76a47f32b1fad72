"""The images of a recording in the order in which they are looked up, and those near a place.

A cell is a camera in a frame. The usable images are in one long list by cell and u, so that the images of a cell near a
place are consecutive, found by bisection (1), and looking costs the same whether a camera sees ten markers or a
thousand. Among them those count whose squared distance from the place u, with the covariance S of the difference,

    d² = (image − u)ᵀ S⁻¹ (image − u)                                    (2)

is within the gate. A long recording has many images, so the list has four bytes for each.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Bools, Floats, Ints
from ..data.arrays import set_columns
from .array_checks import BOOL, FLOAT, INT, Arrays, Kind, check_indices
from .compiled_library import library

_ROW = Kind((np.dtype(np.int32),), below="D")
_INDEX = Arrays(uv=(FLOAT, "D", 2), order=(_ROW, "N"), first=(INT, "K"))
_CELL = Kind((np.dtype(np.int64), np.dtype(np.int32)))
_IMAGES = Arrays(uv=(FLOAT, "D", 2), cell=(_CELL, "D"), usable=(BOOL, "D"))
_NEAR = Arrays(cell=(INT, "n"), u=(FLOAT, "n"), reach=(FLOAT, "n"))
_CANDIDATES = Arrays(
    variance=(FLOAT, "D"),
    free=(BOOL, "D"),
    cell=(INT, "n"),
    uv=(FLOAT, 2, "n"),
    S=(FLOAT, 3, "n"),
    reach=(FLOAT, "n"),
)


AT_ONCE = 500_000
"""Images that are sorted or checked in one go: more would take memory and no less time; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class ImageIndex:
    """The N usable ones of D images by cell and u; `index_images` makes it.

    Attributes:
        uv: (D, 2) px of all images.
        order: (N) rows of the usable ones, by cell and u.
        first: (cells + 1) of these, the first of each cell.

    Raises:
        ValueError: an array has another shape or dtype, or the images are not in this order.
    """

    uv: Floats
    order: NDArray[np.int32]
    first: Ints

    def __post_init__(self) -> None:
        arrays = uv, order, first = _INDEX(self.uv, self.order, self.first)
        _INDEX.check_indices(arrays)
        rises = len(first) > 0 and first[0] == 0 and first[-1] == len(order) and bool((first[1:] >= first[:-1]).all())
        if not rises:
            raise ValueError(f"first must rise from 0 to the number of usable images, {len(order)}")
        begins = np.zeros(len(order) + 1, np.bool_)
        begins[first] = True
        for at in range(0, len(order), AT_ONCE):
            u = uv[order[at : at + AT_ONCE + 1], 0]
            if not np.isfinite(u).all() or ((u[1:] < u[:-1]) & ~begins[at + 1 : at + len(u)]).any():
                raise ValueError("order is not by cell and u")
        columns = {"uv": uv.view(), "order": order.view(), "first": first.view()}
        for array in columns.values():
            array.flags.writeable = False
        set_columns(self, **columns)

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return len(self.first) - 1

    def keep(self, mask: Bools) -> ImageIndex:
        """The same with only those images that `mask` (D) names."""
        kept = mask[self.order]
        before = np.append(np.zeros(1, np.int32), np.cumsum(kept, dtype=np.int32))
        return ImageIndex(self.uv, self.order[kept], before[self.first].astype(np.int64))

    def near(self, cell: Ints, u: Floats, reach: Floats) -> tuple[Ints, Ints]:
        """Images whose u is within reach (n) px of u (n), in cells (n): (places among n, rows).

        Raises:
            ValueError: an array has another shape or dtype, or there is no such cell.
        """
        cell, u, reach = _NEAR(cell, u, reach)
        check_indices("cell", cell, self.n_cells)
        return self._near(cell, u, reach)

    @np.errstate(all="ignore")
    def _near(self, cell: Ints, u: Floats, reach: Floats) -> tuple[Ints, Ints]:
        first = self._place(cell, u - reach)
        count = np.maximum(self._place(cell, u + reach) - first, 0)
        return np.repeat(np.arange(len(cell)), count), self.order[ranges(first, count)].astype(np.int64)

    def _place(self, cell: Ints, wanted: Floats) -> Ints:
        """(n) by (1): of each cell the first place at which u is not less than `wanted` (n) px."""
        low, stop = self.first[cell], self.first[cell + 1]
        for _ in range(int((stop - low).max(initial=0)).bit_length()):
            middle = (low + stop) // 2
            less = (low < stop) & (self.uv[self.order[np.minimum(middle, len(self.order) - 1)], 0] < wanted)
            low, stop = np.where(less, middle + 1, low), np.where(less, stop, middle)
        return low


def index_images(uv: Floats, cell: Ints, usable: Bools, *, n_cells: int) -> ImageIndex:
    """The index of the usable ones of images at uv (D, 2) px, in cells (D).

    Raises:
        ValueError: an array has another shape or dtype, there is no such cell, or a usable image has no place.
    """
    uv, cell, usable = _IMAGES(uv, cell, usable)
    if len(uv) > np.iinfo(np.int32).max:
        raise ValueError(f"there are {len(uv)} images, wanted {np.iinfo(np.int32).max} at most")
    count = np.zeros(n_cells, np.int64)
    for at in range(0, len(cell), AT_ONCE):
        part, own = usable[at : at + AT_ONCE], cell[at : at + AT_ONCE]
        check_indices("cell", own[part], n_cells)
        if not np.isfinite(uv[at : at + AT_ONCE, 0][part]).all():
            raise ValueError("uv is not finite for a usable image")
        count += np.bincount(own[part], minlength=n_cells)
    first = np.append(0, np.cumsum(count))
    order = np.empty(first[-1], np.int32)
    cuts = np.unique(np.append(np.searchsorted(first, np.arange(0, first[-1], AT_ONCE)), n_cells))
    for begin, end in pairwise(cuts.tolist()):
        rows = np.flatnonzero((cell >= begin) & (cell < end) & usable).astype(np.int32)
        order[first[begin] : first[end]] = rows[np.lexsort((uv[rows, 0], cell[rows]))]
    return ImageIndex(uv, order, first)


def candidates(
    images: ImageIndex, variance: Floats, free: Bools, cell: Ints, uv: Floats, S: Floats, reach: Floats, *, gate: float
) -> tuple[Ints, Ints, Floats, Floats]:
    """The free images within the gate of n places.

    Args:
        images: the index of D images.
        variance: (D) px² of each.
        free: (D) whether it may be taken.
        cell: (n) of each place.
        uv: (2, n) px.
        S: (3, n) px², the xx, xy and yy of each place's covariance.
        reach: (n) px in u, as far as is looked.
        gate: of d².

    Returns:
        Of each pair, place by place: the place, the image's index, d² of (2), and the determinant |S| with the image's
        variance.

    Raises:
        ValueError: an array has another shape or dtype, or there is no such cell.
    """
    variance, free, cell, uv, S, reach = _CANDIDATES(variance, free, cell, uv, S, reach)
    if len(variance) != len(images.uv):
        raise ValueError(f"variance has shape {variance.shape}, wanted ({len(images.uv)},)")
    if (compiled := library()) and (
        found := _compiled_candidates(compiled, images, variance, free, cell, uv, S, reach, gate)
    ):
        return found
    check_indices("cell", cell, images.n_cells)
    return _numpy_candidates(images, variance, free, cell, uv, S, reach, gate)


def _compiled_candidates(
    compiled: Any, images: ImageIndex, variance: Floats, free: Bools, cell: Ints, uv: Floats, S: Floats, reach: Floats,
    gate: float,
) -> tuple[Ints, Ints, Floats, Floats] | None:  # fmt: skip
    known = len(images.order), len(variance), images.n_cells, images.order, images.first
    asked = images.uv, variance, free, len(cell), cell, uv, S, reach, gate
    room = 4 * len(cell) + 64  # mostly enough
    while True:
        pair, said = np.empty((2, room), np.int64), np.empty((2, room))
        found = compiled.candidates(*known, *asked, room, *pair, *said)
        if found < 0:
            return None  # there is no such cell
        if found <= room:
            return pair[0, :found], pair[1, :found], said[0, :found], said[1, :found]
        room = found


@np.errstate(all="ignore")
def _numpy_candidates(
    images: ImageIndex, variance: Floats, free: Bools, cell: Ints, uv: Floats, S: Floats, reach: Floats, gate: float
) -> tuple[Ints, Ints, Floats, Floats]:
    own, detection = images.near(cell, uv[0], reach)
    own, detection = own[free[detection]], detection[free[detection]]
    x, y, noise = images.uv[detection, 0] - uv[0, own], images.uv[detection, 1] - uv[1, own], variance[detection]
    a, b, d = S[0, own] + noise, S[1, own], S[2, own] + noise
    det = np.maximum(a * d - b * b, noise * (a + d - noise))  # |S + r I| ≥ r (tr S + r), whatever rounding left
    squared = (d * x * x - 2 * b * x * y + a * y * y) / det  # (2)
    within = np.flatnonzero(squared < gate)
    return own[within], detection[within], squared[within], det[within]


def ranges(first: Ints, count: Ints) -> Ints:
    """first, first + 1, … of each (n), `count` (n) of them, one after the other: (Σ count)."""
    return np.arange(int(count.sum())) + np.repeat(first - np.cumsum(count) + count, count)
