"""What arrays a function takes, declared once and checked in one call.

    POINTS = Arrays(x=(FLOAT, 9, "n"), T=(FLOAT, "n"), image=(index("d", none=True), "n"), uv=(FLOAT, "d", 2))
    x, T, image, uv = POINTS(x, T, image, uv)

A letter is a size that is the same wherever it stands. What comes back is in C order and of the declared dtype, so that
compiled code can read it. `POINTS.check_indices` checks that indices are in range.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Ints


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
        axis_of = {n: (j, i) for j, want in enumerate(self._wanted) for i, n in enumerate(want.shape)}
        self._indices = [(k, w.name, w.kind, axis_of[w.kind.below]) for k, w in enumerate(self._wanted) if w.kind.below]
        self._known: dict[int | str, int] = {n: n for want in self._wanted for n in want.shape if isinstance(n, int)}

    def __call__(self, *values: Any) -> list[NDArray[Any]]:
        """The arrays, of the declared dtype and in C order; copies only where they were not.

        Raises:
            ValueError: one has another shape, or a dtype that cannot be cast without loss; the message has its name,
                what was found and what was wanted.
        """
        sizes, arrays = self._known.copy(), []
        for value, wanted in zip(values, self._wanted, strict=True):
            array, (_, kind, shape) = np.asarray(value), wanted
            if array.ndim != len(shape):
                raise _other_shape(array, wanted, sizes)
            for have, size in zip(array.shape, shape, strict=True):
                if have != sizes.setdefault(size, have):
                    raise _other_shape(array, wanted, sizes)
            if array.dtype not in kind.dtypes:
                array = _cast(array, wanted)
            flags = array.flags
            arrays.append(array if flags.c_contiguous and flags.aligned else array.copy())
        return arrays

    def check_indices(self, arrays: Sequence[NDArray[Any]]) -> None:
        """Refuse arrays, in the shapes that were declared, with indices out of range.

        Compiled functions refuse these themselves, at less cost; this says what is wrong.

        Raises:
            ValueError: there is one; the message has the array's name, the index and what was wanted.
        """
        for k, name, kind, (j, axis) in self._indices:
            check_indices(name, arrays[k], arrays[j].shape[axis], least=kind.least)


def _other_shape(array: NDArray[Any], wanted: _Wanted, sizes: dict[int | str, int]) -> ValueError:
    """What is said of an array of another shape."""
    shape = ", ".join(map(str, wanted.shape)) + "," * (len(wanted.shape) == 1)
    known = "".join(f", {n} = {sizes[n]}" for n in wanted.shape if isinstance(n, str) and n in sizes)
    return ValueError(f"{wanted.name} has shape {array.shape}, wanted ({shape}){known}")


def _cast(array: NDArray[Any], wanted: _Wanted) -> NDArray[Any]:
    """The array in the first of the dtypes wanted to which it can be cast without loss."""
    for dtype in wanted.kind.dtypes:
        if np.can_cast(array.dtype, dtype, "safe"):
            return array.astype(dtype, order="C")
    raise ValueError(f"{wanted.name} has dtype {array.dtype}, wanted {' or '.join(map(str, wanted.kind.dtypes))}")


def check_indices(name: str, array: Ints, below: int, *, least: int = 0) -> None:
    """Refuse an array with indices that are not in least … below − 1.

    Raises:
        ValueError: it has one; the message has the name, the index and what was wanted.
    """
    if array.size and (array.min() < least or array.max() >= below):
        wrong = array[(array < least) | (array >= below)][0]
        raise ValueError(f"{name} has the index {wrong}, wanted {least} … {below - 1}")
