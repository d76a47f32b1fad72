"""The joint angles as one HTML page that needs nothing else, in the style of the report."""

from __future__ import annotations

from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from ..data import Angles
from ..io.files import replacing
from ..kinematics import Cycles, Model
from ..kinematics.chain import Points
from .figures_angles import cycle_figure, joint_figure
from .formatting import number, percent
from .html_tables import finding_list, paragraphs, table
from .page import figure_html, framed
from .stick import stick_html
from .words import headline_of, sentences_of

NAV = {"verdict": "Verdict", "limb": "The limb", "angles": "Angles", "cycles": "Cycles", "terms": "Terms"}
"""Sections of the page, in their order."""


def write_angles_page(
    path: Path | str,
    *,
    figures: dict[str, Any],
    angles: Angles,
    model: Model,
    points: Points,
    cycles: Cycles | None = None,
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page, usually `angles.html`.
        figures: of `angles.angle_figures`.
        angles, model, cycles: what is drawn; points: (F, 3) mm by name, of the stick figure.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    html = angles_page(figures=figures, angles=angles, model=model, points=points, cycles=cycles)
    with replacing(path) as beside:
        beside.write_text(html, encoding="utf-8")


def angles_page(
    *, figures: dict[str, Any], angles: Angles, model: Model, points: Points, cycles: Cycles | None = None
) -> str:
    """The page as text."""
    first = figures["first_frame"]
    main = Template(files(__package__).joinpath("angles.html").read_text(encoding="utf-8")).substitute(
        grade=figures["verdict"]["grade"],
        headline=escape(headline_of(figures["verdict"])),
        sentences=paragraphs(sentences_of(figures["verdict"])),
        warnings=finding_list(figures["findings"]),
        directions=escape(f"forward {model.forward}, up {model.up}"),
        stick=stick_html(points, angles, model, first_frame=first),
        joints="".join(_joint_card(angles, model, j, first) for j in range(len(model.joints))),
        angle_table=angle_table(figures),
        cycles="" if cycles is None else _cycle_section(cycles, model, figures),
        model=escape(f"{model.name}, {model.side} side. {model.source}"),
        **{key: escape(str(figures[key])) for key in ("method", "noise", "smoothing")},
        lock=number(figures["lock_deg"]),
    )
    nav = {place: name for place, name in NAV.items() if cycles is not None or place != "cycles"}
    heading, version = f"{figures['trial']}: joint angles", figures["kinemark"]
    return framed(main, heading=heading, below=f"Model {figures['model']} · Kinemark {version}", nav=nav)


def _joint_card(angles: Angles, model: Model, j: int, first_frame: int) -> str:
    joint = model.joints[j]
    turns = ", ".join(letter + "′" * i for i, letter in enumerate(joint.sequence))
    text = (
        f"{joint.child} against {joint.parent}, turns about {turns}. The band holds 95 %; dotted lines limit normal "
        "motion, red is beyond it, orange grounds are gimbal lock."
    )
    fig = figure_html(f"joint{j}", joint_figure(angles, model, j, first_frame=first_frame))
    return f'<div class="card"><h3>{escape(joint.name.capitalize())}</h3><p>{escape(text)}</p>{fig}</div>'


def _cycle_section(cycles: Cycles, model: Model, figures: dict[str, Any]) -> str:
    cards = []
    for j, joint in enumerate(model.joints):
        text = "Thin lines are the cycles, the thick one their mean; the band is ± SD over the cycles."
        fig = figure_html(f"cycle{j}", cycle_figure(cycles, model, j))
        cards.append(f'<div class="card"><h3>{escape(joint.name.capitalize())}</h3><p>{text}</p>{fig}</div>')
    head = ["angle", "range of the mean (deg)", "SD over cycles (deg)", "SD of the mean by the markers (deg)"]
    rows = [[f"{r['joint']} {r['name']}", *(number(r[k], 2) for k in _SPREADS)] for r in figures["cycles"]["angles"]]
    body = f'{"".join(cards)}<div class="card long"><h3>Every angle</h3>{table(head, rows)}</div>'
    return f'<section id="cycles"><h2>Cycles</h2>{body}</section>'


_SPREADS = ("mean_range_deg", "spread_median_deg", "noise_median_deg")


def angle_table(figures: dict[str, Any]) -> str:
    """A row an angle; those beyond their normal range are marked."""
    head = ["angle", "frames", "least (deg)", "greatest (deg)", "range (deg)", "SD: middle (deg)", "95 % (deg)"]
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
    return table(head, rows, marked=[row["outside_frames"] > 0 for row in figures["angles"]])
