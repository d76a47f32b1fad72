"""Colours and layout that all figures share.

The hues are those of Okabe and Ito (2008), which people with any colour vision tell apart; yellow, too pale on
white, is left out. Beyond seven, the same hues come darker and paler.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

from .drawing import Figure, merged

HUES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#4D4D4D")
SHADES = ((0, 0.0), (0, 0.45), (255, 0.45))
"""Towards black or white, and how far; dashes would look like missing samples; chosen."""
LONGEST = 24
"""Most letters of a name in a figure, as far as names differ in them; chosen."""
KEPT = 6
"""Letters before the first difference that are still shown; chosen."""
INK, FAINT, GRID, PAPER = "#1C2733", "#66727F", "#E4E8EC", "#FFFFFF"
"""On light pages; on dark ones the page itself recolours what it draws (`templates/frame.html`)."""
STATES = {"missing": "#D9DEE3", "measured": "#0072B2", "filled": "#E69F00", "edited": "#CC79A7"}
"""Colour of each `Origin`, in its order."""


def hue(i: int) -> str:
    """Colour of the i-th camera or marker; after each seven the same hues come darker, then paler."""
    rgb = [int(HUES[i % len(HUES)][k : k + 2], 16) for k in (1, 3, 5)]
    towards, by = SHADES[i // len(HUES) % len(SHADES)]
    return "#" + "".join(f"{round(value + by * (towards - value)):02X}" for value in rgb)


def label(name: str) -> str:
    """One name as Plotly may show it, as `labels`."""
    return labels([name])[0]


def labels(names: Iterable[str]) -> list[str]:
    """Names given by the user as Plotly may show them: markup in them stays text, and different ones differ."""
    return [escape(name) or " " for name in shortened(list(names))]


def camera_ticks(cameras: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """An axis with the names of all cameras under their places, also of those without data."""
    names = labels(camera["name"] for camera in cameras)
    return {"tickvals": list(range(len(names))), "ticktext": names, "range": [-0.6, len(names) - 0.4], "ticks": ""}


def shortened(names: Sequence[str], most: int = LONGEST) -> list[str]:
    """Names of at most `most` letters, with … for what is left out, such that different names stay different.

    The end of a long name falls away; where that makes two the same, their common beginning; else they stay whole.
    """
    shown = {name: _cut(name, most) for name in names}
    for equal in _equal_names(shown):
        shown |= _without_common_start(equal, most)
    for equal in _equal_names(shown):
        shown |= {name: name for name in equal}
    return [shown[name] for name in names]


def _equal_names(shown: Mapping[str, str]) -> list[list[str]]:
    """Different names that are shown the same."""
    groups: dict[str, list[str]] = {}
    for name, text in shown.items():
        groups.setdefault(text, []).append(name)
    return [group for group in groups.values() if len(group) > 1]


def _without_common_start(names: Sequence[str], most: int) -> dict[str, str]:
    """Each name from a little before the first letter in which they differ."""
    letters = enumerate(zip(*names, strict=False))
    first = next((i for i, these in letters if len(set(these)) > 1), min(map(len, names)))
    return {name: "…" + _cut(name[max(first - KEPT, 0) :], most - 1) for name in names}


def _cut(name: str, most: int) -> str:
    return name if len(name) <= most else name[: most - 1] + "…"


def axis_style() -> dict[str, Any]:
    """Of every axis in two dimensions."""
    return {
        "gridcolor": GRID,
        "zerolinecolor": GRID,
        "linecolor": FAINT,
        "ticks": "outside",
        "tickcolor": GRID,
        "automargin": True,
        "title": {"standoff": 10},
    }


def even_scale(*colours: str) -> list[list[Any]]:
    """A colour scale on which these are evenly spaced."""
    return [[i / (len(colours) - 1), colour] for i, colour in enumerate(colours)]


def figure(height: int, **layout: Any) -> Figure:
    """An empty figure in the house style, `height` px high."""
    base = {
        "height": height,
        "margin": {"l": 60, "r": 20, "t": 24, "b": 48},
        "paper_bgcolor": PAPER,
        "plot_bgcolor": PAPER,
        "font": {"family": "system-ui, 'Segoe UI', Roboto, Helvetica, Arial, sans-serif", "size": 13, "color": INK},
        "xaxis": axis_style(),
        "yaxis": axis_style(),
        "hoverlabel": {"bgcolor": PAPER, "font": {"color": INK}},
        "legend": {"itemsizing": "constant", "font": {"size": 12}},
        "showlegend": False,
    }
    return Figure(layout=merged(base, layout))


def empty(message: str) -> Figure:
    """A low frame that says why there is nothing to draw."""
    blank = figure(110, xaxis={"visible": False}, yaxis={"visible": False})
    return blank.annotate(text=message, showarrow=False, font={"color": FAINT, "size": 14}, x=0.5, y=0.5)
