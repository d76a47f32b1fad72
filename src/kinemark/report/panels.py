"""Several panels in one figure, with all of their axes stated at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

from .drawing import Figure
from .theme import axis_style, figure

TITLE = {"xref": "paper", "yref": "paper", "xanchor": "center", "yanchor": "bottom", "showarrow": False}
TITLE_FONT = {"size": 16}


def panels(
    height: int,
    shape: tuple[int, int],
    axes: Sequence[tuple[dict[str, Any], dict[str, Any]]],
    *,
    titles: Sequence[str] = (),
    title_font: Mapping[str, Any] = TITLE_FONT,
    notes: Sequence[dict[str, Any]] = (),
    gaps: tuple[float, float] = (0.0, 0.0),
    shared: Literal["x", "y"] | None = None,
    **layout: Any,
) -> Figure:
    """Empty panels in the house style, row by row from the upper left one.

    Args:
        height: of the whole, px. shape: rows and columns.
        axes: of each panel, what its x and y axis have beside the house style; may be fewer than the shape has places.
        titles: above the panels, in `title_font`; an empty one is none.
        notes: further annotations of Plotly's.
        gaps: between columns and between rows, as shares of the whole.
        shared: "x": all rows go with the lowest one's x axis; "y": all columns with the first one's y axis.
        layout: as for `figure`.
    """
    stated: dict[str, Any] = {}
    heads = []
    for k, (x, y) in enumerate(axes):
        across, upwards = domains(k, shape, gaps)
        own: dict[str, dict[str, Any]] = {
            "x": {"domain": across, "anchor": f"y{_number(k)}"},
            "y": {"domain": upwards, "anchor": f"x{_number(k)}"},
        }
        leader = {"x": len(axes) - 1, "y": 0, None: k}[shared]
        if shared and k != leader:
            own[shared] |= {"matches": f"{shared}{_number(leader)}", "showticklabels": False}
        stated |= {axis_key(name, k): axis_style() | own[name] | more for name, more in (("x", x), ("y", y))}
        if k < len(titles) and titles[k]:
            heads.append(TITLE | {"text": titles[k], "x": sum(across) / 2, "y": upwards[1], "font": title_font})
    fig = figure(height, **stated, **layout)
    for note in (*heads, *notes):
        fig.annotate(**note)
    return fig


def panel(k: int) -> dict[str, str]:
    """What a trace says to stand in the k-th panel, counted from 0."""
    return {"xaxis": f"x{_number(k)}", "yaxis": f"y{_number(k)}"}


def axis_key(name: str, k: int) -> str:
    """What the layout calls an axis, "x" or "y", of the k-th panel."""
    return f"{name}axis{_number(k)}"


def within(k: int, along: Literal["x", "y"]) -> dict[str, str]:
    """What a shape says to reach from edge to edge of the k-th panel, from 0 to 1 along an axis."""
    axes = {name: f"{name}{_number(k)}" for name in "xy"}
    return {f"{name}ref": f"{axis} domain" if name == along else axis for name, axis in axes.items()}


def axis_title(text: str | None) -> dict[str, Any]:
    """The title of an axis, at the distance of the house style; of None, no title."""
    return {"title": axis_style()["title"] | ({} if text is None else {"text": text})}


def image_axes(right: float, lower: float, **more: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Axes of a panel that shows an image to these edges, px, v downwards; `more` is the y axis's."""
    plain = {"showgrid": False, "zeroline": False}
    return {**plain, "range": [-0.5, right]}, {**plain, "range": [lower, -0.5], **more}


def domains(k: int, shape: tuple[int, int], gaps: tuple[float, float]) -> tuple[list[float], list[float]]:
    """From where to where the k-th panel goes, across and upwards, as shares of the whole."""
    row, column = divmod(k, shape[1])
    width, height = ((1 - gap * (n - 1)) / n for n, gap in zip(shape[::-1], gaps, strict=True))
    left, lower = column * (width + gaps[0]), (shape[0] - 1 - row) * (height + gaps[1])
    return [left, left + width], [lower, lower + height]


def _number(k: int) -> str:
    """Plotly counts axes from 1 and leaves the first number out."""
    return str(k + 1) if k else ""
