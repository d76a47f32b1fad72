"""Gaps that somebody chose a method for, or to leave open."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..data import Trajectories
from ..data.edits import BEST, OPEN, GapChoice
from .marker_array import Gap, MarkerArray, find_gaps
from .methods.stage import FILL


def chosen_gaps(motion: MarkerArray, trajectories: Trajectories, choices: Sequence[GapChoice]) -> dict[Gap, str]:
    """What was chosen for each gap that a choice is about, at the ends of the trial too; a later choice counts more."""
    found = dict[Gap, str]()
    if not choices:
        return found
    for gap in find_gaps(motion, ends=True):
        first, last = gap.start + trajectories.first_frame, gap.stop - 1 + trajectories.first_frame
        mine = [c for c in choices if c.marker == motion.names[gap.marker] and c.first <= last and c.last >= first]
        if mine:
            found[gap] = mine[-1].method
    return found


def groups(chosen: dict[Gap, str], candidates: Sequence[Any]) -> list[tuple[list[Gap], Sequence[Any]]]:
    """The gaps that are to be filled as chosen, by their methods; `candidates` are those of "best".

    Raises:
        ValueError: a choice is no method that fills.
    """
    names = dict.fromkeys(name for name in chosen.values() if name != OPEN)
    check_choices(names)
    return [
        ([gap for gap, name in chosen.items() if name == one], candidates if one == BEST else (FILL.make(one),))
        for one in names
    ]


def check_choices(names: Sequence[str] | dict[str, None]) -> None:
    """Raises a ValueError where a name is neither a method of filling nor a choice."""
    for name in names:
        if name not in (BEST, OPEN) and name not in FILL:
            raise ValueError(f"{name!r} is no method of filling; wanted {BEST}, {OPEN} or one of {', '.join(FILL)}")
