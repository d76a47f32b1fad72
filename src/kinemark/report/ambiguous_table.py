"""The table of decisions that were close: one row for the same doubt about the same markers, however often it came."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape
from typing import Any

from .formatting import number
from .html_tables import table

MOST_ROWS = 200
MOST_TIMES = 6
"""Of one row; the others are counted."""

SILENT = "This method of tracking does not tell which of its decisions were close; the method simultaneous does."

Doubts = Sequence[dict[str, Any]]


def ambiguous_table(doubts: Doubts, *, told: bool) -> str:
    """A row for each doubt about the same markers, the earliest first; `told`: whether the tracking tells doubts."""
    if not told:
        return f"<p>{escape(SILENT)}</p>"
    rows = [_row(own) for own in grouped(doubts)]
    more = f"<p>And {len(rows) - MOST_ROWS} more, in quality.json.</p>" if len(rows) > MOST_ROWS else ""
    head = ["trajectories", "possible", "times", "when (s)", "what was seen"]
    return f'<div class="texts">{table(head, rows[:MOST_ROWS])}</div>{more}' if rows else "<p>None.</p>"


def grouped(doubts: Doubts) -> list[Doubts]:
    """Doubts of one kind about the same trajectories whose reasons differ in their numbers only."""
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for doubt in doubts:
        key = doubt["kind"], *doubt["trajectories"], re.sub(NUMBER, "", doubt["reason"])
        groups.setdefault(key, []).append(doubt)
    return list(groups.values())


NUMBER = r"\d+(?:\.\d+)?"


def _row(own: Doubts) -> list[str]:
    """The cells of one group."""
    first = own[0]
    times = [number(doubt["time_s"], 2) for doubt in own[:MOST_TIMES]]
    when = ", ".join(times) + (f" … {number(own[-1]['time_s'], 2)}" if len(own) > MOST_TIMES else "")
    reason = _spanned([doubt["reason"] for doubt in own])
    return [" ".join(first["trajectories"]), first["kind"], str(len(own)), when, reason]


def _spanned(reasons: list[str]) -> str:
    """One text for reasons that differ in their numbers only: these from the least to the greatest."""
    values = [[float(text) for text in re.findall(NUMBER, reason)] for reason in reasons]
    spans = [(min(column), max(column)) for column in zip(*values, strict=True)]
    texts = iter(f"{low:g}" if low == high else f"{low:g}–{high:g}" for low, high in spans)
    return re.sub(NUMBER, lambda _: next(texts), reasons[0])
