"""The calibration as one HTML page, in the style of the report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..calibrate.quality import Evidence
from ..data import Rig
from ..data.array_types import Floats
from ..findings.cameras import upwards
from .calibration_tables import (
    calibration_tiles,
    change_table,
    fit_table,
    lens_table,
    loss_table,
    place_table,
    point_table,
)
from .drawing import Figure
from .drawing_library import DrawingLibrary, drawing_library, inside
from .figures_calibration import (
    fit_figure,
    lens_figure,
    loss_figure,
    lost_figure,
    points_figure,
    slices_figure,
    space_figure,
    wand_figure,
)
from .figures_images import images_figure
from .formatting import measure, number
from .page import of_session
from .templating import render, write_text

NAV = {
    "verdict": "Verdict",
    "volume": "How exact, and where",
    "fit": "How well it fits",
    "cameras": "Cameras",
    "terms": "Terms",
}
"""Sections of the page, in their order."""
MOST_POINTS = 600
"""Drawn in space; chosen."""


def write_calibration_page(
    path: Path | str, *, figures: dict[str, Any], rig: Rig, evidence: Evidence, assets: Path | None = None
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page, usually `calibration.html`.
        figures: of `calibration.calibration_figures` from the same rig and evidence.
        rig, evidence: what is drawn.
        assets: folder of the drawing library that pages share; None puts it inside the page.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    library = drawing_library(path, assets)
    write_text(path, calibration_page(figures=figures, rig=rig, evidence=evidence, library=library))


def calibration_page(
    *, figures: dict[str, Any], rig: Rig, evidence: Evidence, library: DrawingLibrary | None = None
) -> str:
    """The page as text; the drawing library is inside where `library` is None."""
    lost, change = figures["map"]["lost"], figures["change"]
    return render(
        "calibration.html",
        library=library or inside(),
        heading="Calibration",
        below=of_session(figures),
        nav=NAV,
        figures=figures,
        drawn=drawings(figures, rig, evidence),
        tiles=calibration_tiles(figures),
        fit_table=fit_table(figures["cameras"]),
        loss_table=loss_table(figures),
        wand_table=place_table(figures["wand"]),
        point_table=point_table(figures["points"]),
        lens_table=lens_table(figures),
        change_table=change_table(change),
        world_moved=measure(change and change["world_moved_mm"], 1, "mm"),
        centroid=measure(figures["precision"]["centroid_sd_px"], 3, "px"),
        volume=_volume(figures["volume"]),
        level=f"{'xyz'[lost['axis']]} = {number(lost['level_mm'], 0)} mm",
    )


def drawings(figures: dict[str, Any], rig: Rig, evidence: Evidence) -> dict[str, Figure]:
    """All figures of the page by name."""
    return {
        "slices": slices_figure(figures, upwards(rig)),
        "space": space_figure(figures, rig, _few(evidence.xyz)),
        "loss": loss_figure(figures),
        "lost": lost_figure(figures),
        "residuals": fit_figure(figures["cameras"]),
        "images": images_figure(figures["cameras"], evidence),
        "points": points_figure(figures["points"]),
        "wand": wand_figure(figures["wand"]),
        "lens": lens_figure(figures["cameras"]),
    }


def _few(xyz: Floats) -> Floats:
    known = xyz[np.isfinite(xyz).all(1)]
    return known[:: max(1, -(-len(known) // MOST_POINTS))]


def _volume(volume: dict[str, Any]) -> str:
    low, high = volume["corners_mm"]
    spans = ", ".join(f"{axis} {a:z.0f} to {b:z.0f}" for axis, a, b in zip("xyz", low, high, strict=True))
    return f"{spans} mm" + ("" if volume["given"] else " (assumed about where the cameras' axes meet; set volume_mm)")
