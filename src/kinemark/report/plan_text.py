"""A plan of cameras as a few lines for the terminal."""

from __future__ import annotations

from typing import Any

from .formatting import number
from .words import advice_of, headline_of, sentences_of


def plan_summary(figures: dict[str, Any]) -> str:
    """Verdict, and a line a camera."""
    verdict = figures["verdict"]
    lines = [headline_of(verdict), *(f"  {sentence}" for sentence in sentences_of(verdict))]
    if verdict["grade"] != "green":
        lines.append(f"  {advice_of(verdict['statements'][0])}")
    lines += ["", f"  {'camera':12s}        x (mm)  y (mm)  z (mm)   heading   tilt"]
    rows = [(row["name"], "stands" if row["given"] else "new", row) for row in figures["cameras"]]
    rows += [("one more", "next", figures["following"])] if figures["following"] else []
    for name, state, row in rows:
        x, y, z = (number(value, 0) for value in row["position_mm"])
        heading, tilt = number(row["heading_deg"], 0), number(row["tilt_deg"], 0)
        lines.append(f"  {name:12s} {state:6s} {x:>7s} {y:>7s} {z:>7s} {heading + '°':>9s} {tilt + '°':>6s}")
    return "\n".join(lines)
