"""What became of edits when they were applied again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

from .edits import Edit

Outcome = Literal["held", "thin", "moot", "overruled", "orphan"]
"""What became of an edit: it stands; it stands on few of its witnesses; there is nothing left to do; a later one says
otherwise; it no longer finds its place."""

WORST_FIRST: tuple[Outcome, ...] = ("orphan", "thin", "held", "overruled", "moot")
"""The order in which the outcome of an entry follows from those of its edits."""


class Applied(NamedTuple):
    """What became of one edit of an entry.

    Attributes:
        entry: its number. edit: the edit. outcome: of it.
        share: of its witnesses that were found; 1 of edits without.
        samples: how many it is about now.
        reason: in words, where it does not stand; else empty.
    """

    entry: int
    edit: Edit
    outcome: Outcome
    share: float = 1.0
    samples: int = 0
    reason: str = ""


def entry_outcome(applied: Sequence[Applied]) -> Outcome:
    """Of an entry, from those of its edits."""
    return min((one.outcome for one in applied), key=WORST_FIRST.index)
