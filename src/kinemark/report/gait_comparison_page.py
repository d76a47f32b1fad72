"""Two conditions of gait over each other: a page that says which differences exceed their error."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..gait.comparison import Condition, Difference, stretches
from .drawing import Figure
from .drawing_library import drawing_library
from .figures_gait import KINEMATICS, KINETICS, REFERENCE_COLOUR, SIDE_COLOURS, UNITS, Panel
from .formatting import number
from .gait_page import NAMES, SHOWN
from .stride_panels import Part, band, line, stride_figure
from .tables import Table
from .templating import render, write_text

NAV = {"verdict": "What differs", "time": "Time and distance", "left": "Left", "right": "Right", "terms": "Methods"}
"""Sections of the page, in their order."""


class ComparedCurve(NamedTuple):
    """A quantity of one side in both conditions, (101, A) each."""

    name: str
    side: str
    unit: str
    axes: tuple[str, ...]
    first: Condition
    second: Condition
    difference: Difference


def write_comparison_page(
    path: Path, *, figures: dict[str, Any], curves: Sequence[ComparedCurve], assets: Path | None = None
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page. figures: of the comparison. curves: what is drawn.
        assets: folder of the drawing library that pages share; None puts it inside the page.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    one, two = figures["conditions"]
    text = render(
        "gait_comparison.html",
        library=drawing_library(path, assets),
        heading=f"{one['name']} and {two['name']}: gait compared",
        below=f"{' and '.join(_subjects(figures)) or 'Subject not stated'} · Kinemark {figures['kinemark']}",
        nav=NAV,
        figures=figures,
        differing=differing_table(figures),
        doubt=other_subject(figures),
        strides=strides_compared(figures),
        time_table=parameters_table(figures),
        drawings={side: side_figure([c for c in curves if c.side == side], side) for side in ("left", "right")},
    )
    write_text(path, text)


def _subjects(figures: dict[str, Any]) -> list[str]:
    """That are stated, each once."""
    return list(dict.fromkeys(one["subject"] for one in figures["conditions"] if one["subject"]))


def other_subject(figures: dict[str, Any]) -> str:
    """What is said where the two conditions state different subjects; empty where they do not."""
    one, two = figures["conditions"]
    if not one["subject"] or not two["subject"] or one["subject"].casefold() == two["subject"].casefold():
        return ""
    return (
        f"{one['name']} is of {one['subject']} and {two['name']} of {two['subject']}: what differs may be that they "
        "are two people. Check which files were compared."
    )


def strides_compared(figures: dict[str, Any]) -> str:
    """How many strides of each side there are of each condition."""
    each = [f"{c['name']} {c['strides']['left']} left, {c['strides']['right']} right" for c in figures["conditions"]]
    return f"Strides: {'; '.join(each)}."


def differing_table(figures: dict[str, Any]) -> Table:
    """A row a component that differs, the clearest first."""
    titles = {(p.name, p.axis): p.title for p in (*KINEMATICS, *KINETICS)}
    rows = []
    for one in figures["curves"]:
        for k, part in enumerate(one["components"]):
            title = titles.get((one["name"][1:], k))
            if not part["stretches"] or title is None:
                continue
            where = ", ".join(f"{a} to {b} %" for a, b in part["stretches"])
            unit, digits = UNITS.get(one["unit"], f" {one['unit']}"), 1 if one["unit"] == "deg" else 2
            size = abs(part["greatest"]) / part["error_there"]
            signed = f"{part['greatest']:+.{digits}f}{unit} at {part['at']} %"
            rows.append(
                (size, [f"{title}, {one['side']}", where, signed, f"± {number(part['error_there'], digits)}{unit}"])
            )
    rows.sort(key=lambda row: -row[0])
    return Table(
        ["", "where in the stride", "where clearest", "its error (95 %)"], [row for _, row in rows],
        absent="No angle, moment or power differs by more than its own error.",
    )  # fmt: skip


def parameters_table(figures: dict[str, Any]) -> Table:
    """A row a time-distance parameter; those that differ beyond their error are marked."""
    rows, marked = [], []
    for one in figures["time_distance"]:
        unit, by, digits = SHOWN[one["unit"]]
        values = [number(one[key] / by, digits) for key in ("first", "second")]
        error = "–" if one["error"] is None else f"± {number(one['error'] / by, digits + 1)}"
        title, off = f"{NAMES[one['name']]}, {one['side']} ({unit})", f"{one['difference'] / by:+.{digits + 1}f}"
        rows.append([title, *values, off, error, "differs" if one["exceeds"] else "within its error"])
        marked.append(bool(one["exceeds"]))
    names = [one["name"] for one in figures["conditions"]]
    return Table(["", *names, "difference", "its error (95 %)", ""], rows, marked=marked)


def side_figure(curves: Sequence[ComparedCurve], side: str) -> Figure:
    """Means of both conditions; grey: what the second may be off by its error; bars below: where it is off by more."""
    by_name = {one.name[1:]: one for one in curves}
    panels = [p for p in (*KINEMATICS, *KINETICS) if p.name in by_name]
    titles = [f"{p.title} ({UNITS.get(by_name[p.name].unit, by_name[p.name].unit)})" for p in panels]
    parts = [_curves(by_name[p.name], p, SIDE_COLOURS[side], i) for i, p in enumerate(panels)]
    return stride_figure(titles, list(itertools.chain.from_iterable(parts)))


def _curves(one: ComparedCurve, panel: Panel, colour: str, i: int) -> list[Part]:
    """Both means, the error about the first, and a bar where the second is off by more."""
    first, second, error = (part[:, panel.axis] for part in (one.first.mean, one.second.mean, one.difference.error))
    low = float(np.nanmin([first - error, second])) if np.isfinite(second).any() else 0.0
    bar = np.full(101, np.nan)
    for a, b in stretches(one.difference.exceeds[:, panel.axis]):
        bar[a : b + 1] = low
    return [
        *band(first - error, first + error, REFERENCE_COLOUR, i),
        line(first, REFERENCE_COLOUR, "first", i, dash="dash"),
        line(second, colour, "second", i),
        line(bar, colour, "", i, width=5),
    ]
