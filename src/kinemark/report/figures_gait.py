"""Gait curves as clinicians lay them out: pelvis, hip, knee, ankle and foot in three planes; moments and powers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from ..data.array_types import Floats
from ..data.gait_curves import GaitCurves, GaitReference
from ..findings.plain import runs
from .theme import FAINT, INK, axis_style, empty, figure, label

SIDE_COLOURS = {"left": "#C62828", "right": "#0072B2"}
"""Left red, right blue; conventional in gait reports, and told apart by all."""
REFERENCE_COLOUR = "#6B7680"
"""Of the reference's band."""
UNITS = {"deg": "°"}
"""As they are written in a title, where it is otherwise."""
PER_PAGE = 12
"""Panels that fit a printed page; chosen."""
PERCENT = np.linspace(0, 100, 101)
"""Of a stride, at its 101 points; conventional."""


class Panel(NamedTuple):
    """One drawing: what it is called, which quantity and component, and what is up and down in it."""

    title: str
    name: str
    axis: int
    up: str
    down: str


BLANK = Panel("", "", 0, "", "")
"""An empty place."""
PLANES = ("sagittal plane", "coronal plane", "transverse plane")
"""Of the columns of `KINEMATICS`."""
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
    BLANK,
    Panel("Ankle rotation", "AnkleAngles", 2, "internal", "external"),
    BLANK,
    BLANK,
    Panel("Foot progression", "FootProgressAngles", 1, "internal", "external"),
)
"""Rows of three planes, from the pelvis to the foot; ankle and foot have no angle of their own in the coronal plane."""
KINETICS = (
    Panel("Hip moment", "HipMoment", 0, "extensors", "flexors"),
    Panel("Knee moment", "KneeMoment", 0, "extensors", "flexors"),
    Panel("Ankle moment", "AnkleMoment", 0, "plantarflexors", "dorsiflexors"),
    Panel("Hip frontal moment", "HipMoment", 1, "abductors", "adductors"),
    Panel("Knee frontal moment", "KneeMoment", 1, "abductors", "adductors"),
    Panel("Vertical reaction", "GroundReactionForce", 2, "", ""),
    Panel("Hip power", "HipPower", 0, "generated", "absorbed"),
    Panel("Knee power", "KneePower", 0, "generated", "absorbed"),
    Panel("Ankle power", "AnklePower", 0, "generated", "absorbed"),
)
"""The same of loads."""


def panels_figure(
    curves: Sequence[GaitCurves],
    panels: Sequence[Panel],
    reference: GaitReference | None = None,
    *,
    heads: Sequence[str] = (),
) -> go.Figure:
    """Mean of each side, its spread as a band, the measurement's SD as thin lines, foot off as dashed uprights.

    The reference's mean ± SD is a grey band below them; `heads` stand above the columns.
    """
    known = [panel for panel in panels if _of(curves, panel)]
    if not known:
        return empty("There is nothing to draw: no stride has these quantities.")
    units = [next((one.unit for one in _of(curves, panel)), "") for panel in panels]
    fig = panel_grid(
        [f"{p.title} ({UNITS.get(u, u)})" if u else p.title for p, u in zip(panels, units, strict=True)], heads
    )
    for i, panel in enumerate(panels):
        place = panel_place(i)
        if reference is not None and panel.name in reference.mean:
            mean, sd = (part[panel.name][:, panel.axis] for part in (reference.mean, reference.sd))
            draw_band(fig, mean - sd, mean + sd, REFERENCE_COLOUR, place)
        for one in _of(curves, panel):
            _draw(fig, one, panel, place)
        _directions(fig, panel, i)
        if panel is BLANK:
            fig.update_xaxes(visible=False, **panel_place(i))
            fig.update_yaxes(visible=False, **panel_place(i))
    blank = max((i for i, panel in enumerate(panels) if panel is BLANK), default=None)
    if blank is not None:
        _key(fig, blank - 1, with_reference=reference is not None)
    return fig


def _key(fig: go.Figure, i: int, *, with_reference: bool) -> None:
    """Which line is which, in an empty panel."""
    lines = [(f"━━ {side}", colour) for side, colour in SIDE_COLOURS.items()]
    lines += [("┅┅ measured to ±", INK), ("┊ foot off", INK)]
    lines += [("▒▒ reference", REFERENCE_COLOUR)] if with_reference else []
    x, y = fig.layout[f"xaxis{i + 1}"].domain[0], fig.layout[f"yaxis{i + 1}"].domain[1]
    for k, (text, colour) in enumerate(lines):
        fig.add_annotation(
            text=text, xref="paper", yref="paper", x=x, y=y, yshift=-16 * k, xanchor="left", yanchor="top",
            showarrow=False, font={"size": 11, "color": colour},
        )  # fmt: skip


def emg_figures(curves: Sequence[GaitCurves]) -> list[go.Figure]:
    """A panel a channel, a printed page of them a figure."""
    muscles = [one for one in curves if one.axes == ("envelope", "on")]
    return [_emg_figure(muscles[first : first + PER_PAGE]) for first in range(0, len(muscles), PER_PAGE)]


def _emg_figure(muscles: Sequence[GaitCurves]) -> go.Figure:
    """The mean envelope with its spread, and a bar where the muscle is on in most strides."""
    fig = panel_grid([label(one.name.rsplit(".", 1)[-1]) for one in muscles])
    for i, one in enumerate(muscles):
        _draw(fig, one, Panel("", one.name, 0, "", ""), panel_place(i))
        draw_line(
            fig, np.where(one.mean[:, 1] >= 50, -6.0, np.nan), SIDE_COLOURS[one.side], "", panel_place(i), width=5
        )
        fig.update_yaxes(range=[-12, 105], **panel_place(i))
    return fig


def panel_grid(titles: Sequence[str], heads: Sequence[str] = ()) -> go.Figure:
    """Panels in rows of three with a stride below each, and what the columns are above them."""
    rows = -(-len(titles) // 3)
    fig = make_subplots(
        rows=rows, cols=3, subplot_titles=titles, vertical_spacing=60 / (140 + 190 * rows), horizontal_spacing=0.07
    )
    style = figure(60 + 190 * rows, margin={"l": 44, "r": 24, "t": 78 if heads else 40, "b": 44}).layout
    fig.update_layout({k: style[k] for k in style if not k.endswith("axis")})
    fig.update_annotations(font_size=12)
    for column, head in enumerate(heads):
        fig.add_annotation(
            text=f"<b>{head}</b>", xref=f"x{column + 1 if column else ''} domain", yref="paper", x=0.5, y=1, yshift=26,
            yanchor="bottom", showarrow=False, font={"size": 12},
        )  # fmt: skip
    axis = axis_style() | {"tickfont": {"size": 10}, "title": None}
    fig.update_yaxes(**axis | {"zerolinecolor": FAINT, "zerolinewidth": 0.8})
    fig.update_xaxes(**axis | {"range": [0, 100], "dtick": 20})
    lowest = {i % 3: i for i, title in enumerate(titles) if title}
    for i in lowest.values():
        fig.update_xaxes(title={"text": "stride (%)", "font": {"size": 11}, "standoff": 4}, **panel_place(i))
    return fig.update_layout(showlegend=False)


def panel_place(i: int) -> dict[str, int]:
    """Row and column of a panel."""
    return {"row": i // 3 + 1, "col": i % 3 + 1}


def _directions(fig: go.Figure, panel: Panel, i: int) -> None:
    """What is up and what is down, small, along the right edge, where no curve is."""
    number = "" if i == 0 else str(i + 1)
    for text, y in ((panel.up, 1.0), (panel.down, 0.0)):
        fig.add_annotation(
            text=text, x=1.0, y=y, xref=f"x{number} domain", yref=f"y{number} domain", xanchor="left", textangle=-90,
            yanchor="top" if y else "bottom", showarrow=False, font={"size": 9, "color": FAINT},
        )  # fmt: skip


def _of(curves: Sequence[GaitCurves], panel: Panel) -> list[GaitCurves]:
    """The curves of both sides that a panel shows, where they have values."""
    return [
        one for one in curves
        if one.name[1:] == panel.name and panel.axis < len(one.axes) and np.isfinite(one.mean[:, panel.axis]).any()
    ]  # fmt: skip


def _draw(fig: go.Figure, one: GaitCurves, panel: Panel, place: dict[str, int]) -> None:
    colour = SIDE_COLOURS[one.side]
    mean, spread, sd = (part[:, panel.axis] for part in (one.mean, one.spread, one.measurement_sd))
    draw_band(fig, mean - spread, mean + spread, colour, place)
    for edge in (mean - sd, mean + sd):
        draw_line(fig, edge, colour, "", place, width=0.7, dash="dot")
    draw_line(fig, mean, colour, f"{one.side}, mean of {len(one.values)}", place)
    off = one.foot_off[np.isfinite(one.foot_off)]
    if len(off):
        fig.add_vline(x=float(off.mean()), line={"color": colour, "width": 0.8, "dash": "dash"}, **place)


def draw_line(
    fig: go.Figure, y: Floats, colour: str, name: str, place: dict[str, int], *, width: float = 1.8, dash: str = "solid"
) -> None:
    """One curve (101) over the stride; without a name it has no label."""
    fig.add_scatter(
        x=PERCENT.astype(np.float32), y=y.astype(np.float32), mode="lines", name=name, connectgaps=False,
        line={"color": colour, "width": width, "dash": dash}, hovertemplate="%{x:.0f} %: %{y:.2f}" if name else None,
        hoverinfo=None if name else "skip", **place,
    )  # fmt: skip


def draw_band(fig: go.Figure, low: Floats, high: Floats, colour: str, place: dict[str, int]) -> None:
    """Filled between two curves, run by run, so that what is missing stays empty."""
    for a, b in runs(np.isfinite(low) & np.isfinite(high)):
        x, y = np.concatenate([PERCENT[a:b], PERCENT[a:b][::-1]]), np.concatenate([high[a:b], low[a:b][::-1]])
        fig.add_scatter(
            x=x.astype(np.float32), y=y.astype(np.float32), mode="lines", fill="toself", line={"width": 0},
            fillcolor=f"rgba({int(colour[1:3], 16)},{int(colour[3:5], 16)},{int(colour[5:7], 16)},0.18)",
            hoverinfo="skip", **place,
        )  # fmt: skip
