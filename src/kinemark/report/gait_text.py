"""Gait, as a few lines for the terminal."""

from __future__ import annotations

from typing import Any

from .formatting import count, number
from .gait_comparison_page import (
    JUDGED,
    differing_table,
    error_holds,
    key_values_table,
    not_judged,
    other_subject,
    parameters_table,
    strides_compared,
)
from .gait_page import NAMES, SHOWN
from .terminal_summary import finding_lines
from .words import headline_of, sentences_of


def gait_summary(figures: dict[str, Any]) -> str:
    """A short plain text: verdict, a line a time-distance parameter, findings."""
    lines = [f"{figures['subject'] or 'gait'}: {headline_of(figures['verdict'])}"]
    lines += [f"  {sentence}" for sentence in sentences_of(figures["verdict"])]
    each = figures["time_distance"]
    sides = [side for side in ("left", "right") if any(one["mean"] is not None for one in each[side].values())]
    lines += ["", f"  {'':32s}" + "".join(f" {side:>8s}" for side in sides)] if sides else []
    for name, title in NAMES.items() if sides else ():
        unit, by, digits = SHOWN[figures["units"][name]]
        means = [each[side][name]["mean"] for side in sides]
        shown = ["–" if mean is None else number(mean / by, digits) for mean in means]
        lines.append(f"  {title + ' (' + unit + ')':32s}" + "".join(f" {text:>8s}" for text in shown))
    lines += ["", *finding_lines(figures["findings"])]
    return "\n".join(lines).rstrip() + "\n"


def comparison_summary(figures: dict[str, Any]) -> str:
    """What differs, a line each."""
    one, two = figures["conditions"]
    rows = [*differing_table(figures).rows]
    lines = [*filter(None, [" ".join(other_subject(figures))]), strides_compared(figures)]
    lines += [*filter(None, [not_judged(figures)])]
    lines += [error_holds(figures)] if figures["without_uncertainty"] else []
    many = count(len(rows), "component of a curve differs", "components of curves differ")
    lines += [f"“{two['name']}” minus “{one['name']}”: {many} by more than the error."]
    lines += [f"  {row[0]:34s} {row[2]:>22s}  {row[3]:>12s}   {row[1]}" for row in rows]
    numbers = [*parameters_table(figures).rows, *key_values_table(figures).rows]
    differing = [row for row in numbers if row[-1] == JUDGED[True]]
    unknown = sum(row[-1] == JUDGED[None] for row in numbers)
    of = f"Of {count(len(numbers), 'number')} (time and distance, key values), {len(differing)} by more"
    lines += [f"{of}; {unknown} {'is' if unknown == 1 else 'are'} not judged." if unknown else f"{of}."]
    lines += [f"  {row[0]:60s} {row[3]:>8s}  {row[4]:>8s}" for row in differing]
    return "\n".join(lines) + "\n"
