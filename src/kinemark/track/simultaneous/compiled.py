"""The compiled part of the tracker, kernel.c, where it was built.

What it works out stands in `motion`, `claims` and `groups`, which use NumPy where it is absent. The results are the
same to rounding; the arrays are laid out alike, the points along the last axis.
"""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...compiled import at, floats, ints, loaded, opened, plain, size
from ...data.array_types import Bools, Floats, Ints

if TYPE_CHECKING:
    from .detection_index import Images


VERSION = 1  # as in kernel.c


class _Images(ctypes.Structure):
    """`Images` of kernel.c."""

    _fields_ = (
        *((name, ctypes.c_int64) for name in ("n", "d", "cells")),
        *((name, ctypes.c_void_p) for name in ("key", "order", "first", "uv", "variance", "free")),
        *((name, ctypes.c_double) for name in ("low", "width")),
    )


class Library:
    """The functions of kernel.c on arrays."""

    def __init__(self, path: Path) -> None:
        """Load the library.

        Raises:
            OSError: it cannot be loaded, or was built from another version of the source.
        """
        self._kernel = opened(path, VERSION)
        for name in ("ahead", "told", "expect", "information", "placed"):
            getattr(self._kernel, name).restype = None
        self._kernel.candidates.restype = ctypes.c_int64

    def ahead(self, x: Floats, V: Floats, T: Floats, q: float) -> tuple[Floats, Floats]:
        """x (9, n) and V (9, 9, n) a time T (n) later."""
        x, V, T = floats(x, V, T)
        out = np.empty_like(x), np.empty_like(V)
        self._kernel.ahead(size(len(T)), ctypes.c_double(q), *map(at, (T, x, V, *out)))
        return out

    def told(self, x: Floats, V: Floats, N: Floats, g: Floats) -> tuple[Floats, Floats]:
        """x (9, n) and V (9, 9, n) after measurements N (3, 3, n), g (3, n)."""
        n = x.shape[-1]
        x, V, N, g = floats(x, V, N, g)
        out = np.empty_like(x), np.empty_like(V)
        self._kernel.told(size(n), *map(at, (x, V, N, g, *out)))
        return out

    def expect(self, P: Floats, xyz: Floats, cov: Floats) -> tuple[Floats, Floats, Floats]:
        """uv (C, 2, n), J (C, 2, 3, n) and S (C, 3, n) of points xyz (3, n), cov (3, 3, n), in cameras P (C, 3, 4)."""
        C, n = len(P), xyz.shape[-1]
        P, xyz, cov = floats(P, xyz, cov)
        out = np.empty((C, 2, n)), np.empty((C, 2, 3, n)), np.empty((C, 3, n))
        self._kernel.expect(size(C), size(n), *map(at, (P, xyz, cov, *out)))
        return out

    def candidates(
        self, images: Images, free: Bools, cell: Ints, uv: Floats, S: Floats, reach: Floats, gate: float
    ) -> tuple[Ints, Ints, Floats, Floats]:
        """Place, row, d² and |S| of the free images (D) with d² < `gate` of n places.

        Args:
            images: all; free: (D).
            cell: (n) frame C + camera; uv: (2, n) px; S: (3, n) px²; reach: (n) px in u.
            gate: of d².
        """
        (cell,), (uv, S, reach) = ints(cell), floats(uv, S, reach)
        (order, first), (key, seen, variance) = (
            ints(images.order, images.first),
            floats(images.key, images.uv, images.variance),
        )
        taken = np.ascontiguousarray(free, np.bool_)
        known = _Images(
            len(key), len(seen), len(first) - 1, *map(at, (key, order, first, seen, variance, taken)), *images.across
        )
        most, n = 4 * len(cell) + 64, len(cell)
        while True:
            pair, told = np.empty((2, most), np.int64), np.empty((2, most))
            places = map(at, (*pair, *told))
            asked = map(at, (cell, uv, S, reach))
            found = self._kernel.candidates(
                ctypes.byref(known), size(n), *asked, ctypes.c_double(gate), size(most), *places
            )
            if found <= most:
                return pair[0, :found], pair[1, :found], told[0, :found], told[1, :found]
            most = found

    def information(self, uv: Floats, J: Floats, row: Ints, variance: Floats, images: Floats) -> tuple[Floats, Floats]:
        """N (3, 3, n) and g (3, n) of the images row (C, n), −1 for none, of all (D, 2)."""
        C, n = row.shape
        (row,), (uv, J, variance, images) = ints(row), floats(uv, J, variance, images)
        out = np.zeros((3, 3, n)), np.zeros((3, n))
        self._kernel.information(size(C), size(n), size(len(images)), *map(at, (uv, J, row, variance, images, *out)))
        return out

    def placed(
        self, P: Floats, uv: Floats, variance: Floats, view: Ints, camera: Ints
    ) -> tuple[Floats, Floats, Floats]:
        """xyz (3, n), cov (3, 3, n) and d² (k, n), −1 unseen, of views (k, n) of images by cameras (k, n) of P."""
        k, n = view.shape
        (view, camera), (P, uv, variance) = ints(view, np.broadcast_to(camera, view.shape)), floats(P, uv, variance)
        out = np.empty((3, n)), np.empty((3, 3, n)), np.empty((k, n))
        sizes = map(size, (len(P), k, n, len(uv)))
        self._kernel.placed(*sizes, *map(at, (P, uv, variance, view, camera, *out)))
        return out


def library() -> Library | None:
    """The compiled kernel; None where it was not built or `PLAIN` is set, and NumPy does the work."""
    return None if plain() else _loaded()


@cache
def _loaded() -> Library | None:
    return loaded(__file__, Library)
