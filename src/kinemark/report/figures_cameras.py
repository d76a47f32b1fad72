"""The figures of the cameras, of the points they make together and of the time it took."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..data import Detections
from .drawing import Figure
from .formatting import number, percent
from .theme import FAINT, HUES, INK, camera_ticks, empty, figure, hue, labels
from .thin import blocks

COLUMNS = 400
"""Most samples of one camera's line; chosen (see benchmarks/pages.py)."""


def residual_figure(cameras: list[dict[str, Any]]) -> Figure:
    """A box a camera: quartiles and median, whiskers to 5 and 95 %, a diamond at the RMS."""
    shown = [(c, camera) for c, camera in enumerate(cameras) if camera["residual_median_px"] is not None]
    if not shown:
        return empty("No camera's detections were used in a point, so there are no residuals.")
    fig = figure(360)
    names = labels(camera["name"] for camera in cameras)
    for c, camera in shown:
        low, q1, median, q3, high = ([value] for value in camera["residual_quantiles_px"])
        fig.add(
            "box", x=[c], q1=q1, median=median, q3=q3, lowerfence=low, upperfence=high, name=names[c],
            line={"color": hue(c), "width": 2}, width=0.5,
        )  # fmt: skip
    fig.add(
        "scatter", x=[c for c, _ in shown], y=[camera["residual_rms_px"] for _, camera in shown], mode="markers",
        marker={"symbol": "diamond", "size": 9, "color": INK}, hovertemplate="RMS %{y:.2f} px<extra></extra>",
    )  # fmt: skip
    fig.x_axes(**camera_ticks(cameras))
    return fig.y_axes(title={"text": "residual (px)"}, rangemode="tozero")


def offset_figure(cameras: list[dict[str, Any]]) -> Figure:
    """Two marks a camera: the median of detection minus reprojection along u and v."""
    if not any(camera["offset_px"][0] is not None for camera in cameras):
        return empty("No camera's detections were used in a point, so there are no offsets.")
    fig = figure(360, showlegend=True, legend={"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0})
    for i, name in enumerate(("u, to the right", "v, down")):
        fig.add(
            "scatter",
            x=[c + (-0.12, 0.12)[i] for c in range(len(cameras))],
            y=[camera["offset_px"][i] for camera in cameras],
            mode="markers",
            marker={"color": HUES[i], "symbol": ("circle", "diamond")[i], "size": 9},
            name=name,
            hovertemplate="%{y:.2f} px",
        )
    reach = 1.2 * max(0.4, *(abs(value) for camera in cameras for value in camera["offset_px"] if value is not None))
    fig.x_axes(**camera_ticks(cameras))
    return fig.y_axes(title={"text": "offset (px)"}, range=[-reach, reach], zerolinecolor=FAINT)


def detections_figure(detections: Detections) -> Figure:
    """Detections a frame through time, a line a camera; in long trials each point is the mean of several frames."""
    if not detections.n_frames or not detections.cameras:
        return empty("There are no frames to draw.")
    mean = np.asarray(blocks(detections.counts.astype(float), COLUMNS)).mean(-1)
    k = -(-detections.n_frames // mean.shape[1])
    fig = figure(340, showlegend=True)
    for c, name in enumerate(labels(detections.cameras)):
        style = {"color": hue(c), "width": 1.6}
        mode = "lines" if mean.shape[1] > 1 else "markers"
        fig.add(
            "scatter", x0=0, dx=k / detections.rate, y=mean[c].astype(np.float32), mode=mode, line=style, name=name,
            hovertemplate="%{x:.2f} s: %{y:.1f}",
        )  # fmt: skip
    fig.x_axes(title={"text": "time (s)"})
    return fig.y_axes(title={"text": "detections per frame"}, rangemode="tozero")


def views_figure(points: dict[str, Any]) -> Figure:
    """How many points rest on how many cameras."""
    if not points["count"]:
        return empty("No 3D point was reconstructed.")
    number_of = [int(n) for n in points["cameras_per_point"]]
    count = list(points["cameras_per_point"].values())
    fig = figure(320)
    fig.add(
        "bar", x=number_of, y=count, text=[percent(k / points["count"]) for k in count], textposition="outside",
        marker={"color": [HUES[1] if n < 3 else HUES[0] for n in number_of]}, cliponaxis=False,
        hovertemplate="%{x} cameras: %{y} points<extra></extra>", width=0.7,
    )  # fmt: skip
    fig.x_axes(title={"text": "cameras that see the point"}, dtick=1)
    return fig.y_axes(title={"text": "points"}, rangemode="tozero")


def timing_figure(timing: dict[str, Any]) -> Figure:
    """A bar a stage, in the order in which they ran."""
    stages = timing["stages"]
    if not stages:
        return empty("The steps were not timed.")
    fig = figure(90 + 34 * len(stages), margin={"l": 110, "r": 150})
    fig.add(
        "bar",
        y=list(range(len(stages))), x=[stage["time_s"] for stage in stages], orientation="h", marker={"color": HUES[0]},
        text=[_duration_text(stage) for stage in stages], textposition="outside", cliponaxis=False, hoverinfo="skip",
    )  # fmt: skip
    names = labels(stage["stage"] for stage in stages)
    fig.y_axes(tickvals=list(range(len(names))), ticktext=names, autorange="reversed", ticks="", showgrid=False)
    return fig.x_axes(title={"text": "time (s)"}, rangemode="tozero")


def _duration_text(stage: dict[str, Any]) -> str:
    pace = f", {number(stage['frames_per_s'], 0)} frames/s" if stage["frames_per_s"] is not None else ""
    return f"{number(stage['time_s'], 2)} s{pace}"
