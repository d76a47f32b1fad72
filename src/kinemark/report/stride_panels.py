"""Curves over the stride, in rows of three panels: what a gait page draws, as the parts that Plotly takes.

A part (line, band, upright, words) is a value that names its panel; `stride_figure` puts all of them into one figure.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..data.array_types import Floats
from ..findings.plain import runs
from .drawing import Figure
from .panels import domains, panel, panels, within
from .theme import FAINT

COLUMNS = 3
"""Panels side by side: the three planes; conventional."""
PERCENT = np.linspace(0, 100, 101)
"""Of a stride, at its 101 points; conventional."""
SMALL = {"size": 12}
"""Of titles and of what stands above the columns."""
Part = dict[str, Any]


def stride_figure(
    titles: Sequence[str],
    traces: Sequence[Part],
    shapes: Sequence[Part] = (),
    notes: Sequence[Part] = (),
    *,
    heads: Sequence[str] = (),
    axes: Mapping[int, tuple[Part, Part]] | None = None,
) -> Figure:
    """Panels with a stride below the lowest of each column, and their parts.

    Args:
        titles: of the panels, row by row; an empty one has none.
        traces: lines and bands. shapes: uprights. notes: words.
        heads: what the columns are, above them.
        axes: what the x and y axis of some panels have besides, by the number of the panel from 0.
    """
    rows, more = -(-len(titles) // COLUMNS), axes or {}
    lowest = {i % COLUMNS: i for i, title in enumerate(titles) if title}.values()
    both = [_axes(i in lowest, more.get(i, ({}, {}))) for i in range(len(titles))]
    fig = panels(
        60 + 190 * rows, (rows, COLUMNS), both, titles=titles, title_font=SMALL, gaps=gaps_of(len(titles)),
        notes=[*map(_head, range(len(heads)), heads), *notes],
        margin={"l": 44, "r": 24, "t": 78 if heads else 40, "b": 44},
    )  # fmt: skip
    fig.data.extend(traces)
    for shape in shapes:
        fig.shape(**shape)
    return fig


def gaps_of(count: int) -> tuple[float, float]:
    """Between the columns and the rows of so many panels, as shares of the whole."""
    return 0.07, 60 / (140 + 190 * -(-count // COLUMNS))


def corner(i: int, count: int) -> tuple[float, float]:
    """The upper left corner of the i-th of so many panels, as shares of the whole."""
    across, upwards = domains(i, (-(-count // COLUMNS), COLUMNS), gaps_of(count))
    return across[0], upwards[1]


def line(y: Floats, colour: str, name: str, i: int, *, width: float = 1.8, dash: str = "solid") -> Part:
    """One curve (101) over the stride in the i-th panel; without a name it has no label."""
    return {
        "type": "scatter", "x": PERCENT.astype(np.float32), "y": y.astype(np.float32), "mode": "lines", "name": name,
        "connectgaps": False, "line": {"color": colour, "width": width, "dash": dash},
        "hovertemplate": "%{x:.0f} %: %{y:.2f}" if name else None, "hoverinfo": None if name else "skip", **panel(i),
    }  # fmt: skip


def band(low: Floats, high: Floats, colour: str, i: int) -> list[Part]:
    """Filled between two curves, run by run, so that what is missing stays empty."""
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return [
        {
            "type": "scatter", "x": np.concatenate([PERCENT[a:b], PERCENT[a:b][::-1]]).astype(np.float32),
            "y": np.concatenate([high[a:b], low[a:b][::-1]]).astype(np.float32), "mode": "lines", "fill": "toself",
            "line": {"width": 0}, "fillcolor": f"rgba({red},{green},{blue},0.18)", "hoverinfo": "skip", **panel(i),
        }
        for a, b in runs(np.isfinite(low) & np.isfinite(high))
    ]  # fmt: skip


def upright(x: float, colour: str, i: int) -> Part:
    """A dashed line from the lower to the upper edge of the i-th panel, at x percent of the stride."""
    look = {"color": colour, "width": 0.8, "dash": "dash"}
    return {"type": "line", "line": look, "x0": x, "x1": x, "y0": 0, "y1": 1, **within(i, "y")}


def directions(up: str, down: str, i: int) -> list[Part]:
    """What is up and what is down, small, along the right edge, where no curve is."""
    at = panel(i)
    return [
        {
            "text": text, "x": 1.0, "y": y, "xref": f"{at['xaxis']} domain", "yref": f"{at['yaxis']} domain",
            "xanchor": "left", "textangle": -90, "yanchor": "top" if y else "bottom", "showarrow": False,
            "font": {"size": 9, "color": FAINT},
        }
        for text, y in ((up, 1.0), (down, 0.0))
    ]  # fmt: skip


def _axes(lowest: bool, more: tuple[Part, Part]) -> tuple[Part, Part]:
    """The axes of a panel; the lowest one of a column says what x is."""
    title = {"text": "stride (%)", "font": {"size": 11}, "standoff": 4} if lowest else None
    small = {"tickfont": {"size": 10}}
    x = {**small, "title": title, "range": [0, 100], "dtick": 20, **more[0]}
    return x, {**small, "title": None, "zerolinecolor": FAINT, "zerolinewidth": 0.8, **more[1]}


def _head(column: int, text: str) -> Part:
    """What stands above a column."""
    return {
        "text": f"<b>{text}</b>", "xref": f"{panel(column)['xaxis']} domain", "yref": "paper", "x": 0.5, "y": 1,
        "yshift": 26, "yanchor": "bottom", "showarrow": False, "font": SMALL,
    }  # fmt: skip
