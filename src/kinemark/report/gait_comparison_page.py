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
from .figures_gait import BLANK, KINEMATICS, KINETICS, PLANES, REFERENCE_COLOUR, SIDE_COLOURS, UNITS, Panel
from .formatting import number, signed, some
from .gait_page import KEY_DIGITS, NAMES, SHOWN
from .stride_panels import Part, band, directions, line, stride_figure
from .tables import Table
from .templating import render, write_text

NAV = {
    "verdict": "What differs", "time": "Time and distance", "keys": "Key values", "left": "Left", "right": "Right",
    "terms": "Methods",
}  # fmt: skip
"""Sections of the page, in their order."""
DRAWN = {"Angles": (KINEMATICS, PLANES), "Moments and powers": (KINETICS, ())}
"""Panels of each drawing of a side, and what its columns are; one is a page on paper."""
JUDGED = {True: "differs", False: "within its error", None: "not judged"}
"""What is said of one number."""


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
        not_judged=not_judged(figures),
        error_holds=error_holds(figures),
        time_table=parameters_table(figures),
        key_table=key_values_table(figures),
        drawings={side: side_figures([c for c in curves if c.side == side], side) for side in ("left", "right")},
    )
    write_text(path, text)


def _subjects(figures: dict[str, Any]) -> list[str]:
    """That are stated, each once."""
    return list(dict.fromkeys(one["subject"] for one in figures["conditions"] if one["subject"]))


def other_subject(figures: dict[str, Any]) -> tuple[str, ...]:
    """What is said where the two conditions state different subjects, and what to do; empty where they do not."""
    one, two = figures["conditions"]
    if not one["subject"] or not two["subject"] or one["subject"].casefold() == two["subject"].casefold():
        return ()
    said = f"“{one['name']}” is of {one['subject']}, and “{two['name']}” is of {two['subject']}"
    return f"{said}: what differs may be that they are two people.", "Check which files were compared."


def error_holds(figures: dict[str, Any]) -> str:
    """What the errors of the differences hold, and what they lack."""
    if without := figures["without_uncertainty"]:
        return (
            f"The measurement's own error was not computed for {' and '.join(without)} (--no-uncertainty), and is "
            "missing here: what differs may be where markers sat. Run kinemark gait without that option to know."
        )
    if figures["same_markers"]:
        return "The markers stayed on in between: what is systematic is in both alike and does not count."
    return "Markers were put on anew in between: where they sit counts in both."


def strides_compared(figures: dict[str, Any]) -> str:
    """How many strides of each side there are of each condition."""
    each = [f"{c['name']} {c['strides']['left']} left, {c['strides']['right']} right" for c in figures["conditions"]]
    return f"Strides: {'; '.join(each)}."


def not_judged(figures: dict[str, Any]) -> str:
    """Which curves have parts without a known error; empty where there are none."""
    titles = {(p.name, p.axis): p.title.lower() for p in (*KINEMATICS, *KINETICS)}
    found = [
        f"{titles[one['name'][1:], k]} {one['side']}"
        for one in figures["curves"] for k, part in enumerate(one["components"])
        if part["unknown"] and (one["name"][1:], k) in titles
    ]  # fmt: skip
    if not found:
        return ""
    which = some("curve", found)
    return (
        f"Parts of {which} are not judged: neither condition has two strides of them, so that nobody knows how much "
        "strides differ. Give each condition more walks."
    )


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
            most = f"{signed(part['greatest'], digits)}{unit} at {part['at']} %"
            rows.append(
                (size, [f"{title}, {one['side']}", where, most, f"± {number(part['error_there'], digits)}{unit}"])
            )
    rows.sort(key=lambda row: -row[0])
    return Table(
        ["", "where in the stride", "where clearest", "its error (95 %)"], [row for _, row in rows],
        absent="No angle, moment or power whose error is known differs by more than it.",
    )  # fmt: skip


def parameters_table(figures: dict[str, Any]) -> Table:
    """A row a time-distance parameter of a side; those that differ beyond their error are marked."""
    order = list(NAMES)
    rows = sorted(figures["time_distance"], key=lambda one: (order.index(one["name"]), one["side"]))
    shown = {one["name"]: SHOWN[one["unit"]] for one in rows}
    cells = [_compared(one, f"{NAMES[one['name']]}, {one['side']}", *shown[one["name"]], finer=1) for one in rows]
    return _numbers_table(figures, rows, cells)


def key_values_table(figures: dict[str, Any]) -> Table:
    """A row a key value of a side; those that differ beyond their error are marked."""
    rows = figures["key_values"]
    cells = [
        _compared(one, f"{one['name']}, {one['side']}", UNITS.get(one["unit"], one["unit"]), 1.0,
                  KEY_DIGITS.get(one["unit"], 2))
        for one in rows
    ]  # fmt: skip
    return _numbers_table(figures, rows, cells)


def _compared(one: dict[str, Any], title: str, unit: str, by: float, digits: int, *, finer: int = 0) -> list[str]:
    """The row of one number; `finer`: decimals more of what is a difference."""
    values = [number(one[key] / by, digits) for key in ("first", "second")]
    error = "–" if one["error"] is None else f"± {number(one['error'] / by, digits + finer)}"
    judged = JUDGED[None if one["error"] is None else one["exceeds"]]
    return [f"{title} ({unit})", *values, signed(one["difference"] / by, digits + finer), error, judged]


def _numbers_table(figures: dict[str, Any], rows: Sequence[dict[str, Any]], cells: Sequence[list[str]]) -> Table:
    """Of both conditions beside each other."""
    head = ["", *(one["name"] for one in figures["conditions"]), "difference", "its error (95 %)", ""]
    return Table(head, cells, marked=[bool(one["exceeds"]) for one in rows], absent="There are none in both.",
                 kept_in="comparison.csv")  # fmt: skip


def side_figures(curves: Sequence[ComparedCurve], side: str) -> dict[str, Figure]:
    """Means of both conditions; grey: what the second may be off by its error; bars below: where it is off by more."""
    by_name = {one.name[1:]: one for one in curves}
    return {
        title: _side_figure(by_name, panels, heads, SIDE_COLOURS[side])
        for title, (panels, heads) in DRAWN.items() if any(p.name in by_name for p in panels)
    }  # fmt: skip


def _side_figure(
    by_name: dict[str, ComparedCurve], panels: Sequence[Panel], heads: Sequence[str], colour: str
) -> Figure:
    """A panel a component, where both conditions have it; the others stay empty."""
    here = [p if p.name in by_name else BLANK for p in panels]
    titles = [f"{p.title} ({UNITS.get(u := by_name[p.name].unit, u)})" if p.name else "" for p in here]
    parts = [_curves(by_name[p.name], p, colour, i) for i, p in enumerate(here) if p.name]
    notes = [directions(p.up, p.down, i) for i, p in enumerate(here) if p.name]
    hidden = {i: ({"visible": False}, {"visible": False}) for i, p in enumerate(here) if not p.name}
    flat = itertools.chain.from_iterable
    return stride_figure(titles, list(flat(parts)), (), list(flat(notes)), heads=heads, axes=hidden)


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
