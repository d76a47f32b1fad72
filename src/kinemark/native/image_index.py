"""The images of a recording in the order in which they are looked up, and those near a place.

A cell is a camera in a frame. The usable images are in one long list by cell and u, with

    key = cell + (u − low) / width                                       (1)

where low and width bound the u of all, so that the images of a cell near a place are consecutive, found by bisection,
and looking costs the same whether a camera sees ten markers or a thousand. Among them those count whose squared
distance from the place u, with the covariance S of the difference,

    d² = (image − u)ᵀ S⁻¹ (image − u)                                    (2)

is within the gate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from ..data.arrays import set_columns
from .array_checks import BOOL, FLOAT, INT, Arrays, check_indices, index
from .compiled_library import library

_INDEX = Arrays(uv=(FLOAT, "D", 2), order=(index("D"), "N"), key=(FLOAT, "N"), first=(INT, "K"))
_IMAGES = Arrays(uv=(FLOAT, "D", 2), cell=(INT, "D"), usable=(BOOL, "D"))
_NEAR = Arrays(cell=(INT, "n"), u=(FLOAT, "n"), reach=(FLOAT, "n"))
_CANDIDATES = Arrays(
    variance=(FLOAT, "D"),
    free=(BOOL, "D"),
    cell=(INT, "n"),
    uv=(FLOAT, 2, "n"),
    S=(FLOAT, 3, "n"),
    reach=(FLOAT, "n"),
)


@dataclass(frozen=True, slots=True, eq=False)
class ImageIndex:
    """The N usable ones of D images by cell and u; `index_images` makes it.

    Attributes:
        uv: (D, 2) px of all images.
        order: (N) rows of the usable ones, by cell and u.
        key: (N) of (1).
        first: (cells + 1) of these, the first of each cell.
        low, width: px, of (1).

    Raises:
        ValueError: an array has another shape or dtype, or the images are not in this order.
    """

    uv: Floats
    order: Ints
    key: Floats
    first: Ints
    low: float
    width: float

    def __post_init__(self) -> None:
        arrays = uv, order, key, first = _INDEX(self.uv, self.order, self.key, self.first)
        _INDEX.check_indices(arrays)
        rises = len(first) > 0 and first[0] == 0 and first[-1] == len(order) and bool((first[1:] >= first[:-1]).all())
        if not rises:
            raise ValueError(f"first must rise from 0 to the number of usable images, {len(order)}")
        u, cell = uv[order, 0], np.repeat(np.arange(len(first) - 1), np.diff(first))
        same = cell[1:] == cell[:-1]
        if not (0 < self.width < math.inf and math.isfinite(self.low)) or not np.array_equal(
            key, _keys(cell, u, self.low, self.width)
        ):
            raise ValueError("key is not that of the cells and places of the images")
        if (u[1:] < u[:-1])[same].any() or (key < cell).any() or (key >= cell + 1).any():
            raise ValueError("order is not by cell and u")
        for array in (
            columns := {"uv": uv.view(), "order": order.view(), "key": key.view(), "first": first.view()}
        ).values():
            array.flags.writeable = False
        set_columns(self, **columns)

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return len(self.first) - 1

    def keep(self, mask: Bools) -> ImageIndex:
        """The same with only those images that `mask` (D) names."""
        kept = mask[self.order]
        first = np.concatenate([[0], np.cumsum(kept)])[self.first]
        return ImageIndex(self.uv, self.order[kept], self.key[kept], first, self.low, self.width)

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
        least, most = (u - reach - self.low) / self.width, (u + reach - self.low) / self.width
        first = np.searchsorted(self.key, cell + np.maximum(least, 0.0))
        count = np.searchsorted(self.key, cell + np.minimum(most, 1.0)) - first
        np.maximum(count, 0, out=count)
        return np.repeat(np.arange(len(cell)), count), self.order[ranges(first, count)]


def index_images(uv: Floats, cell: Ints, usable: Bools, *, n_cells: int) -> ImageIndex:
    """The index of the usable ones of images at uv (D, 2) px, in cells (D).

    Raises:
        ValueError: an array has another shape or dtype, there is no such cell, or a usable image has no place.
    """
    uv, cell, usable = _IMAGES(uv, cell, usable)
    rows = np.flatnonzero(usable)
    u, cell = uv[rows, 0], cell[rows]
    check_indices("cell", cell, n_cells)
    low = float(u.min(initial=0.0)) - 1
    width = (float(u.max(initial=0.0)) + 1 - low) * (1 + 1e-6)  # so that (1) stays below cell + 1
    if not math.isfinite(width):
        raise ValueError("uv is not finite for a usable image")
    key = _keys(cell, u, low, width)
    order = np.lexsort((u, cell))
    first = np.searchsorted(cell[order], np.arange(n_cells + 1))
    rows, key = rows[order], key[order]
    del u, cell, order  # of long recordings each is much memory
    return ImageIndex(uv, rows, key, first, low, width)


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
        Of each pair the place, the image's index, d² of (2) and the determinant |S| with the image's variance.

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
    known = len(images.order), len(variance), images.n_cells, images.order, images.key, images.first
    asked = images.low, images.width, images.uv, variance, free, len(cell), cell, uv, S, reach, gate
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
    det = a * d - b * b
    squared = (d * x * x - 2 * b * x * y + a * y * y) / det  # (2)
    within = np.flatnonzero(squared < gate)
    return own[within], detection[within], squared[within], det[within]


def ranges(first: Ints, count: Ints) -> Ints:
    """first, first + 1, … of each, `count` of them, one after the other."""
    return np.arange(int(count.sum())) + np.repeat(first - np.cumsum(count) + count, count)


def _keys(cell: Ints, u: Floats, low: float, width: float) -> Floats:
    """(1)."""
    return cell + (u - low) / width
