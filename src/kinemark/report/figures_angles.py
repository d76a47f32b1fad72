"""Curves of joint angles with their bands: through time, and over cycles."""

from __future__ import annotations

import numpy as np

from ..data import Angles
from ..data.array_types import Floats
from ..findings.plain import runs
from ..kinematics import Cycles, Model, NamedAngle, named_angles, outside
from .drawing import Figure
from .figures import ABOVE
from .panels import axis_key, axis_title, panel, panels, within
from .theme import FAINT, HUES, empty, label

WIDE = 1.96
"""Standard deviations on each side that hold 95 %; by definition."""
MOST = 16_000
"""Most frames drawn of all curves of a page together, and 2000 of one; chosen (see benchmarks/pages.py)."""
MOST_CYCLES = 30
"""Drawn one by one beside their mean; chosen."""
BAD = "#B3261E"


def joint_figure(angles: Angles, model: Model, joint: int, *, first_frame: int = 1) -> Figure:
    """The degrees of freedom of one joint through time: curve, 95 % band, normal range, what is beyond it, lock."""
    free = [one for one in named_angles(model) if one.joint == joint]
    if not free or not np.isfinite(angles.deg[joint]).any():
        return empty("No frame has all markers of this joint.")
    fig = _rows(free, "time (s)")
    by = max(1, -(-angles.deg.shape[1] // min(2000, MOST // len(named_angles(model)))))
    time = (np.arange(angles.deg.shape[1]) + first_frame - 1) / angles.rate
    out, sd = outside(angles, model), angles.sd
    for row, (j, t, motion) in enumerate(free):
        y, s = angles.deg[j, :, t], sd[j, :, t]
        if motion.normal is not None and motion.normal[0] < motion.normal[1]:
            _normal(fig, motion.normal, y, row)
        _band(fig, time[::by], (y - WIDE * s)[::by], (y + WIDE * s)[::by], HUES[0], row)
        _curve(fig, time[::by], y[::by], HUES[0], motion.name, row)
        bad = np.where(out[j, :, t], y, np.nan)
        if np.isfinite(bad).any():
            _curve(fig, time[::by], bad[::by], BAD, "beyond the normal range", row)
        for a, b in runs(angles.locked[j]):
            look = {"fillcolor": "#E69F00", "opacity": 0.25, "line": {"width": 0}, "layer": "below"}
            fig.shape(type="rect", x0=time[a], x1=time[b - 1], y0=0, y1=1, **within(row, "y"), **look)
        _limits(fig, y, s, row)
    return fig


def cycle_figure(cycles: Cycles, model: Model, joint: int) -> Figure:
    """One joint over cycles: each faint, their mean, and the band of ± SD."""
    free = [one for one in named_angles(model) if one.joint == joint]
    if not free or not np.isfinite(cycles.mean[joint]).any():
        return empty("No cycle has all markers of this joint.")
    fig = _rows(free, "cycle (%)")
    percent = np.linspace(0, 100, cycles.mean.shape[1])
    for row, (j, t, motion) in enumerate(free):
        mean, spread = cycles.mean[j, :, t], cycles.spread[j, :, t]
        _band(fig, percent, mean - spread, mean + spread, HUES[0], row)
        for k, one in enumerate(cycles.deg[:MOST_CYCLES, j, :, t]):
            turn = 360 * np.round(np.nanmean(one - mean) / 360) if np.isfinite(one - mean).any() else 0.0
            _curve(fig, percent, one - turn, FAINT, f"cycle {k + 1}", row, width=0.8)
        _curve(fig, percent, mean, HUES[0], f"{motion.name}, mean", row)
        _limits(fig, np.concatenate([mean, *cycles.deg[:, j, :, t]]), np.zeros(1), row)
    return fig


def _rows(free: list[NamedAngle], along: str) -> Figure:
    """A panel below another for each angle, without curves; `along` is what x is."""
    axes = []
    for row, one in enumerate(free, 1):
        up, down = one.motion.positive, one.motion.negative
        lines = [f"{up} +", f"{down} −"] if down else [up]
        words = "<br>".join([*map(label, lines), "(deg)"])
        axes.append((axis_title(along if row == len(free) else None), {"title": {"text": words, "standoff": 8}}))
    shape, margin = (len(free), 1), {"l": 70, "r": 20, "t": 20, "b": 48}
    return panels(60 + 210 * len(free), shape, axes, gaps=(0.0, 0.06), shared="x", margin=margin, legend=ABOVE)


def _curve(fig: Figure, x: Floats, y: Floats, colour: str, name: str, row: int, *, width: float = 1.8) -> None:
    fig.add(
        "scatter", x=x.astype(np.float32), y=y.astype(np.float32), mode="lines", line={"color": colour, "width": width},
        connectgaps=False, name=label(name), hovertemplate="%{x:.2f}: %{y:.1f}°", **panel(row),
    )  # fmt: skip


def _band(fig: Figure, x: Floats, low: Floats, high: Floats, colour: str, row: int) -> None:
    """Filled between two curves, run by run, so that a gap stays white."""
    for a, b in runs(np.isfinite(low) & np.isfinite(high)):
        xs, ys = np.concatenate([x[a:b], x[a:b][::-1]]), np.concatenate([high[a:b], low[a:b][::-1]])
        fig.add(
            "scatter", x=xs.astype(np.float32), y=ys.astype(np.float32), mode="lines", fill="toself", line={"width": 0},
            fillcolor=f"rgba({int(colour[1:3], 16)},{int(colour[3:5], 16)},{int(colour[5:7], 16)},0.22)",
            hoverinfo="skip", **panel(row),
        )  # fmt: skip


def _normal(fig: Figure, normal: tuple[float, float], y: Floats, row: int) -> None:
    """The limits of normal motion, where the curve comes near them."""
    low, high = (float(f(y[np.isfinite(y)], initial=0.0)) for f in (np.min, np.max))
    for limit in normal:
        if low - 15 <= limit <= high + 15:
            line = {"color": BAD, "width": 1, "dash": "dot"}
            fig.shape(type="line", x0=0, x1=1, y0=limit, y1=limit, line=line, **within(row, "x"))


def _limits(fig: Figure, y: Floats, sd: Floats, row: int) -> None:
    """An axis that no single uncertain frame stretches."""
    finite = np.isfinite(y)
    if not finite.any():
        return
    known = sd[np.isfinite(sd)]
    edge = 3 + WIDE * (float(np.quantile(known, 0.95)) if known.size else 0.0)
    span = float(np.ptp(y[finite]))
    edge = min(edge, 5 + span)
    reach = [float(y[finite].min()) - edge, float(y[finite].max()) + edge]
    fig.arrange(**{axis_key("y", row): {"range": reach}})
