"""The report as one HTML page that needs nothing else: no network, no other file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from ..data import Detections, Rig, Tracks, Trajectories
from ..findings.cameras import upwards
from ..findings.trial_findings import LONG_GAP_S, inconsistent_cameras
from ..io.files import replacing
from ..track.simultaneous import Simultaneous
from .ambiguous_table import ambiguous_table
from .digitised import digitised_card
from .figures import exactness_figure, timeline_figure, trajectories_figure, uncertainty_figure
from .figures_calibration import slices_figure
from .figures_cameras import detections_figure, offset_figure, residual_figure, timing_figure, views_figure
from .figures_detections import Picture, spots_figure
from .formatting import number
from .html_tables import (
    calibration_table,
    camera_table,
    finding_list,
    marker_table,
    paragraphs,
    spots_table,
    step_table,
    tiles,
)
from .scene3d import scene
from .theme import empty
from .words import headline_of, sentences_of

NAV = {
    "verdict": "Verdict",
    "space": "Space",
    "markers": "Markers",
    "detection": "Detection",
    "cameras": "Cameras",
    "made": "How it was made",
    "terms": "Terms",
}
"""Sections of the page, in their order."""
UNJUDGED = "Nobody judged this calibration: run the trial in a session, or kinemark calibrate."


def write_report(
    path: Path | str,
    *,
    quality: dict[str, Any],
    rig: Rig,
    detections: Detections,
    tracks: Tracks,
    trajectories: Trajectories,
    judged: Mapping[str, Any] | None = None,
    pictures: Sequence[Picture] | None = None,
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page, usually `report.html`.
        quality: the figures from `quality.quality` of the same records.
        rig, detections, tracks, trajectories: what is drawn.
        judged: the figures of the calibration, from `calibration.calibration_figures`.
        pictures: (C) an image (H, W) of each camera, of its frame in `figures_detections.fullest_frames`.

    Raises:
        KinemarkError: the folder cannot be written.
        ValueError: a camera of the detections is not in the rig.
    """
    html = page(
        quality=quality,
        rig=rig,
        detections=detections,
        tracks=tracks,
        trajectories=trajectories,
        judged=judged,
        pictures=pictures,
    )
    with replacing(path) as beside:
        beside.write_text(html, encoding="utf-8")


def page(
    *,
    quality: dict[str, Any],
    rig: Rig,
    detections: Detections,
    tracks: Tracks,
    trajectories: Trajectories,
    judged: Mapping[str, Any] | None = None,
    pictures: Sequence[Picture] | None = None,
) -> str:
    """The page as text."""
    drawn = figures(quality, rig.select(detections.cameras), detections, tracks, trajectories)
    drawn["spots"] = spots_figure(detections, quality["cameras"], pictures)
    drawn["calibration"] = empty(UNJUDGED) if judged is None else slices_figure(dict(judged), upwards(rig))
    main = _template("page.html").substitute(
        {f"figure_{name}": figure_html(name, fig) for name, fig in drawn.items()},
        version=escape(quality["kinemark"]),
        grade=quality["verdict"]["grade"],
        headline=escape(headline_of(quality["verdict"])),
        sentences=paragraphs(sentences_of(quality["verdict"])),
        tiles=tiles(quality),
        warnings=finding_list(quality["findings"]),
        calibration=escape(quality["calibration"]["method"] or "not stated"),
        volume=escape(_volume(quality["volume"])),
        calibration_verdict=_verdict(judged),
        calibration_table=calibration_table(quality["cameras"]),
        digitised=digitised_card(quality.get("digitising")),
        spots_table=spots_table(quality["cameras"]),
        camera_table=camera_table(quality["cameras"], inconsistent_cameras(quality)),
        marker_table=marker_table(quality["trajectories"]["markers"], gap_s=LONG_GAP_S),
        filling=_filling(quality["filling"]),
        ambiguous_table=ambiguous_table(quality["ambiguous_decisions"], listed=_tells(quality["steps"])),
        step_table=step_table(quality["steps"]),
    )
    return framed(main, heading=quality["trial"], below=of_session(quality), nav=NAV)


def of_session(figures: Mapping[str, Any]) -> str:
    """What stands below the title of a page about a session."""
    return f"Session {figures['session']} · Kinemark {figures['kinemark']}"


def framed(main: str, *, heading: str, below: str, nav: Mapping[str, str], plots: bool = True) -> str:
    """A whole page: head, title and links around `main`, and the drawing library behind it where it has `plots`."""
    return _template("frame.html").substitute(
        title=escape(f"{heading} · {below}"),
        heading=escape(heading),
        below=escape(below),
        nav="".join(f'<a href="#{place}">{escape(name)}</a>' for place, name in nav.items()),
        main=main,
        plotly=get_plotlyjs() if plots else "",
    )


def _template(name: str) -> Template:
    return Template(files(__package__).joinpath(name).read_text(encoding="utf-8"))


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


def _tells(steps: list[dict[str, Any]]) -> bool:
    """Whether the tracking was by a method that tells its doubts."""
    return any(step["stage"] == "track" and step["method"] == Simultaneous.__name__ for step in steps)


def _verdict(judged: Mapping[str, Any] | None) -> str:
    """The calibration's headline and sentences, with its findings, and where the rest stands."""
    if judged is None:
        return ""
    verdict = judged["verdict"]
    words = f"<p><b>{escape(headline_of(verdict))}</b></p>{paragraphs(sentences_of(verdict))}"
    link = '<p>The whole judgement: <a href="../calibration.html">calibration.html</a></p>'
    return f"{words}{finding_list(judged['findings']) if judged['findings'] else ''}{link}"


def _filling(filling: dict[str, Any] | None) -> str:
    """What became of the gaps, and where every one of them is drawn."""
    if filling is None:
        return ""
    verdict = filling["verdict"]
    words = f"<p><b>{escape(headline_of(verdict))}.</b></p>{paragraphs(sentences_of(verdict))}"
    return f'<div class="card"><h3>Gaps</h3>{words}<p>Every gap: <a href="gaps.html">gaps.html</a></p></div>'


def figure_html(name: str, fig: go.Figure) -> str:
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
