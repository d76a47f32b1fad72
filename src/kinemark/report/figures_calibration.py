"""The figures of a calibration: how exact it is where, what it rests on, and what its lenses do."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from ..data import Rig
from ..data.array_types import Floats
from ..findings.cameras import upwards
from .drawing import Figure
from .formatting import number
from .panels import axis_title, panel, panels, within
from .scene3d import HOVER, draw_box, draw_camera, draw_floor, extent_of, stand_upright
from .theme import FAINT, HUES, camera_ticks, empty, even_scale, figure, hue, labels
from .thin import short

SLICES = 3  # heights of the volume that are drawn; chosen
SCALE = even_scale(
    "#00224e", "#123570", "#3b496c", "#575d6d", "#707173", "#8a8678", "#a59c74", "#c3b369", "#e1cc55", "#fee838"
)
"""The colours of Plotly's Cividis: light is uncertain; people with any colour vision read it alike."""
ABOVE = {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0}
MOST_BARS = 40  # drawn; chosen, so that names can be read
LOST_COLUMNS = 4  # panels side by side; chosen
LEAST_LOSS = 1.5
"""Up to which factor the colours reach at least, so that a small loss is not made to look large; chosen."""
NAMES = "xyz"
BELOW_TITLES = {"l": 60, "r": 20, "t": 40, "b": 48}
"""px about panels that have titles."""


def slices_figure(figures: dict[str, Any], up: int) -> Figure:
    """σ per axis on three level cuts through the volume, low, middle and high; blank where nothing is measured."""
    sd, axes = _volume(figures["map"], "sd_mm")
    if not np.isfinite(sd).any():
        return empty("No place of the volume is seen by two cameras.")
    cuts = np.unique(np.linspace(0, len(axes[up]) - 1, SLICES).round().astype(int))
    a, b = (axis for axis in range(3) if axis != up)
    titles = [f"{NAMES[up]} = {number(axes[up][k], 0)} mm" for k in cuts]
    written = [
        (axis_title(f"{NAMES[a]} (mm)"), axis_title(None if i else f"{NAMES[b]} (mm)")) for i in range(len(cuts))
    ]
    fig = panels(330, (1, len(cuts)), written, titles=titles, gaps=(0.06, 0.0), margin=BELOW_TITLES)
    for i, k in enumerate(cuts):
        cut = np.take(sd, k, axis=up)
        fig.add(
            "heatmap", z=_rounded(cut.T), x=axes[a], y=axes[b], coloraxis="coloraxis", **panel(i),
            hovertemplate=f"{NAMES[a]} %{{x:.0f}}, {NAMES[b]} %{{y:.0f}} mm<br>σ %{{z:.3g}} mm<extra></extra>",
        )  # fmt: skip
    low, high = _range(sd)
    bar = {"title": {"text": "σ (mm)"}, "thickness": 14}
    return fig.arrange(coloraxis={"colorscale": SCALE, "cmin": low, "cmax": high, "colorbar": bar})


def space_figure(figures: dict[str, Any], rig: Rig, points: Floats, *, called: str = "calibration points") -> Figure:
    """Cameras, the volume with σ at places in it, and points (N, 3) mm: those that the calibration was made from."""
    sd, axes = _volume(figures["map"], "sd_mm")
    corners = np.array(figures["volume"]["corners_mm"])
    extent, up = extent_of(rig.centres, corners, points[np.isfinite(points).all(1)]), upwards(rig)
    legend = {"orientation": "h", "y": 0, "yanchor": "top"}
    fig = figure(640, margin={"l": 0, "r": 0, "t": 36, "b": 20}, showlegend=True, legend=legend)
    draw_floor(fig, extent, up)
    draw_box(fig, corners)
    for c, (camera, name) in enumerate(zip(rig, labels(rig.names), strict=True)):
        draw_camera(fig, camera, hue(c), corners.mean(0), name=name)
    _cloud(fig, sd, axes)
    x, y, z = short(points[np.isfinite(points).all(1)].T)
    style = {"size": 3, "color": HUES[1]}
    fig.add("scatter3d", x=x, y=y, z=z, mode="markers", name=called, marker=style, hoverinfo="skip")
    return stand_upright(fig, up, corners, called="volume")


def _cloud(fig: Figure, sd: Floats, axes: list[Floats]) -> None:
    """Every second place along each axis, coloured by σ."""
    few = [np.arange(0, len(axis), 2) for axis in axes]
    at = np.stack(np.meshgrid(*(axis[k] for axis, k in zip(axes, few, strict=True)), indexing="ij"), -1).reshape(-1, 3)
    values = sd[np.ix_(*few)].reshape(-1)
    x, y, z = short(at[np.isfinite(values)].T)
    values = values[np.isfinite(values)]
    low, high = _range(sd)
    bar = {"title": {"text": "σ (mm)"}, "thickness": 14, "len": 0.7}
    fig.add(
        "scatter3d", x=x, y=y, z=z, mode="markers", name="σ at places of the volume", customdata=_rounded(values),
        marker={"size": 3.5, "opacity": 0.75, "color": _rounded(values), "colorscale": SCALE, "cmin": low, "cmax": high,
                "colorbar": bar},
        hovertemplate=f"σ %{{customdata:.3g}} mm<br>{HOVER}<extra></extra>",
    )  # fmt: skip


def fit_figure(cameras: list[dict[str, Any]]) -> Figure:
    """Two marks a camera: residual of the points it was fitted to, and error of those that took no part."""
    series = (("residual RMS", "residual_rms_px"), ("left out RMS", "left_out_rms_px"))
    if not any(c[key] is not None for c in cameras for _, key in series):
        return empty("The calibration says nothing of its residuals.")
    fig = figure(330, showlegend=True, legend=ABOVE)
    for i, (name, key) in enumerate(series):
        fig.add(
            "scatter",
            x=[c + (-0.1, 0.1)[i] for c in range(len(cameras))],
            y=[camera[key] for camera in cameras],
            mode="markers",
            marker={"color": HUES[i], "symbol": ("circle", "diamond")[i], "size": 10},
            name=name,
            hovertemplate="%{y:.3f} px",
        )
    fig.x_axes(**camera_ticks(cameras))
    return fig.y_axes(title={"text": "px"}, rangemode="tozero")


def loss_figure(figures: dict[str, Any]) -> Figure:
    """A mark a camera: the median σ of the volume without it, with all cameras as a line."""
    cameras, median = figures["cameras"], figures["precision"]["sd_median_mm"]
    if median is None or len(cameras) < 3:
        return empty("With two cameras nothing is left when one is lost.")
    fig = figure(330, showlegend=True, legend=ABOVE)
    for name, key, symbol, i in (("median", "sd_median_mm", "circle", 0), ("95 %", "sd_95_mm", "diamond", 1)):
        fig.add(
            "scatter", x=list(range(len(cameras))), y=[c["without"][key] for c in cameras], mode="markers",
            name=f"{name}, one lost",
            marker={"size": 10, "color": HUES[i], "symbol": symbol}, hovertemplate="%{y:.3g} mm",
        )  # fmt: skip
        level = figures["precision"][key]
        if level is not None:
            line = {"color": HUES[i], "dash": "dot", "width": 1.5}
            fig.shape(type="line", x0=0, x1=1, y0=level, y1=level, line=line, **within(0, "x"))
    fig.x_axes(**camera_ticks(cameras), title={"text": "camera that is lost"})
    return fig.y_axes(title={"text": "σ per axis (mm)"}, rangemode="tozero")


def lost_figure(figures: dict[str, Any]) -> Figure:
    """A level cut a camera: how many times as large σ is there without it; blank where nothing is measured then."""
    cameras, lost = figures["cameras"], figures["map"]["lost"]
    ratio = np.array(lost["without_sd_mm"], np.float64) / np.array(lost["sd_mm"], np.float64)
    if len(cameras) < 3 or not np.isfinite(ratio).any():
        return empty("With two cameras nothing is left when one is lost.")
    a, b = (axis for axis in range(3) if axis != lost["axis"])
    x, y = (figures["map"][f"{NAMES[axis]}_mm"] for axis in (a, b))
    rows, columns = -(-len(cameras) // LOST_COLUMNS), min(LOST_COLUMNS, len(cameras))
    titles = [f"without {name}" for name in labels(camera["name"] for camera in cameras)]
    axes = [
        (
            axis_title(f"{NAMES[a]} (mm)" if c + columns >= len(cameras) else None),
            axis_title(f"{NAMES[b]} (mm)" if c % columns == 0 else None),
        )
        for c in range(len(cameras))
    ]
    gaps = (0.05, 0.3 / rows)
    fig = panels(70 + 210 * rows, (rows, columns), axes, titles=titles, gaps=gaps, margin=BELOW_TITLES)
    for c in range(len(cameras)):
        fig.add(
            "heatmap", z=_rounded(ratio[c].T), x=x, y=y, coloraxis="coloraxis", **panel(c),
            hovertemplate=f"{NAMES[a]} %{{x:.0f}}, {NAMES[b]} %{{y:.0f}} mm<br>× %{{z:.3g}}<extra></extra>",
        )  # fmt: skip
    high = max(float(np.nanquantile(ratio, 0.98)), LEAST_LOSS)
    bar = {"title": {"text": "times<br>as large"}, "thickness": 14}
    return fig.arrange(coloraxis={"colorscale": SCALE, "cmin": 1.0, "cmax": high, "colorbar": bar})


def points_figure(points: list[dict[str, Any]]) -> Figure:
    """A place a control point, the largest residual first: its residual and its error when left out."""
    if not points:
        return empty("This calibration was made without surveyed points.")
    shown = points[:MOST_BARS]
    fig = figure(330, showlegend=True, legend=ABOVE)
    for i, (name, key) in enumerate((("residual RMS", "residual_rms_px"), ("left out RMS", "left_out_rms_px"))):
        fig.add(
            "scatter", x=list(range(len(shown))), y=[p[key] for p in shown], mode="markers", name=name,
            marker={"size": 9, "color": HUES[i], "symbol": ("circle", "diamond")[i]}, hovertemplate="%{y:.3f} px",
        )  # fmt: skip
    names = labels(p["name"] for p in shown)
    fig.x_axes(tickvals=list(range(len(names))), ticktext=names, ticks="", tickfont={"size": 11}, tickangle=-60)
    return fig.y_axes(title={"text": "px over all cameras"}, rangemode="tozero")


def wand_figure(wand: dict[str, Any] | None) -> Figure:
    """Error of the wand's length against x, y and z, a dot a pose, with the mean in each third of the volume."""
    if not wand or not wand["samples"]["place_mm"]:
        return empty("This calibration was made without a wand.")
    place, error = np.array(wand["samples"]["place_mm"]), np.array(wand["samples"]["error_mm"])
    axes = [
        (axis_title(f"{NAMES[axis]} of the wand (mm)"), axis_title(None if axis else "length error (mm)"))
        for axis in range(3)
    ]
    fig = panels(330, (1, 3), axes, gaps=(0.04, 0.0), shared="y")
    dot = {"color": HUES[0], "size": 4, "opacity": 0.5}
    for axis in range(3):
        fig.add(
            "scatter", x=short(place[:, axis]), y=error.astype(np.float32), mode="markers", marker=dot,
            hovertemplate="%{y:.2f} mm<extra></extra>", **panel(axis),
        )  # fmt: skip
        edges = np.quantile(place[:, axis], [0, 1 / 3, 2 / 3, 1])
        for low, high in itertools.pairwise(edges):
            mean = float(error[(place[:, axis] >= low) & (place[:, axis] <= high)].mean())
            line = {"color": HUES[1], "width": 3}
            fig.add("scatter", x=[low, high], y=[mean, mean], mode="lines", line=line, hoverinfo="skip", **panel(axis))
    return fig


def lens_figure(cameras: list[dict[str, Any]]) -> Figure:
    """How far each lens moves a point, from the image's middle to its farthest corner."""
    if not any(any(c["distortion"]) for c in cameras):
        return empty("No lens is corrected.")
    fig = figure(330, showlegend=True)
    names = labels(camera["name"] for camera in cameras)
    for c, camera in enumerate(cameras):
        fig.add(
            "scatter", x=camera["bend"]["from_centre_px"], y=camera["bend"]["moved_px"], mode="lines", name=names[c],
            line={"color": hue(c), "width": 2}, hovertemplate="%{x:.0f} px: %{y:.2f} px",
        )  # fmt: skip
    fig.x_axes(title={"text": "distance from the principal point (px)"})
    return fig.y_axes(title={"text": "moved outwards (px)"}, zerolinecolor=FAINT)


def _range(sd: Floats) -> tuple[float, float]:
    """From where to where the colours go: nearly all values, and never so little that nothing is made to look much."""
    if not np.isfinite(sd).any():
        return 0.0, 1.0
    low, high = np.nanquantile(sd, [0.02, 0.98])
    return float(min(low, high / 1.5)), float(high)


def _volume(grid: dict[str, Any], key: str) -> tuple[Floats, list[Floats]]:
    """Values (X, Y, Z), NaN where unknown, and the three axes, mm."""
    return np.array(grid[key], np.float64), [np.array(grid[f"{a}_mm"], np.float64) for a in NAMES]


def _rounded(values: Floats) -> Floats:
    return values.astype(np.float32)
