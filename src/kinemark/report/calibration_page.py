"""The calibration as one HTML page that needs nothing else, in the style of the report."""

from __future__ import annotations

from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
import plotly.graph_objects as go

from ..calibrate.quality import Evidence
from ..data import Rig
from ..data.array_types import Floats
from ..findings.cameras import upwards
from ..io.files import replacing
from .calibration_tables import (
    calibration_tiles,
    change_table,
    fit_table,
    lens_table,
    loss_table,
    place_table,
    point_table,
)
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
from .html_tables import finding_list, paragraphs
from .page import figure_html, framed, of_session
from .words import headline_of, sentences_of

NAV = {
    "verdict": "Verdict",
    "volume": "How exact, and where",
    "fit": "How well it fits",
    "cameras": "Cameras",
    "terms": "Terms",
}
"""Sections of the page, in their order."""
WAND = (
    "Error of the wand's length against where it was, a dot a pose, for poses that took no part in the fit; orange "
    "lines are means. A slope or a bow means that the scale changes across the volume."
)
POINTS = (
    "The worst first. A point whose error left out stands far above the others was surveyed or read wrongly; tinted "
    "ones were not used by some camera."
)
MOST_POINTS = 600
"""Drawn in space."""


def write_calibration_page(path: Path | str, *, figures: dict[str, Any], rig: Rig, evidence: Evidence) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page, usually `calibration.html`.
        figures: of `calibration.calibration_figures` from the same rig and evidence.
        rig, evidence: what is drawn.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    html = calibration_page(figures=figures, rig=rig, evidence=evidence)
    with replacing(path) as beside:
        beside.write_text(html, encoding="utf-8")


def calibration_page(*, figures: dict[str, Any], rig: Rig, evidence: Evidence) -> str:
    """The page as text."""
    template = Template(files(__package__).joinpath("calibration.html").read_text(encoding="utf-8"))
    drawn = {name: figure_html(name, fig) for name, fig in drawings(figures, rig, evidence).items()}
    main = template.substitute(
        {f"figure_{name}": html for name, html in drawn.items()},
        grade=figures["verdict"]["grade"],
        headline=escape(headline_of(figures["verdict"])),
        sentences=paragraphs(sentences_of(figures["verdict"])),
        tiles=calibration_tiles(figures),
        warnings=finding_list(figures["findings"]),
        fit_table=fit_table(figures["cameras"]),
        loss_table=loss_table(figures),
        wand_card=_card("The wand by place", WAND, drawn["wand"], place_table(figures["wand"])),
        point_card=_card("The control points", POINTS, drawn["points"], point_table(figures["points"])),
        lens_table=lens_table(figures),
        change_table=change_table(figures["change"]),
        method=escape(figures["method"] or "not stated"),
        centroid=escape(measure(figures["precision"]["centroid_sd_px"], 3, "px")),
        version=escape(figures["kinemark"]),
        volume=escape(_volume(figures["volume"])),
        level=escape(f"{'xyz'[figures['map']['lost']['axis']]} = {number(figures['map']['lost']['level_mm'], 0)} mm"),
    )
    return framed(main, heading="Calibration", below=of_session(figures), nav=NAV)


def drawings(figures: dict[str, Any], rig: Rig, evidence: Evidence) -> dict[str, go.Figure]:
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


def _card(title: str, text: str, figure: str, rows: str) -> str:
    """A part of the page that only calibrations with such rows have."""
    if not rows:
        return ""
    return f'<div class="card long"><h3>{escape(title)}</h3><p>{escape(text)}</p>{figure}{rows}</div>'


def _few(xyz: Floats) -> Floats:
    known = xyz[np.isfinite(xyz).all(1)]
    return known[:: max(1, -(-len(known) // MOST_POINTS))]


def _volume(volume: dict[str, Any]) -> str:
    low, high = volume["corners_mm"]
    spans = ", ".join(f"{axis} {a:.0f} to {b:.0f}" for axis, a, b in zip("xyz", low, high, strict=True))
    return f"{spans} mm" + ("" if volume["given"] else " (assumed about where the cameras' axes meet; set volume_mm)")
