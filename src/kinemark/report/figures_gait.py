"""Gait curves as clinicians lay them out: pelvis, hip, knee, ankle and foot in three planes; moments and powers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..data.gait_curves import GaitCurves, GaitReference
from .drawing import Figure
from .stride_panels import Part, band, corner, directions, line, stride_figure, upright
from .theme import INK, empty, label

SIDE_COLOURS = {"left": "#C62828", "right": "#0072B2"}
"""Left red, right blue; conventional in gait reports, and told apart by all."""
REFERENCE_COLOUR = "#6B7680"
"""Of the reference's band."""
UNITS = {"deg": "°"}
"""As they are written in a title, where it is otherwise."""
PER_PAGE = 12
"""Panels that fit a printed page; chosen."""


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
TRUNK = (
    Panel("Trunk tilt", "ThoraxAngles", 0, "forward", "back"),
    Panel("Trunk obliquity", "ThoraxAngles", 1, "up", "down"),
    Panel("Trunk rotation", "ThoraxAngles", 2, "forward", "back"),
)
"""The same of the trunk in the room, where its markers are worn; up and forward are those of the side's shoulder."""
KINETICS = (
    Panel("Hip moment", "HipMoment", 0, "extensors", "flexors"),
    Panel("Knee moment", "KneeMoment", 0, "extensors", "flexors"),
    Panel("Ankle moment", "AnkleMoment", 0, "plantarflexors", "dorsiflexors"),
    Panel("Hip frontal moment", "HipMoment", 1, "abductors", "adductors"),
    Panel("Knee frontal moment", "KneeMoment", 1, "abductors", "adductors"),
    Panel("Ankle frontal moment", "AnkleMoment", 1, "abductors", "adductors"),
    Panel("Hip power", "HipPower", 0, "generated", "absorbed"),
    Panel("Knee power", "KneePower", 0, "generated", "absorbed"),
    Panel("Ankle power", "AnklePower", 0, "generated", "absorbed"),
    Panel("Fore-aft reaction", "GroundReactionForce", 0, "propels", "brakes"),
    Panel("Mediolateral reaction", "GroundReactionForce", 1, "medial", "lateral"),
    Panel("Vertical reaction", "GroundReactionForce", 2, "", ""),
)
"""The same of loads."""


def panels_figure(
    curves: Sequence[GaitCurves],
    panels: Sequence[Panel],
    reference: GaitReference | None = None,
    *,
    heads: Sequence[str] = (),
) -> Figure:
    """Mean of each side, its spread as a band, the measurement's SD as thin lines, foot off as dashed uprights.

    The reference's mean ± SD is a grey band below them; `heads` stand above the columns.
    """
    known = [panel for panel in panels if _of(curves, panel)]
    if not known:
        return empty("There is nothing to draw: no stride has these quantities.")
    units = [next((one.unit for one in _of(curves, panel)), "") for panel in panels]
    titles = [f"{p.title} ({UNITS.get(u, u)})" if u else p.title for p, u in zip(panels, units, strict=True)]
    traces, shapes, notes = [], [], []
    for i, panel in enumerate(panels):
        if reference is not None and panel.name in reference.mean:
            mean, sd = (part[panel.name][:, panel.axis] for part in (reference.mean, reference.sd))
            traces += band(mean - sd, mean + sd, REFERENCE_COLOUR, i)
        for one in _of(curves, panel):
            traces += _curves(one, panel, i)
            shapes += _foot_off(one, i)
        notes += directions(panel.up, panel.down, i)
    blank = [i for i, panel in enumerate(panels) if panel is BLANK]
    if blank:
        drawn = [one for panel in known for one in _of(curves, panel)]
        notes += _key(corner(blank[-1] - 1, len(panels)), drawn, with_reference=reference is not None)
    hidden = dict.fromkeys(blank, ({"visible": False}, {"visible": False}))
    return stride_figure(titles, traces, shapes, notes, heads=heads, axes=hidden)


def trunk_figure(curves: Sequence[GaitCurves], reference: GaitReference | None = None) -> Figure | None:
    """The trunk's angles; None where nobody wore its markers."""
    return panels_figure(curves, TRUNK, reference) if any(_of(curves, panel) for panel in TRUNK) else None


def _key(place: tuple[float, float], drawn: Sequence[GaitCurves], *, with_reference: bool) -> list[Part]:
    """Which line is which of those that are drawn, below this corner of an empty panel."""
    lines = [(f"━━ {side}", colour) for side, colour in SIDE_COLOURS.items() if any(one.side == side for one in drawn)]
    lines += [("- - measured to ±", INK)] if any(np.isfinite(one.measurement_sd).any() for one in drawn) else []
    lines += [("┊ foot off", INK)] if any(np.isfinite(one.foot_off).any() for one in drawn) else []
    lines += [("▒▒ reference", REFERENCE_COLOUR)] if with_reference else []
    return [
        {
            "text": text, "xref": "paper", "yref": "paper", "x": place[0], "y": place[1], "yshift": -16 * k,
            "xanchor": "left", "yanchor": "top", "showarrow": False, "font": {"size": 11, "color": colour},
        }
        for k, (text, colour) in enumerate(lines)
    ]  # fmt: skip


def emg_figures(curves: Sequence[GaitCurves]) -> list[Figure]:
    """A panel a channel, a printed page of them a figure."""
    muscles = [one for one in curves if one.axes == ("envelope", "on")]
    return [_emg_figure(muscles[first : first + PER_PAGE]) for first in range(0, len(muscles), PER_PAGE)]


def _emg_figure(muscles: Sequence[GaitCurves]) -> Figure:
    """The mean envelope with its spread, and a bar where the muscle is on in most strides; without bursts no bar."""
    said = ["" if np.isfinite(one.mean[:, 1]).any() else " (no bursts)" for one in muscles]
    titles = [label(one.name.rsplit(".", 1)[-1]) + more for one, more in zip(muscles, said, strict=True)]
    traces, shapes = [], []
    for i, one in enumerate(muscles):
        traces += _curves(one, Panel("", one.name, 0, "", ""), i)
        traces.append(line(np.where(one.mean[:, 1] >= 50, -6.0, np.nan), SIDE_COLOURS[one.side], "", i, width=5))
        shapes += _foot_off(one, i)
    return stride_figure(titles, traces, shapes, axes={i: ({}, {"range": [-12, 105]}) for i in range(len(muscles))})


def _of(curves: Sequence[GaitCurves], panel: Panel) -> list[GaitCurves]:
    """The curves of both sides that a panel shows, where they have values."""
    return [
        one for one in curves
        if one.name[1:] == panel.name and panel.axis < len(one.axes) and np.isfinite(one.mean[:, panel.axis]).any()
    ]  # fmt: skip


def _curves(one: GaitCurves, panel: Panel, i: int) -> list[Part]:
    """The mean, its spread as a band, and the measurement's SD as thin lines."""
    colour = SIDE_COLOURS[one.side]
    mean, spread, sd = (part[:, panel.axis] for part in (one.mean, one.spread, one.measurement_sd))
    edges = [line(edge, colour, "", i, width=0.7, dash="dot") for edge in (mean - sd, mean + sd)]
    whole = line(mean, colour, f"{one.side}, mean of {len(one.values)}", i)
    return [*band(mean - spread, mean + spread, colour, i), *edges, whole]


def _foot_off(one: GaitCurves, i: int) -> list[Part]:
    """Where the foot leaves the floor on average."""
    off = one.foot_off[np.isfinite(one.foot_off)]
    return [upright(float(off.mean()), SIDE_COLOURS[one.side], i)] if len(off) else []
