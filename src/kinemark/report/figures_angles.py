"""Curves of joint angles with their bands: through time, and over cycles."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from ..data import Angles
from ..data.array_types import Floats
from ..findings.plain import runs
from ..kinematics import Cycles, Model, NamedAngle, named_angles, outside
from .figures import ABOVE
from .theme import FAINT, HUES, axis_style, empty, figure, label

WIDE = 1.96
"""Standard deviations on each side that hold 95 %; by definition."""
MOST = 16_000
"""Most frames drawn of all curves of a page together, and 2000 of one; chosen (see benchmarks/pages.py)."""
MOST_CYCLES = 30
"""Drawn one by one beside their mean; chosen."""
BAD = "#B3261E"


def joint_figure(angles: Angles, model: Model, joint: int, *, first_frame: int = 1) -> go.Figure:
    """The degrees of freedom of one joint through time: curve, 95 % band, normal range, what is beyond it, lock."""
    free = [one for one in named_angles(model) if one.joint == joint]
    if not free or not np.isfinite(angles.deg[joint]).any():
        return empty("No frame has all markers of this joint.")
    fig = _rows(free)
    by = max(1, -(-angles.deg.shape[1] // min(2000, MOST // len(named_angles(model)))))
    time = (np.arange(angles.deg.shape[1]) + first_frame - 1) / angles.rate
    out, sd = outside(angles, model), angles.sd
    for row, (j, t, motion) in enumerate(free, 1):
        y, s = angles.deg[j, :, t], sd[j, :, t]
        if motion.normal is not None and motion.normal[0] < motion.normal[1]:
            _normal(fig, motion.normal, y, row)
        _band(fig, time[::by], (y - WIDE * s)[::by], (y + WIDE * s)[::by], HUES[0], row)
        _curve(fig, time[::by], y[::by], HUES[0], motion.name, row)
        bad = np.where(out[j, :, t], y, np.nan)
        if np.isfinite(bad).any():
            _curve(fig, time[::by], bad[::by], BAD, "beyond the normal range", row)
        for a, b in runs(angles.locked[j]):
            look = {"fillcolor": "#E69F00", "opacity": 0.25, "line_width": 0, "layer": "below"}
            fig.add_vrect(x0=time[a], x1=time[b - 1], **look, row=row, col=1)
        _limits(fig, y, s, row)
    return fig.update_xaxes(title_text="time (s)", row=len(free), col=1)


def cycle_figure(cycles: Cycles, model: Model, joint: int) -> go.Figure:
    """One joint over cycles: each faint, their mean, and the band of ± SD."""
    free = [one for one in named_angles(model) if one.joint == joint]
    if not free or not np.isfinite(cycles.mean[joint]).any():
        return empty("No cycle has all markers of this joint.")
    fig = _rows(free)
    percent = np.linspace(0, 100, cycles.mean.shape[1])
    for row, (j, t, motion) in enumerate(free, 1):
        mean, spread = cycles.mean[j, :, t], cycles.spread[j, :, t]
        _band(fig, percent, mean - spread, mean + spread, HUES[0], row)
        for k, one in enumerate(cycles.deg[:MOST_CYCLES, j, :, t]):
            turn = 360 * np.round(np.nanmean(one - mean) / 360) if np.isfinite(one - mean).any() else 0.0
            _curve(fig, percent, one - turn, FAINT, f"cycle {k + 1}", row, width=0.8)
        _curve(fig, percent, mean, HUES[0], f"{motion.name}, mean", row)
        _limits(fig, np.concatenate([mean, *cycles.deg[:, j, :, t]]), np.zeros(1), row)
    return fig.update_xaxes(title_text="cycle (%)", row=len(free), col=1)


def _rows(free: list[NamedAngle]) -> go.Figure:
    n = len(free)
    rows = make_subplots(rows=n, cols=1, shared_xaxes=True, vertical_spacing=0.06 if n > 1 else 0)
    style = figure(60 + 210 * n, margin={"l": 70, "r": 20, "t": 20, "b": 48}).layout
    fig = go.Figure(rows).update_layout({k: style[k] for k in style if not k.endswith("axis")})
    fig.update_layout(legend=ABOVE)
    for row, one in enumerate(free, 1):
        up, down = one.motion.positive, one.motion.negative
        lines = [f"{up} +", f"{down} −"] if down else [up]
        words = "<br>".join([*map(label, lines), "(deg)"])
        fig.update_yaxes(**axis_style() | {"title": {"text": words, "standoff": 8}}, row=row, col=1)
        fig.update_xaxes(**axis_style(), row=row, col=1)
    return fig


def _curve(fig: go.Figure, x: Floats, y: Floats, colour: str, name: str, row: int, *, width: float = 1.8) -> None:
    fig.add_scatter(
        x=x.astype(np.float32), y=y.astype(np.float32), mode="lines", line={"color": colour, "width": width},
        connectgaps=False, name=label(name), hovertemplate="%{x:.2f}: %{y:.1f}°", row=row, col=1,
    )  # fmt: skip


def _band(fig: go.Figure, x: Floats, low: Floats, high: Floats, colour: str, row: int) -> None:
    """Filled between two curves, run by run, so that a gap stays white."""
    for a, b in runs(np.isfinite(low) & np.isfinite(high)):
        xs, ys = np.concatenate([x[a:b], x[a:b][::-1]]), np.concatenate([high[a:b], low[a:b][::-1]])
        fig.add_scatter(
            x=xs.astype(np.float32), y=ys.astype(np.float32), mode="lines", fill="toself", line={"width": 0},
            fillcolor=f"rgba({int(colour[1:3], 16)},{int(colour[3:5], 16)},{int(colour[5:7], 16)},0.22)",
            hoverinfo="skip", row=row, col=1,
        )  # fmt: skip


def _normal(fig: go.Figure, normal: tuple[float, float], y: Floats, row: int) -> None:
    """The limits of normal motion, where the curve comes near them."""
    low, high = (float(f(y[np.isfinite(y)], initial=0.0)) for f in (np.min, np.max))
    for limit in normal:
        if low - 15 <= limit <= high + 15:
            line = {"color": BAD, "width": 1, "dash": "dot"}
            fig.add_hline(y=limit, line=line, row=row, col=1, exclude_empty_subplots=False)


def _limits(fig: go.Figure, y: Floats, sd: Floats, row: int) -> None:
    """An axis that no single uncertain frame stretches."""
    finite = np.isfinite(y)
    if not finite.any():
        return
    known = sd[np.isfinite(sd)]
    edge = 3 + WIDE * (float(np.quantile(known, 0.95)) if known.size else 0.0)
    span = float(np.ptp(y[finite]))
    edge = min(edge, 5 + span)
    fig.update_yaxes(range=[float(y[finite].min()) - edge, float(y[finite].max()) + edge], row=row, col=1)
