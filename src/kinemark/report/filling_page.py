"""A filled trial as one HTML page that needs nothing else: every gap with its error, most of them drawn."""

from __future__ import annotations

from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from ..data import Trajectories
from ..findings.gaps import largest_error
from ..io.files import replacing
from .figures_gaps import gap_figure
from .formatting import count, measure, millimetres, number
from .html_tables import finding_list, paragraphs, table
from .page import framed
from .words import headline_of, sentences_of

NAV = {"verdict": "Verdict", "gaps": "Every gap", "drawings": "Drawings", "terms": "Terms"}
MOST_DRAWN = 300
"""Gaps; the least certain come first; chosen."""
MOST_DONORS = 3
"""Named in the table and drawn beside a gap; chosen."""
OPEN = "stayed open"


def write_filling_page(
    path: Path | str, *, figures: dict[str, Any], trajectories: Trajectories, before: Trajectories | None = None
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page.
        figures: of `filling.filling_figures`.
        trajectories: the trial after filling.
        before: the trial before it, to draw the samples that were replaced.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    html = filling_page(figures=figures, trajectories=trajectories, before=before)
    with replacing(path) as beside:
        beside.write_text(html, encoding="utf-8")


def filling_page(*, figures: dict[str, Any], trajectories: Trajectories, before: Trajectories | None = None) -> str:
    """The page as text; parameters as those of `write_filling_page`."""
    verdict, gaps = figures["verdict"], figures["list"]
    drawn = sorted(gaps, key=_certain)[:MOST_DRAWN]
    which = "All gaps, those that stayed open and the least certain first"
    template = Template(files(__package__).joinpath("filling.html").read_text(encoding="utf-8"))
    main = template.substitute(
        grade=verdict["grade"],
        headline=escape(headline_of(verdict)),
        sentences=paragraphs(sentences_of(verdict)),
        tiles=_tiles(figures),
        warnings=finding_list(figures["findings"]),
        gap_table=gap_table(gaps),
        drawn=which if len(drawn) == len(gaps) else f"The {len(drawn)} least certain of {len(gaps)} gaps",
        drawings="".join(_drawing(gap, trajectories, before) for gap in drawn) or "<p>None.</p>",
        version=escape(figures["kinemark"]),
    )
    below = f"Filled by {figures['method']} · Kinemark {figures['kinemark']}"
    return framed(main, heading=figures["source"], below=below, nav=NAV, plots=False)


def _certain(gap: dict[str, Any]) -> tuple[bool, float, float]:
    """What gaps are sorted by, those that stayed open first, then the least certain."""
    return bool(gap["method"]), -largest_error(gap), -(gap["expected_mm"] or 0.0)


def gap_table(gaps: list[dict[str, Any]]) -> str:
    """A row a gap; those that stayed open are tinted, and say why."""
    left_open = [not gap["method"] for gap in gaps]
    head = [
        "marker",
        "from (s)",
        "length (s)",
        "frames",
        "method",
        "expected (mm)",
        "next best",
        "σ worst (mm)",
        "tests",
        "replaced",
        "from markers",
        *(["why it is open"] if any(left_open) else []),
    ]
    rows = [
        [
            gap["marker"],
            number(gap["first_s"], 2),
            number(gap["length_s"], 2),
            f"{gap['first_frame']}–{gap['last_frame']}",
            gap["method"] or OPEN,
            number(gap["expected_mm"], 2),
            _next_best(gap),
            number(gap["sd_max_mm"], 2),
            number(gap["tests"]),
            number(len(gap["trimmed"])) if gap["trimmed"] else "–",
            _few(gap["reference_markers"]),
            *([gap["reason"] or "–"] if any(left_open) else []),
        ]
        for gap in gaps
    ]
    return table(head, rows, marked=left_open) if rows else "<p>None.</p>"


def _few(donors: list[str]) -> str:
    """The first of the markers that a gap was filled from."""
    more = f" and {len(donors) - MOST_DONORS} more" if len(donors) > MOST_DONORS else ""
    return (", ".join(donors[:MOST_DONORS]) + more) or "–"


def _next_best(gap: dict[str, Any]) -> str:
    """The best method but the one that was taken, with its error."""
    others = {name: mm for name, mm in gap["candidates_mm"].items() if mm is not None and name != gap["method"]}
    if not others:
        return "–"
    name = min(others, key=lambda method: others[method])
    return f"{name} {number(others[name], 2)}"


def _drawing(gap: dict[str, Any], trajectories: Trajectories, before: Trajectories | None) -> str:
    """One gap with its title; of a marker that is not in the trial and could not be placed, the title alone."""
    picture = ""
    if gap["marker"] in trajectories.names:
        start, donors = gap["first_frame"] - trajectories.first_frame, tuple(gap["reference_markers"][:MOST_DONORS])
        replaced = [] if before is None else [frame - before.first_frame for frame in gap["trimmed"]]
        dots = {frame: before[gap["marker"]].xyz[frame] for frame in replaced} if before is not None else {}
        picture = gap_figure(trajectories, gap["marker"], start, start + gap["frames"], donors, dots)
    what = (
        f"{gap['method']}, expected {millimetres(gap['expected_mm'])}" if gap["method"] else f"{OPEN}: {gap['reason']}"
    )
    when = f"{number(gap['first_s'], 2)} s, {count(gap['frames'], 'frame')}"
    return f'<div class="gap"><b>{escape(gap["marker"])}</b> {escape(when)} · {escape(what)}{picture}</div>'


def _tiles(figures: dict[str, Any]) -> str:
    """The key figures, each with its meaning below."""
    names = ", ".join(f"{name} {n}" for name, n in figures["by_method"].items())
    rows = [
        (f"{figures['filled']} of {figures['gaps']}", "gaps filled", names or "none"),
        (measure(figures["expected_median_mm"], 2, "mm"), "expected error, middle gap", "mean distance from the truth"),
        (
            measure(figures["expected_max_mm"], 2, "mm"),
            "expected error, worst gap",
            f"limit {figures['limit_mm']} mm",
        ),
        (number(figures["missing_after"]), "samples still missing", f"of {number(figures['missing_samples'])} before"),
    ]
    return "".join(
        f'<div class="tile"><b>{escape(value)}</b><span>{escape(name)}</span><small>{escape(more)}</small></div>'
        for value, name, more in rows
    )
