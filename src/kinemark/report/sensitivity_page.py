"""What limits a recording as one HTML page that needs nothing else, in the style of the report."""

from __future__ import annotations

from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from ..data import Rig
from ..io.files import replacing
from ..sensitivity import Ranking
from .figures_sensitivity import (
    angle_figure,
    cycles_figure,
    field_figure,
    loss_figure,
    marker_figure,
    ranked_figure,
)
from .formatting import degrees, millimetres, number, percent
from .html_tables import paragraphs, table
from .page import figure_html, framed, of_session
from .words import SOURCE_ADVICE, headline_of, sentences_of

NAV = {
    "verdict": "Verdict",
    "ranking": "What limits it",
    "where": "Where it comes from",
    "cameras": "When a camera is lost",
    "terms": "Terms",
}
"""Sections of the page, in their order."""
BY_SEGMENTS = "A segment is a line between two markers that keep their distance; name a model to rank joint angles."


def write_sensitivity_page(path: Path | str, *, figures: dict[str, Any], ranking: Ranking, rig: Rig) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page, usually `sensitivity.html`.
        figures: of `sensitivity.sensitivity_figures` from the same ranking.
        ranking, rig: what is drawn.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    html = sensitivity_page(figures=figures, ranking=ranking, rig=rig)
    with replacing(path) as beside:
        beside.write_text(html, encoding="utf-8")


def sensitivity_page(*, figures: dict[str, Any], ranking: Ranking, rig: Rig) -> str:
    """The page as text."""
    template = Template(files(__package__).joinpath("sensitivity.html").read_text(encoding="utf-8"))
    drawn = {
        "ranked": ranked_figure(figures),
        "cycles": cycles_figure(figures),
        "markers": marker_figure(figures),
        "angles": angle_figure(figures),
        "field": field_figure(ranking, rig),
        "loss": loss_figure(figures),
    }
    main = template.substitute(
        {f"figure_{name}": figure_html(name, fig) for name, fig in drawn.items()},
        grade=figures["verdict"]["grade"],
        headline=escape(headline_of(figures["verdict"])),
        sentences=paragraphs(sentences_of(figures["verdict"])),
        tiles=_tiles(figures),
        angles=escape(figures["angles"]),
        model="" if ranking.by_model else BY_SEGMENTS,
        ranking_table=ranking_table(figures),
        advice=_advice(figures["ranking"]),
        lost_table=lost_table(figures["lost"]),
        version=escape(figures["kinemark"]),
    )
    heading = f"Sensitivity of {figures['trial']}"
    return framed(main, heading=heading, below=of_session(figures), nav=NAV)


def ranking_table(figures: dict[str, Any]) -> str:
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
    for worst in figures["lost"][:1]:
        cost = [number(worst["cost_mm"], 2), "–", number(worst["cost_deg"], 2), "–", "–", "–", "–"]
        at = sum((row[unit] or 0.0) > (worst[f"cost_{unit}"] or 0.0) for row in figures["ranking"])
        rows.insert(at, [f"{worst['camera']}, if lost", "–", *cost])
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
    return table(head, rows, marked=[True])


def _advice(rows: list[dict[str, Any]]) -> str:
    """For each source how it is known, and what helps."""
    items = (
        f"<dt>{escape(row['source'].capitalize())}</dt>"
        f"<dd>Known by: {escape(row['origin'])}. {escape(SOURCE_ADVICE[row['source']])}</dd>"
        for row in rows
    )
    return f"<dl>{''.join(items)}</dl>"


def lost_table(lost: list[dict[str, Any]]) -> str:
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
    return table(head, rows) if rows else ""


def _tiles(figures: dict[str, Any]) -> str:
    total = figures["total"]
    first = figures["lost"][0] if figures["lost"] else None
    tiles = [
        (degrees(total["mean_deg"], 1), "an angle, mean of cycles", f"{degrees(total['deg'], 1)} in a frame"),
        (degrees(total["cameras_deg"]), "of it by the cameras", "without the placement of markers"),
        (millimetres(total["cameras_mm"]), "a marker's position", "σ along each axis, by the cameras"),
        (
            first["camera"] if first else "–",
            "camera most missed",
            f"without it {millimetres(first['mm'])}" if first else "there are two",
        ),
    ]
    return "".join(
        f'<div class="tile"><b>{escape(value)}</b><span>{escape(name)}</span><small>{escape(more)}</small></div>'
        for value, name, more in tiles
    )
