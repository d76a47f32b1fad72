"""A plan of cameras as one HTML page, in the style of the report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..data.array_types import Floats
from ..planning import CameraPlan, walks
from .drawing import Figure
from .drawing_library import DrawingLibrary, drawing_library, inside
from .figures_calibration import slices_figure, space_figure
from .formatting import measure, millimetres, number, percent
from .tables import Table, Tile
from .templating import render, write_text
from .theme import HUES, empty, figure, labels

NAV = {
    "verdict": "Verdict",
    "cameras": "Where they stand",
    "error": "How exact, and where",
    "body": "On a walking body",
    "terms": "Terms",
}
"""Sections of the page, in their order."""
UP = 2
"""The axis of a plan that points upwards, z; by definition."""


def write_plan_page(path: Path | str, *, figures: dict[str, Any], plan: CameraPlan, assets: Path | None = None) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page, usually `plan.html`.
        figures: of `plan_figures` of the same plan.
        plan: what is drawn.
        assets: folder of the drawing library that the page names; inside the page where None.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    write_text(path, plan_page(figures=figures, plan=plan, library=drawing_library(path, assets)))


def plan_page(*, figures: dict[str, Any], plan: CameraPlan, library: DrawingLibrary | None = None) -> str:
    """The page as text; the drawing library is inside where `library` is None."""
    drawn = {
        "space": _space(figures, plan),
        "slices": slices_figure(figures, UP),
        "markers": marker_figure(figures["body"]),
    }
    return render(
        "plan.html",
        library=library or inside(),
        heading="Plan of cameras",
        below=f"Kinemark {figures['kinemark']}",
        nav=NAV,
        figures=figures,
        drawn=drawn,
        tiles=_tiles(figures),
        camera_table=camera_table(figures),
        lost_table=lost_table(figures),
        centroid=measure(figures["asked"]["centroid_px"], 2, "px"),
        candidates=number(figures["candidates"]),
    )


def camera_table(figures: dict[str, Any]) -> Table:
    """A row a camera, the one that should come next at the end, marked."""
    head = ["camera", "", "x, y, z (mm)", "height (mm)", "heading (°)", "tilt (°)", "aims at x, y, z (mm)"]
    rows = [[row["name"], "stands" if row["given"] else "new", *_place(row)] for row in figures["cameras"]]
    if figures["following"]:
        rows.append(["one more", "next", *_place(figures["following"])])
    return Table(head, rows, marked=[row[1] == "next" for row in rows], kept_in="plan.json")


def _place(row: dict[str, Any]) -> list[str]:
    return [
        ", ".join(number(x, 0) for x in row["position_mm"]),
        number(row["height_mm"], 0),
        number(row["heading_deg"], 0),
        number(row["tilt_deg"], 0),
        ", ".join(number(x, 0) for x in row["aims_at_mm"]),
    ]


def lost_table(figures: dict[str, Any]) -> Table:
    """With all cameras, without each, and with one more: what is measured."""
    head = ["cameras", "body: by two or more", "by three or more", "σ on the body (mm)", "σ in the volume (mm)"]
    body, following = figures["body"], figures["following"]
    rows = [["all", *_measured(body), number(figures["volume"]["sd_median_mm"], 2)]]
    for row in figures["cameras"]:
        lost = row["without"]
        left = [percent(lost["body_two_share"]), "–", number(lost["body_sd_median_mm"], 2)] if body else ["–"] * 3
        rows.append([f"without {row['name']}", *left, number(lost["sd_median_mm"], 2)])
    if following:
        rows.append(["with one more", *_measured(following["body"]), number(following["volume"]["sd_median_mm"], 2)])
    return Table(head, rows, kept_in="plan.json")


def _measured(body: dict[str, Any] | None) -> list[str]:
    if body is None:
        return ["–"] * 3
    return [percent(body["seen_by_2_share"]), percent(body["seen_by_3_share"]), number(body["sd_median_mm"], 2)]


def marker_figure(body: dict[str, Any] | None) -> Figure:
    """Per marker of the walking body, the shares of its samples that so many cameras measure, and its σ."""
    if not body:
        return empty("The plan was made for the empty volume, without a subject.")
    rows = body["markers"]
    names = labels(row["marker"] for row in rows)
    fig = figure(360, showlegend=True, legend={"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0})
    for i, (key, name) in enumerate((("seen_by_2_share", "two or more"), ("seen_by_3_share", "three or more"))):
        fig.add(
            "bar", x=names, y=[row[key] and 100 * row[key] for row in rows], name=name, marker={"color": HUES[i]},
            hovertemplate=f"%{{x}}: %{{y:.1f}} % by {name}<extra></extra>",
        )  # fmt: skip
    fig.add(
        "scatter", x=names, y=[row["sd_median_mm"] for row in rows], name="σ (mm)", mode="markers", yaxis="y2",
        marker={"color": HUES[2], "symbol": "diamond", "size": 9}, hovertemplate="%{x}: σ %{y:.3g} mm<extra></extra>",
    )  # fmt: skip
    title = {"text": "σ (mm)", "standoff": 10}
    side = {"overlaying": "y", "side": "right", "rangemode": "tozero", "title": title, "showgrid": False,
            "tickmode": "auto", "nticks": 5}  # fmt: skip
    fig.arrange(barmode="group", yaxis2=side, margin={"r": 70})
    return fig.arrange(yaxis={"title": {"text": "samples measured (%)"}, "range": [0, 105]})


def _markers(plan: CameraPlan) -> Floats:
    """(N, 3) mm of the walking body; none without one."""
    asked = plan.planning
    if not asked.subject_mm:
        return np.zeros((0, 3))
    bodies = walks(plan.room, diameter_mm=asked.diameter_mm, height_mm=asked.subject_mm, markers=asked.markers)
    return bodies[0].xyz.reshape(-1, 3)


def _space(figures: dict[str, Any], plan: CameraPlan) -> Figure:
    """It opens on the whole laboratory, as the cameras are what is asked for."""
    fig = space_figure(figures, plan.rig, _markers(plan), called="markers of the walking body")
    return fig.arrange(scene={"camera": fig.layout["updatemenus"][0]["buttons"][1]["args"][0]["scene.camera"]})


def _tiles(figures: dict[str, Any]) -> list[Tile]:
    """The key figures."""
    body, volume, following = figures["body"], figures["volume"], figures["following"]
    main = body or volume
    where = "of a walking body's markers" if body else "of the volume"
    after = following and (following["body"] or following["volume"])
    return [
        Tile(percent(main["seen_by_3_share"]), f"{where}, by three cameras", _by_two(main)),
        Tile(millimetres(main["sd_median_mm"]), "σ of a marker, per axis", f"95 %: {millimetres(main['sd_95_mm'])}"),
        Tile(percent(volume["seen_by_3_share"]), "of the empty volume, by three", _by_two(volume)),
        Tile(
            millimetres(after["sd_median_mm"]) if after else "–", "σ with one more camera",
            f"by three {percent(after['seen_by_3_share'])}" if after else "no place is left for one",
        ),
    ]  # fmt: skip


def _by_two(measured: dict[str, Any]) -> str:
    return f"by two {percent(measured['seen_by_2_share'])}"
