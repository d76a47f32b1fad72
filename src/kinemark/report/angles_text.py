"""Joint angles, as a few lines for the terminal."""

from __future__ import annotations

from typing import Any

from .formatting import number
from .terminal_summary import finding_lines
from .words import headline_of, sentences_of


def angle_summary(figures: dict[str, Any]) -> str:
    """A short plain text: verdict, a line an angle, findings."""
    rows = figures["angles"]
    width = max(len(f"{row['joint']} {row['name']}") for row in rows) if rows else 0
    lines = [f"{figures['trial']}: {headline_of(figures['verdict'])}"]
    lines += [f"  {sentence}" for sentence in sentences_of(figures["verdict"])]
    lines += ["", f"  {'angle, deg':{width}s}   least  greatest    SD  outside"]
    for row in rows:
        lines.append(
            f"  {row['joint'] + ' ' + row['name']:{width}s}  {number(row['least_deg'], 1):>6s}  "
            f"{number(row['greatest_deg'], 1):>8s}  {number(row['sd_median_deg'], 2):>4s}  "
            f"{number(row['outside_frames']):>7s}"
        )
    lines += ["", *finding_lines(figures["findings"])]
    return "\n".join(lines).rstrip() + "\n"
