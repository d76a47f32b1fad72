"""The joint angles as one HTML page, in the style of the report."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from ..data import Angles
from ..kinematics import Cycles, Model
from ..kinematics.chain import Points
from .drawing import Figure
from .drawing_library import DrawingLibrary, drawing_library, inside
from .figures_angles import cycle_figure, joint_figure
from .formatting import identity_text, number, percent
from .stick import stick_data
from .tables import Table
from .templating import render, write_text

NAV = {"verdict": "Verdict", "limb": "The limb", "angles": "Angles", "cycles": "Cycles", "terms": "Terms"}
"""Sections of the page, in their order."""


class JointCard(NamedTuple):
    """A joint on the page: its name, what its drawing shows, and the drawing."""

    name: str
    text: str
    figure: Figure


def write_angles_page(
    path: Path | str,
    *,
    figures: dict[str, Any],
    angles: Angles,
    model: Model,
    points: Points,
    cycles: Cycles | None = None,
    assets: Path | None = None,
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page, usually `angles.html`.
        figures: of `angles.angle_figures`.
        angles, model, cycles: what is drawn; points: (F, 3) mm by name, of the stick figure.
        assets: folder of the drawing library that pages share; None puts it inside the page.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    library = drawing_library(path, assets)
    html = angles_page(figures=figures, angles=angles, model=model, points=points, cycles=cycles, library=library)
    write_text(path, html)


def angles_page(
    *,
    figures: dict[str, Any],
    angles: Angles,
    model: Model,
    points: Points,
    cycles: Cycles | None = None,
    library: DrawingLibrary | None = None,
) -> str:
    """The page as text; the drawing library is inside where `library` is None."""
    first = figures["first_frame"]
    return render(
        "angles.html",
        library=library or inside(),
        heading=f"{figures['trial']}: joint angles",
        below=f"{identity_text(figures.get('identity'))} · Model {figures['model']} · Kinemark {figures['kinemark']}",
        nav={place: name for place, name in NAV.items() if cycles is not None or place != "cycles"},
        figures=figures,
        model=model,
        stick=stick_data(points, angles, model, first_frame=first),
        joints=[_joint_card(angles, model, j, first) for j in range(len(model.joints))],
        angle_table=angle_table(figures),
        cycles=[] if cycles is None else [_cycle_card(cycles, model, j) for j in range(len(model.joints))],
        cycle_table=None if cycles is None else cycle_table(figures),
        lock=number(figures["lock_deg"]),
    )


def _joint_card(angles: Angles, model: Model, j: int, first_frame: int) -> JointCard:
    joint = model.joints[j]
    turns = ", ".join(letter + "′" * i for i, letter in enumerate(joint.sequence))
    text = (
        f"{joint.child} against {joint.parent}, turns about {turns}. The band holds 95 %; dotted lines limit normal "
        "motion, red is beyond it, orange grounds are gimbal lock."
    )
    return JointCard(joint.name.capitalize(), text, joint_figure(angles, model, j, first_frame=first_frame))


def _cycle_card(cycles: Cycles, model: Model, j: int) -> JointCard:
    text = "Thin lines are the cycles, the thick one their mean; the band is ± SD over the cycles."
    return JointCard(model.joints[j].name.capitalize(), text, cycle_figure(cycles, model, j))


def cycle_table(figures: dict[str, Any]) -> Table:
    """A row an angle: how it differs from cycle to cycle."""
    head = ["angle", "range of the mean (deg)", "SD over cycles (deg)", "SD of the mean by the markers (deg)"]
    rows = [[f"{r['joint']} {r['name']}", *(number(r[k], 2) for k in _SPREADS)] for r in figures["cycles"]["angles"]]
    return Table(head, rows)


_SPREADS = ("mean_range_deg", "spread_median_deg", "noise_median_deg")


def angle_table(figures: dict[str, Any]) -> Table:
    """A row an angle; those beyond their normal range are marked."""
    head = ["angle", "frames", "least (deg)", "greatest (deg)", "range (deg)", "SD: median (deg)", "95 % (deg)"]
    head += ["normal (deg)", "beyond it", "by at most (deg)"]
    rows = []
    for row in figures["angles"]:
        normal = row["normal_deg"]
        rows.append(
            [
                f"{row['joint']} {row['name']}",
                number(row["frames"]),
                *(number(row[key], 1) for key in ("least_deg", "greatest_deg", "range_deg")),
                *(number(row[key], 2) for key in ("sd_median_deg", "sd_95_deg")),
                "–" if normal is None else f"{normal[0]:.0f} … {normal[1]:.0f}",
                percent(row["outside_share"]) if normal is not None else "–",
                number(row["outside_most_deg"], 1),
            ]
        )
    return Table(head, rows, marked=[row["outside_frames"] > 0 for row in figures["angles"]])
