"""A figure as plain data in the form that Plotly's script reads: traces and a layout of nested dicts.

Plotly's own graph objects check and copy every value, which took more time than all that a page shows.
`tests/report/test_drawing.py` has them check each kind of figure, so that a wrong key fails there.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

SHORT_NAMES = {"i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"}
"""Of the numbers that the script reads from bytes."""
WHOLE = {"i": ("i1", "i2", "i4"), "u": ("u1", "u2", "u4")}
"""Of whole numbers of 64 bits, which it does not read, the shorter ones."""


@dataclass(frozen=True, slots=True)
class Figure:
    """What is drawn. Methods add to it and give it back.

    Attributes:
        data: the traces; lists and arrays of numbers, texts and nested dicts by Plotly's names.
        layout: likewise.
    """

    data: list[dict[str, Any]] = field(default_factory=list)
    layout: dict[str, Any] = field(default_factory=dict)

    def add(self, kind: str, **trace: Any) -> Figure:
        """One more trace, of a kind of Plotly's, as `scatter`."""
        self.data.append({**trace, "type": kind})
        return self

    def annotate(self, **note: Any) -> Figure:
        """One more text."""
        self.layout["annotations"] = [*self.layout.get("annotations", ()), note]
        return self

    def shape(self, **shape: Any) -> Figure:
        """One more line or area."""
        self.layout["shapes"] = [*self.layout.get("shapes", ()), shape]
        return self

    def arrange(self, **layout: Any) -> Figure:
        """The layout with these parts; what is a dict in both is put together."""
        self.layout.update(merged(self.layout, layout))
        return self

    def x_axes(self, **axis: Any) -> Figure:
        """All x axes with these parts."""
        return self._axes("xaxis", axis)

    def y_axes(self, **axis: Any) -> Figure:
        """All y axes with these parts."""
        return self._axes("yaxis", axis)

    def _axes(self, name: str, axis: dict[str, Any]) -> Figure:
        return self.arrange(**{key: axis for key in self.layout if key.startswith(name)})

    def to_json(self) -> str:
        """As the script reads it; numbers that are not finite are null, or in bytes."""
        return json.dumps(_plain({"data": self.data, "layout": self.layout}), separators=(",", ":"), allow_nan=False)


def merged(base: Mapping[str, Any], more: Mapping[str, Any]) -> dict[str, Any]:
    """Both, what is in a dict of both put together."""
    dicts = (key for key in base.keys() & more.keys() if isinstance(base[key], dict) and isinstance(more[key], dict))
    return {**base, **more, **{key: merged(base[key], more[key]) for key in dicts}}


def _plain(value: Any) -> Any:
    """The same of dicts, lists and what JSON has beside them; a key of nothing falls away."""
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items() if part is not None}
    if isinstance(value, np.ndarray):
        return _typed(value)
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _typed(values: NDArray[Any]) -> Any:
    """An array as bytes, which are shorter and exact; as a list where the script has no such numbers."""
    if not values.size:
        return values.tolist()
    if values.dtype.itemsize == 8 and values.dtype.kind in WHOLE:
        fits = (np.dtype(name) for name in WHOLE[values.dtype.kind])
        least, most = values.min(), values.max()
        values = values.astype(
            next((d for d in fits if np.iinfo(d).min <= least and most <= np.iinfo(d).max), np.int64)
        )
    name = values.dtype.str[1:]
    if name not in SHORT_NAMES:
        return _plain(values.tolist())
    packed = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()
    coded = {"dtype": name, "bdata": base64.b64encode(packed).decode("ascii")}
    return coded | ({"shape": ", ".join(map(str, values.shape))} if values.ndim > 1 else {})
