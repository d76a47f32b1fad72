"""The report as one HTML page that needs nothing else: no network, no other file."""

from __future__ import annotations

from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from ..data import Detections, Rig, Tracks, Trajectories
from ..io.files import replacing
from .advice import LONG_GAP_S, worst_cameras
from .figures import exactness_figure, timeline_figure, trajectories_figure, uncertainty_figure
from .figures_cameras import detections_figure, offset_figure, residual_figure, timing_figure, views_figure
from .scene import scene
from .tables import (
    calibration_table,
    camera_table,
    marker_table,
    paragraphs,
    step_table,
    tiles,
    warning_list,
)
from .words import number


def write_report(
    path: Path | str,
    *,
    quality: dict[str, Any],
    rig: Rig,
    detections: Detections,
    tracks: Tracks,
    trajectories: Trajectories,
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page, usually `report.html`.
        quality: the figures from `quality.quality` of the same records.
        rig, detections, tracks, trajectories: what is drawn.

    Raises:
        KinemarkError: the folder cannot be written.
        ValueError: a camera of the detections is not in the rig.
    """
    html = page(quality=quality, rig=rig, detections=detections, tracks=tracks, trajectories=trajectories)
    with replacing(path) as beside:
        beside.write_text(html, encoding="utf-8")


def page(
    *, quality: dict[str, Any], rig: Rig, detections: Detections, tracks: Tracks, trajectories: Trajectories
) -> str:
    """The page as text."""
    drawn = figures(quality, rig.select(detections.cameras), detections, tracks, trajectories)
    template = Template(files(__package__).joinpath("page.html").read_text(encoding="utf-8"))
    return template.substitute(
        {f"figure_{name}": _figure(name, fig) for name, fig in drawn.items()},
        title=escape(f"{quality['trial']} · {quality['session']}"),
        trial=escape(quality["trial"]),
        session=escape(quality["session"]),
        version=escape(quality["kinemark"]),
        grade=quality["verdict"]["grade"],
        headline=escape(quality["verdict"]["headline"]),
        sentences=paragraphs(quality["verdict"]["sentences"]),
        tiles=tiles(quality),
        warnings=warning_list(quality["warnings"]),
        calibration=escape(quality["calibration"]["method"] or "not stated"),
        volume=escape(_volume(quality["volume"])),
        calibration_table=calibration_table(quality["cameras"]),
        camera_table=camera_table(quality["cameras"], worst_cameras(quality)),
        marker_table=marker_table(quality["trajectories"]["markers"], gap_s=LONG_GAP_S),
        step_table=step_table(quality["steps"]),
        plotly=get_plotlyjs(),
    )


def figures(
    quality: dict[str, Any], rig: Rig, detections: Detections, tracks: Tracks, trajectories: Trajectories
) -> dict[str, go.Figure]:
    """All figures of the page by name."""
    return {
        "scene": scene(rig, tracks, trajectories),
        "timeline": timeline_figure(trajectories),
        "trajectories": trajectories_figure(trajectories),
        "uncertainty": uncertainty_figure(trajectories),
        "exactness": exactness_figure(quality["trajectories"]["markers"]),
        "residuals": residual_figure(quality["cameras"]),
        "offsets": offset_figure(quality["cameras"]),
        "detections": detections_figure(detections),
        "views": views_figure(quality["points"]),
        "timing": timing_figure(quality["timing"]),
    }


def _figure(name: str, fig: go.Figure) -> str:
    """A place for the figure, and its description for the script at the end of the page; no `<` can end it early."""
    spec = fig.to_json().replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
    place = f'<div class="plot" id="{name}" style="height:{fig.layout.height}px"></div>'
    return f'{place}<script type="application/json" data-for="{name}">{spec}</script>'


def _volume(volume: dict[str, Any]) -> str:
    texts = [
        f"{title} {_ranges(volume[key])}."
        for title, key in (("The control volume is", "given_mm"), ("The markers spanned", "spanned_mm"))
        if volume[key]
    ]
    return " ".join(texts)


def _ranges(corners: list[list[float]]) -> str:
    """`x 0 to 2400, y … mm`."""
    spans = [f"{axis} {number(a, 0)} to {number(b, 0)}" for axis, a, b in zip("xyz", *corners, strict=True)]
    return ", ".join(spans) + "\u00a0mm"
