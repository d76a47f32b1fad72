"""What limits a recording as one HTML page, in the style of the report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..data import Rig
from ..sensitivity import Ranking
from .drawing_library import DrawingLibrary, drawing_library, inside
from .figures_sensitivity import (
    angle_figure,
    cycles_figure,
    field_figure,
    loss_figure,
    marker_figure,
    ranked_figure,
)
from .formatting import degrees, millimetres, number, percent
from .page import of_session
from .tables import Table, Tile
from .templating import render, write_text
from .words import SOURCE_ADVICE, evidence_text

NAV = {
    "verdict": "Verdict",
    "ranking": "What limits it",
    "where": "Where it comes from",
    "cameras": "When a camera is lost",
    "terms": "Terms",
}
"""Sections of the page, in their order."""


def write_sensitivity_page(
    path: Path | str, *, figures: dict[str, Any], ranking: Ranking, rig: Rig, assets: Path | None = None
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page, usually `sensitivity.html`.
        figures: of `sensitivity.sensitivity_figures` from the same ranking.
        ranking, rig: what is drawn.
        assets: folder of the drawing library that pages share; None puts it inside the page.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    library = drawing_library(path, assets)
    write_text(path, sensitivity_page(figures=figures, ranking=ranking, rig=rig, library=library))


def sensitivity_page(
    *, figures: dict[str, Any], ranking: Ranking, rig: Rig, library: DrawingLibrary | None = None
) -> str:
    """The page as text; the drawing library is inside where `library` is None."""
    drawn = {
        "ranked": ranked_figure(figures),
        "cycles": cycles_figure(figures),
        "markers": marker_figure(figures),
        "angles": angle_figure(figures),
        "field": field_figure(ranking, rig),
        "loss": loss_figure(figures),
    }
    return render(
        "sensitivity.html",
        library=library or inside(),
        heading=f"Sensitivity of {figures['trial']}",
        below=of_session(figures),
        nav=NAV,
        figures=figures,
        drawn=drawn,
        tiles=_tiles(figures),
        by_model=ranking.by_model,
        ranking_table=ranking_table(figures),
        source_advice=SOURCE_ADVICE,
        evidence_text=evidence_text,
        lost_table=lost_table(figures["lost"]),
    )


def ranking_table(figures: dict[str, Any]) -> Table:
    """A row a source, the greatest first, and all together."""
    n = figures["cycles"]
    head = ["source", "image (px)", "marker σ (mm)", "95 % (mm)", "angle σ (°)", "95 % (°)", f"mean of {n} (°)"]
    head += ["share of variance", "all without it"]
    unit = figures["ranked_by"]
    rows = [
        [
            row["source"],
            number(row["px"], 3),
            *(number(row[key], 2) for key in ("mm", "mm_95", "deg", "deg_95", "mean_deg")),
            percent(row["variance_share"]),
            degrees(row["without_it"]) if unit == "deg" else millimetres(row["without_it"]),
        ]
        for row in figures["ranking"]
    ]
    for largest in figures["lost"][:1]:
        cost = [number(largest["cost_mm"], 2), "–", number(largest["cost_deg"], 2), "–", "–", "–", "–"]
        at = sum((row[unit] or 0.0) > (largest[f"cost_{unit}"] or 0.0) for row in figures["ranking"])
        rows.insert(at, [f"{largest['camera']}, if lost", "–", *cost])
    total = figures["total"]
    rows.append(
        [
            "all together",
            "",
            number(total["mm"], 2),
            "",
            number(total["deg"], 2),
            "",
            number(total["mean_deg"], 2),
            "",
            "",
        ]
    )
    return Table(head, rows, marked=[True])


def lost_table(lost: list[dict[str, Any]]) -> Table:
    """A row a camera, the one most missed first."""
    head = [
        "camera",
        "σ without it (mm)",
        "with it (mm)",
        "angle σ without it (°)",
        "costs (mm)",
        "costs (°)",
        "points gone",
    ]
    keys = ("mm", "all_mm", "deg", "cost_mm", "cost_deg")
    rows = [[row["camera"], *(number(row[key], 2) for key in keys), percent(row["gone_share"])] for row in lost]
    return Table(head, rows)


def _tiles(figures: dict[str, Any]) -> list[Tile]:
    """The key figures."""
    total = figures["total"]
    first = figures["lost"][0] if figures["lost"] else None
    without = f"without it {millimetres(first['mm'])}" if first else "there are two"
    return [
        Tile(degrees(total["mean_deg"], 1), "an angle, mean of cycles", f"{degrees(total['deg'], 1)} in a frame"),
        Tile(degrees(total["cameras_deg"]), "of it by the cameras", "without the placement of markers"),
        Tile(millimetres(total["cameras_mm"]), "a marker's position", "σ along each axis, by the cameras"),
        Tile(first["camera"] if first else "–", "camera most missed", without),
    ]
