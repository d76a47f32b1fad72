"""A filled trial as one HTML page that needs no other file: every gap with its error, most of them drawn."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

from markupsafe import Markup

from ..data import Trajectories
from ..data.array_types import Floats
from ..findings.gaps import largest_error
from .figures_gaps import gap_figure
from .formatting import count, identity_text, measure, millimetres, number
from .tables import Table, Tile
from .templating import render, write_text
from .words import frames_text, open_gap_text

NAV = {"verdict": "Verdict", "gaps": "Every gap", "drawings": "Drawings", "terms": "Terms"}
MOST_DRAWN = 60
"""Gaps; the least certain come first; chosen (see benchmarks/pages.py)."""
MOST_LISTED = 3
"""Named in the table and drawn beside a gap; chosen."""
OPEN = "stayed open"
COUNTED = {"replaced": "trimmed", "suspicious": "suspicious"}
"""Samples beside a gap that are counted, and their figures."""


class GapDrawing(NamedTuple):
    """A gap on the page: of which marker, when, what became of it, and its picture."""

    marker: str
    when: str
    what: str
    picture: Markup


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
    write_text(path, filling_page(figures=figures, trajectories=trajectories, before=before))


def filling_page(*, figures: dict[str, Any], trajectories: Trajectories, before: Trajectories | None = None) -> str:
    """The page as text; parameters as those of `write_filling_page`."""
    gaps = figures["list"]
    drawn = sorted(gaps, key=_certain)[:MOST_DRAWN]
    version = f"Kinemark {figures['kinemark']}"
    which = "All gaps, those that stayed open and the least certain first"
    return render(
        "filling.html",
        library=None,
        heading=figures["source"],
        below=" · ".join([identity_text(figures.get("identity")), f"Filled by {figures['method']}", version]),
        nav=NAV,
        figures=figures,
        tiles=_tiles(figures),
        gap_table=gap_table(gaps, figures["limit_mm"]),
        which=which if len(drawn) == len(gaps) else f"The {len(drawn)} least certain of {len(gaps)} gaps",
        drawings=[_drawing(gap, figures["limit_mm"], trajectories, before) for gap in drawn],
    )


def _certain(gap: dict[str, Any]) -> tuple[bool, float, float]:
    """What gaps are sorted by, those that stayed open first, then the least certain."""
    return bool(gap["method"]), -largest_error(gap), -(gap["expected_mm"] or 0.0)


def gap_table(gaps: list[dict[str, Any]], limit_mm: float) -> Table:
    """A row a gap; those that stayed open are tinted, and say why in place of the markers that filled them.

    What no gap has (samples replaced, suspicious ones) has no column.
    """
    left_open = [not gap["method"] for gap in gaps]
    counted = {name: key for name, key in COUNTED.items() if any(gap[key] for gap in gaps)}
    head = ["marker", "frames", "length", "from (s)", "method", "expected (mm)", "next best", "largest σ (mm)", "tests"]
    rows = [
        [
            gap["marker"],
            frames_text(gap),
            number(gap["frames"]),
            number(gap["first_s"], 2),
            gap["method"] or OPEN,
            number(gap["expected_mm"], 2),
            _next_best(gap),
            number(gap["sd_max_mm"], 2),
            number(gap["tests"]),
            *(number(len(gap[key])) if gap[key] else "–" for key in counted.values()),
            _few(gap["reference_markers"]) if gap["method"] else open_gap_text(gap, limit_mm),
        ]
        for gap in gaps
    ]
    last = "from markers, or why it is open" if any(left_open) else "from markers"
    kept_in = "what kinemark fill --json prints"
    return Table([*head, *counted, last], rows, marked=left_open, absent="None.", kept_in=kept_in)


def _few(markers: list[str]) -> str:
    """The first of the markers that a gap was filled from."""
    more = f" and {len(markers) - MOST_LISTED} more" if len(markers) > MOST_LISTED else ""
    return (", ".join(markers[:MOST_LISTED]) + more) or "–"


def _next_best(gap: dict[str, Any]) -> str:
    """The best method but the one that was taken, with its error."""
    others = {name: mm for name, mm in gap["candidates_mm"].items() if mm is not None and name != gap["method"]}
    if not others:
        return "–"
    name = min(others, key=lambda method: others[method])
    return f"{name} {number(others[name], 2)}"


def _drawing(
    gap: dict[str, Any], limit_mm: float, trajectories: Trajectories, before: Trajectories | None
) -> GapDrawing:
    """One gap with its title; of a marker that is not in the trial and could not be placed, the title alone."""
    picture = Markup()
    if gap["marker"] in trajectories.names:
        start, references = gap["first_frame"] - trajectories.first_frame, tuple(gap["reference_markers"][:MOST_LISTED])
        dots = {} if before is None else _dots(before, gap)
        picture = gap_figure(trajectories, gap["marker"], start, start + gap["frames"], references, dots)
    what = f"{gap['method']}, expected {millimetres(gap['expected_mm'])}"
    if not gap["method"]:
        what = f"{OPEN}: {open_gap_text(gap, limit_mm)}"
    when = f"{number(gap['first_s'], 2)} s, {count(gap['frames'], 'frame')}"
    return GapDrawing(gap["marker"], when, what, picture)


def _dots(before: Trajectories, gap: dict[str, Any]) -> dict[int, Floats]:
    """What was measured in the frames that were replaced or are suspicious."""
    frames = [frame - before.first_frame for frame in (*gap["trimmed"], *gap["suspicious"])]
    return {frame: before[gap["marker"]].xyz[frame] for frame in frames} if gap["marker"] in before.names else {}


def _limit(limit_mm: float | None) -> str:
    """What the largest expected error is held against; JSON has no infinity and says None."""
    return "no limit" if limit_mm is None or math.isinf(limit_mm) else f"limit {limit_mm:.4g} mm"


def _tiles(figures: dict[str, Any]) -> list[Tile]:
    """The key figures."""
    names = ", ".join(f"{name} {n}" for name, n in figures["by_method"].items())
    typical, largest = (measure(figures[f"expected_{key}_mm"], 2, "mm") for key in ("median", "max"))
    missing = f"of {number(figures['missing_samples'])} before"
    return [
        Tile(f"{figures['filled']} of {figures['gaps']}", "gaps filled", names or "none"),
        Tile(typical, "expected error, median gap", "mean distance from the truth"),
        Tile(largest, "expected error, largest", _limit(figures["limit_mm"])),
        Tile(number(figures["missing_after"]), "samples still missing", missing),
    ]
