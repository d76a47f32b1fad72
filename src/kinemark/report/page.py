"""The report of a trial as one HTML page, which needs no network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..data import Detections, Rig, Tracks, Trajectories
from ..data.array_types import GreyLevels
from ..findings.cameras import upwards
from ..findings.trial_findings import LONG_GAP_S, inconsistent_cameras
from ..track.simultaneous import Simultaneous
from .drawing import Figure
from .drawing_library import DrawingLibrary, drawing_library, inside
from .figures import exactness_figure, timeline_figure, trajectories_figure, uncertainty_figure
from .figures_calibration import slices_figure
from .figures_cameras import detections_figure, offset_figure, residual_figure, timing_figure, views_figure
from .figures_detections import spots_figure
from .formatting import identity_text, number
from .scene3d import scene
from .tables import (
    ambiguous_table,
    calibration_table,
    camera_table,
    digitised_line,
    digitised_table,
    label_line,
    label_table,
    marker_table,
    spots_table,
    step_table,
    tiles,
    unsure_table,
)
from .templating import render, write_text
from .theme import empty

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
    pictures: Sequence[GreyLevels] | None = None,
    assets: Path | None = None,
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page, usually `report.html`.
        quality: the figures from `quality.quality` of the same records.
        rig, detections, tracks, trajectories: what is drawn.
        judged: the figures of the calibration, from `calibration.calibration_figures`.
        pictures: (C) an image (H, W) of each camera, of its frame in `figures_detections.fullest_frames`.
        assets: folder of the drawing library that pages share; None puts it inside the page.

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
        library=drawing_library(path, assets),
    )
    write_text(path, html)


def page(
    *,
    quality: dict[str, Any],
    rig: Rig,
    detections: Detections,
    tracks: Tracks,
    trajectories: Trajectories,
    judged: Mapping[str, Any] | None = None,
    pictures: Sequence[GreyLevels] | None = None,
    library: DrawingLibrary | None = None,
) -> str:
    """The page as text; the drawing library is inside where `library` is None."""
    drawn = figures(quality, rig.select(detections.cameras), detections, tracks, trajectories)
    drawn["spots"] = spots_figure(
        detections, quality["cameras"], pictures, first_frame=quality["recording"]["first_frame"]
    )
    drawn["calibration"] = empty(UNJUDGED) if judged is None else slices_figure(dict(judged), upwards(rig))
    digitising, labels = quality.get("digitising") or None, quality.get("labels")
    return render(
        "report.html",
        library=library or inside(),
        heading=quality["trial"],
        below=of_session(quality),
        nav=NAV,
        quality=quality,
        judged=judged,
        drawn=drawn,
        tiles=tiles(quality),
        volume=_volume(quality["volume"]),
        calibration_table=calibration_table(quality["cameras"]),
        digitised_line=digitising and digitised_line(digitising),
        digitised_table=digitising and digitised_table(digitising),
        label_line=labels and label_line(labels),
        label_table=labels and label_table(labels),
        unsure_table=labels and unsure_table(labels, quality["recording"]["first_frame"]),
        spots_table=spots_table(quality["cameras"]),
        camera_table=camera_table(quality["cameras"], inconsistent_cameras(quality)),
        marker_table=marker_table(quality["trajectories"]["markers"], gap_s=LONG_GAP_S),
        ambiguous_table=ambiguous_table(quality["ambiguous_decisions"], listed=_tells(quality["steps"])),
        step_table=step_table(quality["steps"]),
    )


def of_session(figures: Mapping[str, Any]) -> str:
    """What stands below the title of a page about a session."""
    return f"{identity_text(figures.get('identity'))} · Session {figures['session']} · Kinemark {figures['kinemark']}"


def figures(
    quality: dict[str, Any], rig: Rig, detections: Detections, tracks: Tracks, trajectories: Trajectories
) -> dict[str, Figure]:
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
    """Whether the tracking was by a method that reports ambiguous decisions."""
    return any(step["stage"] == "track" and step["method"] == Simultaneous.__name__ for step in steps)


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
