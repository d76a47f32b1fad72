"""How records hold arrays: right dtype, right shape, read-only."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from .array_types import Ints


def column(name: str, value: ArrayLike, dtype: DTypeLike, *shape: int | None) -> NDArray[Any]:
    """A read-only view of `value` with this dtype and shape; None in `shape` means any length.

    Raises:
        ValueError: the shape is another one; the message has the name, what was found and what was wanted.
    """
    array = np.asarray(value, dtype=dtype).view()
    fits = array.ndim == len(shape) and all(
        want is None or want == have for want, have in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("any" if n is None else str(n) for n in shape)
        raise ValueError(f"{name} has shape {array.shape}, wanted ({wanted})")
    array.flags.writeable = False
    return array


def set_columns(record: object, **columns: NDArray[Any] | tuple[Any, ...]) -> None:
    """Fill checked columns into a frozen record; only for use in its `__post_init__`."""
    for name, value in columns.items():
        object.__setattr__(record, name, value)


def check_offsets(start: Ints, total: int) -> None:
    """Offsets along the last axis must begin anywhere, never fall, and end the flat columns.

    Raises:
        ValueError: the offsets do not cut `total` rows into consecutive parts.
    """
    flat = start.reshape(-1)
    if start.ndim == 2 and (start[1:, :1] != start[:-1, -1:]).any():
        raise ValueError("start must go on where the row before ends")
    if start.shape[-1] < 1 or (np.diff(flat) < 0).any() or (flat.size and (flat[0] != 0 or flat[-1] != total)):
        raise ValueError(f"start must rise from 0 to the number of rows, {total}; found {flat[:1]} … {flat[-1:]}")


def check_positive(**values: float | None) -> None:
    """Parameters must be finite and above zero; None is left out.

    Raises:
        ValueError: one is not; the message names it.
    """
    for name, value in values.items():
        if value is not None and not 0 < value < np.inf:
            raise ValueError(f"{name} is {value}, wanted a number above 0")


def same(a: Any, b: Any) -> bool:
    """Whether two records, arrays or tuples of them hold equal values; NaN equals NaN."""
    if is_dataclass(a) and not isinstance(a, type):
        return type(a) is type(b) and all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if isinstance(a, (tuple, list)):
        return type(a) is type(b) and len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, dict):
        return isinstance(b, dict) and a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and np.array_equal(a, b, equal_nan=a.dtype.kind in "fc")
    return bool(a == b) or (isinstance(a, float) and isinstance(b, float) and a != a and b != b)
