"""The figures of the markers: where each was seen, how it moved and how exactly it is known."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..data import Origin, Trajectories
from ..findings.markers import sample_deviation
from ..numerics.row_quantiles import row_quantiles
from .drawing import Figure
from .panels import axis_title, panel, panels
from .theme import HUES, STATES, empty, figure, hue, labels
from .thin import MOST_MARKERS, blocks, fullest, short, thinned

SAMPLES = 24_000
"""Most samples in the figure of trajectories, all markers and axes together; chosen (see benchmarks/pages.py)."""
COLUMNS = 600
"""Most columns in the timeline; chosen (see benchmarks/pages.py)."""
QUANTILES = 600
"""Most samples of a line of the uncertainty; chosen (see benchmarks/pages.py)."""

ABOVE = {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0}
NO_MARKERS = "There are no trajectories to draw."


def trajectories_figure(trajectories: Trajectories) -> Figure:
    """x, y, z against time, one line a marker, broken at gaps; the legend shows and hides markers."""
    if not trajectories.n_frames:
        return empty(NO_MARKERS)
    trajectories, _ = fullest(trajectories)
    names = labels(trajectories.names)
    axes = [(axis_title("time (s)" if name == "z" else None), axis_title(f"{name} (mm)")) for name in "xyz"]
    margin = {"l": 60, "r": 20, "t": 44, "b": 48}
    fig = panels(720, (3, 1), axes, gaps=(0.0, 0.03), shared="x", showlegend=True, margin=margin)
    most = SAMPLES // (3 * max(len(trajectories), 1))
    single = "lines+markers" if trajectories.n_frames == 1 else "lines"
    for m, path in enumerate(trajectories):
        for axis in range(3):
            curve = thinned(path.xyz[:, axis], most)
            fig.add(
                "scatter", **curve.at(trajectories.rate), y=short(curve.values), mode=single,
                line={"color": hue(m), "width": 1.5}, connectgaps=False, name=names[m],
                legendgroup=str(m), showlegend=axis == 0, **panel(axis),
                hovertemplate="%{x:.3f} s: %{y:.1f} mm",
            )  # fmt: skip
    return fig.arrange(updatemenus=[_all_or_none()])


def _all_or_none() -> dict[str, Any]:
    buttons = [
        {"label": "show all", "method": "restyle", "args": [{"visible": True}]},
        {"label": "hide all", "method": "restyle", "args": [{"visible": "legendonly"}]},
    ]
    place = {"x": 0, "y": 1.01, "xanchor": "left", "yanchor": "bottom", "pad": {"t": 0, "b": 4}}
    return {"type": "buttons", "direction": "right", "showactive": False, "buttons": buttons, **place}


def timeline_figure(trajectories: Trajectories) -> Figure:
    """A row a marker, the least complete at the top: measured, filled, edited or missing through time.

    Where a column stands for several frames it shows the least certain of them, so that no gap is hidden.
    """
    if not trajectories.n_frames:
        return empty(NO_MARKERS)
    trajectories, _ = fullest(trajectories)
    measured_first = np.array([Origin.MEASURED, Origin.EDITED, Origin.FILLED, Origin.MISSING])
    rank = np.argsort(measured_first)[np.array([path.origin for path in trajectories])]
    state = measured_first[np.asarray(blocks(rank, COLUMNS)).max(-1)]
    order = np.argsort([(path.origin != Origin.MISSING).sum() for path in trajectories], kind="stable")[::-1]
    called = labels(trajectories.names)
    names = [called[m] for m in order]
    k = -(-trajectories.n_frames // state.shape[1])
    fig = figure(110 + 17 * len(trajectories), margin={"l": 110, "t": 40})
    fig.add(
        "heatmap",
        z=state[order].astype(np.uint8), x0=0, dx=k / trajectories.rate, y0=0, dy=1, zmin=-0.5, zmax=3.5, ygap=2,
        colorscale=_steps(), showscale=False, hovertemplate="%{y}: %{x:.2f} s<extra></extra>",
    )  # fmt: skip
    for name, colour in STATES.items():
        style = {"color": colour, "symbol": "square", "size": 11}
        fig.add("scatter", x=[None], y=[None], mode="markers", marker=style, name=name, showlegend=True)
    fig.y_axes(tickvals=list(range(len(names))), ticktext=names, ticks="", showgrid=False, tickfont={"size": 11})
    fig.x_axes(title={"text": "time (s)"}, showgrid=False)
    return fig.arrange(showlegend=True, legend=ABOVE)


def _steps() -> list[list[Any]]:
    """A colour scale with one flat step for each `Origin`."""
    colours = list(STATES.values())
    return [[(i + j) / len(colours), colour] for i, colour in enumerate(colours) for j in (0, 1)]


def uncertainty_figure(trajectories: Trajectories) -> Figure:
    """Standard deviation of one axis through time: the median marker and the band that holds nine of ten markers."""
    sd = np.array([sample_deviation(path) for path in trajectories]).reshape(len(trajectories), trajectories.n_frames)
    known = np.isfinite(sd).any(0)
    if not known.any():
        return empty("The uncertainty of the positions is not known.")
    low, median, high = np.full((3, sd.shape[1]), np.nan)
    low[known], median[known], high[known] = (row_quantiles(sd[:, known].T, share) for share in (0.05, 0.5, 0.95))
    fig = figure(320, showlegend=True, legend=ABOVE)
    for values, name, colour in ((high, "95 %", HUES[5]), (median, "median", HUES[0]), (low, "5 %", HUES[5])):
        curve = thinned(values, QUANTILES)
        fig.add(
            "scatter", **curve.at(trajectories.rate), y=curve.values.astype(np.float32), name=name, connectgaps=False,
            mode="lines" if len(values) > 1 else "markers", line={"color": colour, "width": 1.6},
            hovertemplate="%{x:.3f} s: %{y:.2f} mm",
        )  # fmt: skip
    fig.y_axes(title={"text": "σ per axis (mm)"}, range=[0, 1.1 * float(np.nanquantile(high, 0.99))])
    return fig.x_axes(title={"text": "time (s)"})


def exactness_figure(markers: list[dict[str, Any]]) -> Figure:
    """A place a marker, in the trial's order: the predicted standard deviation and the observed jitter."""
    if len(markers) > MOST_MARKERS:
        markers = sorted(markers, key=lambda marker: -int(marker["samples"]))[:MOST_MARKERS]
    series = (("predicted σ (covariance)", "sd_per_axis_mean_mm"), ("observed jitter", "jitter_mm"))
    if not any(marker[key] is not None for marker in markers for _, key in series):
        return empty("Neither covariance nor jitter of the markers is known.")
    fig = figure(360, showlegend=True, legend=ABOVE)
    for i, (name, key) in enumerate(series):
        fig.add(
            "scatter",
            x=list(range(len(markers))),
            y=[marker[key] for marker in markers],
            mode="markers",
            marker={"color": HUES[i], "symbol": ("circle", "diamond")[i], "size": 9},
            name=name,
            hovertemplate="%{x}: %{y:.2f} mm",
        )
    names = labels(marker["name"] for marker in markers)
    fig.x_axes(tickvals=list(range(len(names))), ticktext=names, ticks="", tickfont={"size": 11}, tickangle=-60)
    return fig.y_axes(title={"text": "mm per axis"}, rangemode="tozero")
