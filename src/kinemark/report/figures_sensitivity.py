"""The figures of what limits a recording: ranked sources, what averaging brings, markers, angles, cameras, images."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..data import Rig
from ..data.array_types import Floats
from ..sensitivity import Ranking
from .drawing import Figure
from .panels import axis_title, image_axes, panel, panels
from .theme import FAINT, HUES, empty, figure, label, labels
from .thin import MOST_MARKERS

ABOVE = {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0}
UNITS = {"mm": "σ of a marker per axis (mm)", "deg": "σ of an angle (°)"}
COLOURS = {
    "marker placement": HUES[3],
    "centroid noise": HUES[0],
    "calibration": HUES[1],
    "lens model": HUES[2],
    "disturbed images": HUES[4],
}
COLUMNS = 4  # pictures side by side; chosen
ARROW = 0.16
"""Longest arrow, as a share of the image's width; chosen."""


def ranked_figure(figures: dict[str, Any]) -> Figure:
    """A row a source, the greatest at the top, and the loss of the camera most missed; one frame, and a mean."""
    unit, rows = figures["ranked_by"], list(figures["ranking"])
    if figures["lost"] and figures["lost"][0][f"cost_{unit}"] is not None:
        first = figures["lost"][0]
        cost = first[f"cost_{unit}"]
        rows.append({"source": f"if {label(first['camera'])} were lost", unit: cost, f"mean_{unit}": None})
    rows.sort(key=lambda row: row[unit] or 0.0)
    fig = figure(110 + 46 * len(rows), showlegend=True, legend=ABOVE, margin={"l": 150, "t": 44, "r": 30, "b": 48})
    names = [row["source"] for row in rows]
    for key, title, colour, symbol in (
        (unit, "a single frame", HUES[0], "circle"),
        (f"mean_{unit}", f"a mean over {figures['cycles']} cycles", HUES[1], "diamond"),
    ):
        fig.add(
            "scatter", x=[row[key] for row in rows], y=names, mode="markers+text", name=title,
            text=[f"{row[key]:.2g}" if row[key] and key == unit else "" for row in rows], textposition="middle right",
            marker={"size": 12, "color": colour, "symbol": symbol}, hovertemplate="%{y}: %{x:.3g}<extra></extra>",
        )  # fmt: skip
    for row in rows:
        if row[unit] is not None:
            line = {"color": "#C9D1D8", "width": 6}
            fig.shape(type="line", x0=0, x1=row[unit], y0=row["source"], y1=row["source"], line=line, layer="below")
    fig.x_axes(title={"text": UNITS[unit]}, rangemode="tozero")
    return fig.y_axes(ticks="", showgrid=False)


def cycles_figure(figures: dict[str, Any]) -> Figure:
    """All sources, and those of the cameras, against the number of cycles; dotted what no averaging takes away."""
    unit = figures["ranked_by"]
    rows = figures["by_cycles"]
    fig = figure(340, showlegend=True, legend=ABOVE, margin={"l": 60, "r": 20, "t": 44, "b": 48})
    fixed = [row for row in figures["ranking"] if not row["averages"] and row[unit]]
    for i, (name, key, left_out) in enumerate(
        (("all sources", unit, ""), ("without the placement of markers", f"cameras_{unit}", "marker placement"))
    ):
        floor = float(np.sqrt(sum(row[unit] ** 2 for row in fixed if row["source"] != left_out)))
        fig.add(
            "scatter", x=[row["cycles"] for row in rows], y=[row[key] for row in rows], mode="lines+markers", name=name,
            line={"color": HUES[i], "width": 2}, marker={"size": 8, "symbol": ("circle", "diamond")[i]},
            hovertemplate="%{x} cycles: %{y:.3g}<extra></extra>",
        )  # fmt: skip
        line = {"color": HUES[i], "width": 1.5, "dash": "dot"}
        fig.add(
            "scatter",
            x=[1, rows[-1]["cycles"]], y=[floor, floor], mode="lines", name="what no averaging takes away", line=line,
            hoverinfo="skip", showlegend=False,
        )  # fmt: skip
    fig.x_axes(title={"text": "cycles in the mean"})
    return fig.y_axes(title={"text": UNITS[unit]}, type="log", dtick=0.30103, tickformat=".2~g")


def marker_figure(figures: dict[str, Any]) -> Figure:
    """A place a marker: each source that cameras are to blame for, mm."""
    return _places(figures["by_marker"], "marker", UNITS["mm"], [n for n in COLOURS if n != "marker placement"])


def angle_figure(figures: dict[str, Any]) -> Figure:
    """A place an angle or segment: each source, degrees, on a logarithmic scale."""
    if not figures["by_angle"]:
        return empty("No two markers keep their distance, and no model was named: there are no angles.")
    fig = _places(figures["by_angle"], "angle", UNITS["deg"], list(COLOURS))
    return fig.y_axes(type="log", rangemode="normal", dtick=1, minor={"showgrid": True, "gridcolor": "#F2F4F6"})


def _places(rows: list[dict[str, Any]], key: str, title: str, sources: list[str]) -> Figure:
    fig = figure(400, showlegend=True, legend=ABOVE, margin={"l": 60, "r": 20, "t": 44, "b": 48})
    if len(rows) > MOST_MARKERS:  # the largest
        rows = sorted(rows, key=lambda row: -max(row[source] or 0.0 for source in sources))[:MOST_MARKERS]
    for source in sources:
        fig.add(
            "scatter", x=list(range(len(rows))), y=[row[source] or None for row in rows], mode="markers", name=source,
            marker={"size": 8, "color": COLOURS[source]}, hovertemplate="%{x}: %{y:.3g}",
        )  # fmt: skip
    names = labels(row[key] for row in rows)
    fig.x_axes(tickvals=list(range(len(names))), ticktext=names, ticks="", tickfont={"size": 11}, tickangle=-60)
    return fig.y_axes(title={"text": title}, rangemode="tozero")


def loss_figure(figures: dict[str, Any]) -> Figure:
    """A place a camera: what the cameras' part becomes without it, at the points that are left, and the points gone."""
    lost = figures["lost"]
    if not lost:
        return empty("With two cameras nothing is left when one is lost.")
    rows = sorted(lost, key=lambda row: (len(row["camera"]), row["camera"]))
    x, names = list(range(len(rows))), labels(row["camera"] for row in rows)
    across = {"tickvals": x, "ticktext": names, "range": [-0.6, len(rows) - 0.4], "ticks": ""}
    across |= axis_title("camera that is lost")
    axes = [(across, {"rangemode": "tozero", **axis_title(title)}) for title in ("σ per axis (mm)", "points gone (%)")]
    margin = {"l": 60, "r": 20, "t": 44, "b": 60}
    fig = panels(330, (1, 2), axes, gaps=(0.12, 0.0), showlegend=True, legend=ABOVE, margin=margin)
    for name, key, symbol, i in (("without it", "mm", "circle", 1), ("with it", "all_mm", "diamond", 0)):
        fig.add(
            "scatter", x=x, y=[row[key] for row in rows], mode="markers", name=name, hovertemplate="%{y:.3g} mm",
            marker={"size": 10, "color": HUES[i], "symbol": symbol}, **panel(0),
        )  # fmt: skip
    fig.add(
        "scatter",
        x=x, y=[100 * row["gone_share"] for row in rows], mode="markers", name="points gone", showlegend=False,
        marker={"size": 10, "color": HUES[6]}, hovertemplate="%{y:.1f} %<extra></extra>", **panel(1),
    )  # fmt: skip
    return fig


def field_figure(ranking: Ranking, rig: Rig) -> Figure:
    """A panel a camera: the mean residual of each part of its image as a line, much enlarged."""
    cells, edges = ranking.evidence.cells, ranking.evidence.edges
    size = np.linalg.norm(cells, axis=-1)
    if not np.isfinite(size).any():
        return empty("No marker is seen by three cameras, so that residuals say nothing.")
    columns, rows = min(COLUMNS, len(rig)), -(-len(rig) // COLUMNS)
    scale = _enlargement(float(np.nanquantile(size, 0.95)), float(np.median(edges[:, 1, 0] - edges[:, 0, 0])))
    titles = labels(rig.names)
    sizes = [camera.size if (camera.size > 0).all() else edges[c, 1] for c, camera in enumerate(rig)]
    fig = panels(
        90 + 210 * rows, (rows, columns), [image_axes(float(width), float(height)) for width, height in sizes],
        titles=titles, gaps=(0.05, 0.28 / rows), margin={"l": 50, "r": 20, "t": 40, "b": 66},
    )  # fmt: skip
    for c in range(len(rig)):
        _arrows(fig, cells[c], edges[c], scale, panel(c))
    return fig.annotate(
        text=f"drawn {scale:,.0f} times as long", showarrow=False, x=1, y=0, xref="paper", yref="paper", yshift=-50,
        xanchor="right", font={"color": FAINT, "size": 12},
    )  # fmt: skip


def _arrows(fig: Figure, cells: Floats, edges: Floats, scale: float, place: dict[str, str]) -> None:
    nu, nv = cells.shape[:2]
    step = (edges[1] - edges[0]) / (nu, nv)
    at = edges[0] + (np.stack(np.meshgrid(np.arange(nu), np.arange(nv), indexing="ij"), -1) + 0.5) * step
    a, off = at.reshape(-1, 2), cells.reshape(-1, 2)
    known = np.isfinite(off).all(1)
    line = np.stack([a[known], a[known] + scale * off[known], np.full_like(a[known], np.nan)], 1).reshape(-1, 2)
    style = {"color": HUES[1], "width": 1.6}
    fig.add(
        "scatter",
        x=line[:, 0].astype(np.float32), y=line[:, 1].astype(np.float32), mode="lines", line=style, hoverinfo="skip",
        **place,
    )  # fmt: skip
    text = [f"{np.linalg.norm(o):.3f} px" for o in off[known]]
    x, y = a[known].T.astype(np.float32)
    dot = {"size": 4, "color": HUES[1]}
    fig.add("scatter", x=x, y=y, mode="markers", marker=dot, text=text, hovertemplate="%{text}<extra></extra>", **place)


def _enlargement(length: float, width: float) -> float:
    """A round factor that makes lengths visible."""
    factor = ARROW * width / max(length, 1e-6)
    power = 10.0 ** np.floor(np.log10(factor))
    return float(power * max(k for k in (1, 2, 5) if k * power <= factor))
