"""What limits a recording, as a few lines for the terminal."""

from __future__ import annotations

from typing import Any

from .formatting import degrees, number, percent
from .words import evidence_text, headline_of, sentences_of


def sensitivity_summary(figures: dict[str, Any]) -> str:
    """Verdict and ranked table for the terminal."""
    n = figures["cycles"]
    lines = [f"{figures['session']} / {figures['trial']}: {headline_of(figures['verdict'])}"]
    lines += [f"  {sentence}" for sentence in sentences_of(figures["verdict"])]
    lines += ["", f"  {'source':18s}   px      mm   angle   mean of {n}   variance   how it is known"]
    for row in figures["ranking"]:
        lines.append(
            f"  {row['source']:18s} {number(row['px'], 3):>6s} {number(row['mm'], 2):>6s} {degrees(row['deg']):>7s} "
            f"{degrees(row['mean_deg']):>11s} {percent(row['variance_share']):>10s}   {evidence_text(row)}"
        )
    total = figures["total"]
    lines.append(
        f"  {'all together':18s} {'':6s} {number(total['mm'], 2):>6s} {degrees(total['deg']):>7s} "
        f"{degrees(total['mean_deg']):>11s}"
    )
    lines += [
        f"  {'without ' + row['camera']:18s} {'':6s} {number(row['mm'], 2):>6s} {degrees(row['deg']):>7s}"
        f"   of the cameras' part alone, {percent(row['gone_share'])} of points gone"
        for row in figures["lost"][:3]
    ]
    return "\n".join(lines) + "\n"
