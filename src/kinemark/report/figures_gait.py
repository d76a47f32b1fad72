"""Gait curves as clinicians lay them out: pelvis, hip, knee, ankle and foot in three planes; moments and powers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from ..data.array_types import Floats
from ..data.gait_curves import GaitCurves
from ..findings.plain import runs
from .theme import axis_style, empty, figure, label

SIDE_COLOURS = {"left": "#C62828", "right": "#0072B2"}
"""Left red, right blue; conventional in gait reports, and told apart by all."""
PERCENT = np.linspace(0, 100, 101)
"""Of a stride, at its 101 points; conventional."""


class Panel(NamedTuple):
    """One drawing: what it is called, which quantity and component, and what is up and down."""

    title: str
    name: str
    axis: int
    up: str
    down: str


KINEMATICS = (
    Panel("Pelvic tilt", "PelvisAngles", 0, "forward", "back"),
    Panel("Pelvic obliquity", "PelvisAngles", 1, "up", "down"),
    Panel("Pelvic rotation", "PelvisAngles", 2, "forward", "back"),
    Panel("Hip flexion", "HipAngles", 0, "flexion", "extension"),
    Panel("Hip adduction", "HipAngles", 1, "adduction", "abduction"),
    Panel("Hip rotation", "HipAngles", 2, "internal", "external"),
    Panel("Knee flexion", "KneeAngles", 0, "flexion", "extension"),
    Panel("Knee adduction", "KneeAngles", 1, "varus", "valgus"),
    Panel("Knee rotation", "KneeAngles", 2, "internal", "external"),
    Panel("Ankle dorsiflexion", "AnkleAngles", 0, "dorsiflexion", "plantarflexion"),
    Panel("Ankle rotation", "AnkleAngles", 2, "internal", "external"),
    Panel("Foot progression", "FootProgressAngles", 1, "internal", "external"),
)
"""Rows of three, from the pelvis to the foot."""
KINETICS = (
    Panel("Hip extension moment", "HipMoment", 0, "extensors", "flexors"),
    Panel("Knee extension moment", "KneeMoment", 0, "extensors", "flexors"),
    Panel("Ankle plantarflexion moment", "AnkleMoment", 0, "plantarflexors", "dorsiflexors"),
    Panel("Hip abduction moment", "HipMoment", 1, "", ""),
    Panel("Knee abduction moment", "KneeMoment", 1, "", ""),
    Panel("Vertical ground reaction", "GroundReactionForce", 2, "", ""),
    Panel("Hip power", "HipPower", 0, "generated", "absorbed"),
    Panel("Knee power", "KneePower", 0, "generated", "absorbed"),
    Panel("Ankle power", "AnklePower", 0, "generated", "absorbed"),
)
"""The same of loads."""


def panels_figure(curves: Sequence[GaitCurves], panels: Sequence[Panel]) -> go.Figure:
    """Mean of each side, its spread as a band, the measurement's SD as thin lines, foot off as dotted uprights."""
    known = [panel for panel in panels if _of(curves, panel)]
    if not known:
        return empty("There is nothing to draw: no stride has these quantities.")
    rows = -(-len(panels) // 3)
    fig = make_subplots(
        rows=rows, cols=3, subplot_titles=[label(p.title) for p in panels], vertical_spacing=0.3 / rows,
        horizontal_spacing=0.085,
    )  # fmt: skip
    style = figure(60 + 190 * rows, margin={"l": 62, "r": 16, "t": 40, "b": 44}).layout
    fig.update_layout({k: style[k] for k in style if not k.endswith("axis")})
    fig.update_annotations(font_size=12)
    for i, panel in enumerate(panels):
        place = {"row": i // 3 + 1, "col": i % 3 + 1}
        for one in _of(curves, panel):
            _draw(fig, one, panel, place)
        unit = next((one.unit for one in _of(curves, panel)), "")
        words = f"{panel.up} +<br>({unit})" if panel.up else f"({unit})"
        fig.update_yaxes(**axis_style() | {"title": {"text": words, "standoff": 4, "font": {"size": 11}}}, **place)
        last = i // 3 + 1 == rows
        fig.update_xaxes(
            **axis_style() | {"range": [0, 100], "title": {"text": "stride (%)" if last else None}}, **place
        )
    return fig.update_layout(showlegend=False)


def _of(curves: Sequence[GaitCurves], panel: Panel) -> list[GaitCurves]:
    """The curves of both sides that a panel shows, where they have values."""
    return [
        one for one in curves
        if one.name[1:] == panel.name and panel.axis < len(one.axes) and np.isfinite(one.mean[:, panel.axis]).any()
    ]  # fmt: skip


def _draw(fig: go.Figure, one: GaitCurves, panel: Panel, place: dict[str, int]) -> None:
    colour = SIDE_COLOURS[one.side]
    mean, spread, sd = (part[:, panel.axis] for part in (one.mean, one.spread, one.measurement_sd))
    _band(fig, mean - spread, mean + spread, colour, place)
    for edge in (mean - sd, mean + sd):
        _line(fig, edge, colour, "", place, width=0.7, dash="dot")
    _line(fig, mean, colour, f"{one.side}, mean of {len(one.values)}", place)
    off = one.foot_off[np.isfinite(one.foot_off)]
    if len(off):
        fig.add_vline(x=float(off.mean()), line={"color": colour, "width": 0.8, "dash": "dash"}, **place)


def _line(
    fig: go.Figure, y: Floats, colour: str, name: str, place: dict[str, int], *, width: float = 1.8, dash: str = "solid"
) -> None:
    fig.add_scatter(
        x=PERCENT.astype(np.float32), y=y.astype(np.float32), mode="lines", name=name, connectgaps=False,
        line={"color": colour, "width": width, "dash": dash}, hovertemplate="%{x:.0f} %: %{y:.2f}" if name else None,
        hoverinfo=None if name else "skip", **place,
    )  # fmt: skip


def _band(fig: go.Figure, low: Floats, high: Floats, colour: str, place: dict[str, int]) -> None:
    """Filled between two curves, run by run, so that what is missing stays empty."""
    for a, b in runs(np.isfinite(low) & np.isfinite(high)):
        x, y = np.concatenate([PERCENT[a:b], PERCENT[a:b][::-1]]), np.concatenate([high[a:b], low[a:b][::-1]])
        fig.add_scatter(
            x=x.astype(np.float32), y=y.astype(np.float32), mode="lines", fill="toself", line={"width": 0},
            fillcolor=f"rgba({int(colour[1:3], 16)},{int(colour[3:5], 16)},{int(colour[5:7], 16)},0.18)",
            hoverinfo="skip", **place,
        )  # fmt: skip
