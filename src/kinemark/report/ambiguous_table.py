"""The table of decisions that were close: one row a reason and trajectories, however often it came."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .formatting import number
from .tables import Table
from .words import reason_text

MOST_ROWS = 200  # shown; chosen for the page's size
MOST_TIMES = 6
"""Of one row; the others are counted; chosen."""

SILENT = "This method of tracking does not tell which of its decisions were close; the method simultaneous does."

Decisions = Sequence[dict[str, Any]]


def ambiguous_table(decisions: Decisions, *, listed: bool) -> Table:
    """A row for each reason about the same markers, the earliest first; `listed`: whether the tracking tells any."""
    rows = [_row(own) for own in grouped(decisions)] if listed else []
    more = f"And {len(rows) - MOST_ROWS} more, in quality.json." if len(rows) > MOST_ROWS else ""
    head = ["trajectories", "possible", "times", "when (s)", "what was seen"]
    return Table(head, rows[:MOST_ROWS], absent="None." if listed else SILENT, note=more, texts=True)


def grouped(decisions: Decisions) -> list[Decisions]:
    """Decisions of one kind about the same trajectories that were close for the same reason."""
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for decision in decisions:
        key = decision["kind"], *decision["trajectories"], decision["reason"]
        groups.setdefault(key, []).append(decision)
    return list(groups.values())


def _row(own: Decisions) -> list[str]:
    """The cells of one group."""
    first = own[0]
    times = [number(decision["time_s"], 2) for decision in own[:MOST_TIMES]]
    when = ", ".join(times) + (f" … {number(own[-1]['time_s'], 2)}" if len(own) > MOST_TIMES else "")
    return [" ".join(first["trajectories"]), first["kind"], str(len(own)), when, reason_text(own)]
