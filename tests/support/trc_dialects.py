"""TRC as many programs write it: one table, and what each of them does to it."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import NamedTuple

from kinemark.data import Trajectories

KEYS = ["DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units", "OrigDataRate", "OrigDataStartFrame"]


@dataclass(frozen=True)
class TrcText:
    """A TRC file before it is text: each part as rows of cells."""

    head: list[str]
    keys: list[str]
    values: list[str]
    names: list[str]
    axes: list[list[str]]
    blank: list[list[str]]
    rows: list[list[str]]
    mark: str = "\t"
    end: str = "\n"
    encoding: str = "utf-8"

    @classmethod
    def of(cls, t: Trajectories) -> TrcText:
        """As the format's manual wants it; gaps are empty cells."""
        n, m, rate = t.n_frames, len(t), f"{t.rate:g}"
        rows = []
        for f, row in enumerate(t.xyz.transpose(1, 0, 2).reshape(n, -1).tolist()):
            cells = ["" if math.isnan(x) else repr(x) for x in row]
            rows.append([str(f + t.first_frame), repr(round(f / t.rate, 9)), *cells])
        return cls(
            head=["PathFileType", "4", "(X/Y/Z)", "trial.trc"],
            keys=[*KEYS, "OrigNumFrames"],
            values=[rate, rate, str(n), str(m), "mm", rate, "1", str(n)],
            names=["Frame#", "Time", *(cell for name in t.names for cell in (name, "", ""))],
            axes=[["", "", *(f"{axis}{i + 1}" for i in range(m) for axis in "XYZ")]],
            blank=[[]],
            rows=rows,
        )

    def encoded(self) -> bytes:
        """The bytes of the file."""
        parts = [self.head, self.keys, self.values, self.names, *self.axes, *self.blank, *self.rows]
        return "".join(self.mark.join(row) + self.end for row in parts).encode(self.encoding)


class Dialect(NamedTuple):
    """What a program does, and whether reading it takes something for granted that must be said."""

    change: Callable[[TrcText], TrcText]
    says: bool = False


def without(t: TrcText, key: str, *, heading: bool) -> TrcText:
    """Without one value, which shifts those behind it; with or without its heading."""
    if key not in t.keys:
        return t
    at = t.keys.index(key)
    keys = [k for k in t.keys if k != key] if heading else t.keys
    return replace(t, keys=keys, values=t.values[:at] + t.values[at + 1 :])


def rewritten(t: TrcText, cell: Callable[[str], str]) -> TrcText:
    """With every coordinate written otherwise; an empty cell is a gap."""
    return replace(t, rows=[[*row[:2], *map(cell, row[2:])] for row in t.rows])


def stripped(row: list[str]) -> list[str]:
    """Without the markers at the end that are not seen."""
    stop = len(row)
    while stop > 2 and not any(row[stop - 3 : stop]):
        stop -= 3
    return row[:stop]


def once_an_axis(t: TrcText, mark: str) -> TrcText:
    """Names three times, with the axis behind them or alike."""
    names = [cell for cell in t.names[2:] if cell]
    if len(names) == len(t.rows[0]) - 2:
        return t  # they are so already
    axes = [f"{mark}{axis}" for axis in "XYZ"] if mark else [""] * 3
    return replace(t, names=[*t.names[:2], *(name + axis for name in names for axis in axes)], axes=[])


DIALECTS = {
    "as the manual wants it": Dialect(lambda t: t),
    "more frames than the heading says": Dialect(
        lambda t: replace(t, values=[*t.values[:2], str(len(t.rows) - 1), *t.values[3:]]), says=True
    ),
    "no unit": Dialect(lambda t: without(t, "Units", heading=True), says=True),
    "a heading without its unit": Dialect(lambda t: without(t, "Units", heading=False), says=True),
    "a unit without its heading": Dialect(lambda t: replace(t, keys=[k for k in t.keys if k != "Units"])),
    "no original frames": Dialect(lambda t: replace(t, keys=t.keys[:5], values=t.values[:5])),
    "no rate": Dialect(lambda t: without(t, "DataRate", heading=True), says=True),
    "blanks instead of tabs in the heading": Dialect(lambda t: replace(t, values=["   ".join(t.values)])),
    "blanks around cells": Dialect(lambda t: replace(t, values=[f"  {v} " for v in t.values])),
    "no line of axes": Dialect(lambda t: replace(t, axes=[])),
    "no empty line": Dialect(lambda t: replace(t, blank=[])),
    "three empty lines": Dialect(lambda t: replace(t, blank=[[], ["", ""], []])),
    "axes two cells off": Dialect(lambda t: replace(t, axes=[t.axes[0][2:]] if t.axes else [])),
    "axes counted from elsewhere": Dialect(
        lambda t: replace(t, axes=[["", "", *(f"{a}{i + 5}" for i in range(len(t.rows[0]) // 3) for a in "XYZ")]])
    ),
    "names without empty cells": Dialect(lambda t: replace(t, names=[cell for cell in t.names if cell])),
    "names three times": Dialect(lambda t: once_an_axis(t, "")),
    "names with _X, _Y, _Z": Dialect(lambda t: once_an_axis(t, "_")),
    "rows end at the last marker seen": Dialect(
        lambda t: replace(t, rows=[stripped(row) for row in t.rows]), says=True
    ),
    "zeros as gaps": Dialect(lambda t: rewritten(t, lambda cell: cell or "0.000000")),
    "NaN as gaps": Dialect(lambda t: rewritten(t, lambda cell: cell or "NaN")),
    "1.#QNAN as gaps": Dialect(lambda t: rewritten(t, lambda cell: cell or "-1.#QNAN0")),
    "cells in quotes": Dialect(lambda t: replace(t, names=[f'"{cell}"' for cell in t.names])),
    "Windows": Dialect(lambda t: replace(t, end="\r\n", encoding="cp1252")),
    "UTF-16": Dialect(lambda t: replace(t, encoding="utf-16")),
    "a mark of UTF-8": Dialect(lambda t: replace(t, encoding="utf-8-sig")),
    "commas between cells": Dialect(lambda t: replace(t, mark=",")),
    "Frame, Times": Dialect(lambda t: replace(t, names=["Frame", "Times", *t.names[2:]])),
    "a blank before the time": Dialect(lambda t: replace(t, names=["Frame#", " Time ", *t.names[2:]])),
    "PathFileType without tabs": Dialect(lambda t: replace(t, head=["PathFileType  4 (X/Y/Z) C:\\trial.trc"])),
    "tabs at the end": Dialect(
        lambda t: replace(t, names=[*t.names, "", ""], rows=[[*row, ""] for row in t.rows], keys=[*t.keys, ""])
    ),
}
"""By what they do, in an order in which any of them go together."""


def written_as(trajectories: Trajectories, names: Collection[str]) -> bytes:
    """A TRC file with these dialects, in the order of the table."""
    text = TrcText.of(trajectories)
    for name, dialect in DIALECTS.items():
        text = dialect.change(text) if name in names else text
    return text.encoded()
