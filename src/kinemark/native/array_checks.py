"""What arrays a function takes, declared once and checked in one call.

    POINTS = Arrays(x=(FLOAT, 9, "n"), T=(FLOAT, "n"), row=(index("d", none=True), "n"), uv=(FLOAT, "d", 2))
    x, T, row, uv = POINTS(x, T, row, uv)

A letter is a size that is the same wherever it stands. What comes back is in C order and of the declared dtype, so that
compiled code can read it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


class Kind(NamedTuple):
    """Which numbers an array holds.

    Attributes:
        dtypes: the first to which the array can be cast without loss is taken.
        below: indices must be less than this size, a letter of the shapes; empty for what is no index.
        least: the least index.
    """

    dtypes: tuple[np.dtype[Any], ...]
    below: str = ""
    least: int = 0


FLOAT = Kind((np.dtype(np.float64),))
INT = Kind((np.dtype(np.int64),))
BOOL = Kind((np.dtype(np.bool_),))
GREY = Kind((np.dtype(np.uint8), np.dtype(np.uint16)))


def index(below: str, *, none: bool = False) -> Kind:
    """Indices 0 … below − 1, where `below` is a letter of the shapes; and −1, for none, where `none` says so."""
    return Kind(INT.dtypes, below, -1 if none else 0)


class _Wanted(NamedTuple):
    """An array that a function takes: its name, kind, and the sizes of its axes, numbers or letters."""

    name: str
    kind: Kind
    shape: tuple[int | str, ...]


class Arrays:
    """The arrays that a function takes: each name with its kind and the sizes of its axes."""

    def __init__(self, **wanted: tuple[Kind, *tuple[int | str, ...]]) -> None:
        """Take the kind and shape of each array, in the order in which they are passed."""
        self._wanted = [_Wanted(name, spec[0], spec[1:]) for name, spec in wanted.items()]

    def __call__(self, *values: Any) -> list[NDArray[Any]]:
        """The arrays, of the declared dtype and in C order; copies only where they were not.

        Raises:
            ValueError: one has another shape, a dtype that cannot be cast without loss, or an index out of range; the
                message has its name, what was found and what was wanted.
        """
        sizes: dict[str, int] = {}
        arrays = [_fitted(value, want, sizes) for value, want in zip(values, self._wanted, strict=True)]
        for array, want in zip(arrays, self._wanted, strict=True):
            if want.kind.below and array.size:
                _check_range(want.name, array, want.kind.least, sizes[want.kind.below])
        return arrays


def _fitted(value: Any, wanted: _Wanted, sizes: dict[str, int]) -> NDArray[Any]:
    """The array as it was declared; `sizes` are those known of the letters."""
    name, kind, shape = wanted
    array = np.asarray(value)
    fits = array.ndim == len(shape)
    if fits:
        for have, size in zip(array.shape, shape, strict=True):
            if have != (sizes.setdefault(size, have) if isinstance(size, str) else size):
                fits = False
    if not fits:
        known = "".join(f", {n} = {sizes[n]}" for n in shape if isinstance(n, str) and n in sizes)
        sizes_wanted = ", ".join(map(str, shape)) + "," * (len(shape) == 1)
        raise ValueError(f"{name} has shape {array.shape}, wanted ({sizes_wanted}){known}")
    if array.dtype not in kind.dtypes:
        array = array.astype(_lossless(array, wanted), order="C")
    return array if array.flags.c_contiguous and array.flags.aligned else array.copy()


def _lossless(array: NDArray[Any], wanted: _Wanted) -> np.dtype[Any]:
    """The first of the dtypes wanted to which the array can be cast without loss."""
    for dtype in wanted.kind.dtypes:
        if np.can_cast(array.dtype, dtype, "safe"):
            return dtype
    raise ValueError(f"{wanted.name} has dtype {array.dtype}, wanted {' or '.join(map(str, wanted.kind.dtypes))}")


def _check_range(name: str, array: NDArray[Any], least: int, below: int) -> None:
    """Raise ValueError where an index is out of range."""
    low, high = array.min(), array.max()
    if low < least or high >= below:
        wrong = low if low < least else high
        raise ValueError(f"{name} has the index {wrong}, wanted {least} … {below - 1}")
