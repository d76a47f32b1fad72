"""What an interpreter shows of data: names, sizes and kinds, in place of half a million characters of numbers."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

SHOWN = 4
"""Elements of a list that are shown each; chosen: a trial then fits on a screen."""
CHARACTERS = 80
"""Characters of a text that are shown; chosen: a line."""
NUMBERS = 12
"""Numbers of an array that are shown each; by definition: those of a camera matrix."""


class ShortRepr:
    """A dataclass (with `repr=False`) whose `repr` says what is in it, and how much of it."""

    __slots__ = ()

    def __repr__(self) -> str:
        """`Name(field=…, …)`, with arrays as their shape and kind, and long lists as their length and first names."""
        told = (f"{each.name}={_short(getattr(self, each.name))}" for each in fields(self) if each.repr)  # type: ignore[arg-type]
        return f"{type(self).__name__}({', '.join(told)})"


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        few = value.size <= NUMBERS and (value.size > 0 or value.ndim == 1)
        return repr(value.tolist()) if few else f"<{value.dtype} {value.shape}>"
    if isinstance(value, bytes) and len(value) > CHARACTERS:
        return f"<{len(value)} bytes>"
    if isinstance(value, tuple | list | dict) and len(value) > SHOWN:
        return _long(value)
    if isinstance(value, tuple | list):
        inside = ", ".join(map(_short, value))
        return f"[{inside}]" if isinstance(value, list) else f"({inside}{',' * (len(value) == 1)})"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key!r}: {_short(each)}" for key, each in value.items()) + "}"
    text = repr(value)
    return text if len(text) <= CHARACTERS or isinstance(value, ShortRepr) else f"{text[:CHARACTERS]}…"


def _long(values: tuple[Any, ...] | list[Any] | dict[Any, Any]) -> str:
    """`<15 MarkerTrajectory: LANK, LASI, LHEE, LKNE, …>`."""
    some = list(values)[:SHOWN]
    kinds = sorted({type(each).__name__ for each in values})
    names = (str(getattr(each, "name", _short(each))) for each in some)
    return f"<{len(values)} {' or '.join(kinds)}: {', '.join(names)}, …>"
