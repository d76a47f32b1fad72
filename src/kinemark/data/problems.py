"""Problems of a trial: what is probably wrong with it, what it would cost, and what can be said to mend it.

Each problem has alternatives, the present state among them, and each alternative says by which edits it is taken. A
problem that somebody decided is not shown again: every alternative holds a verdict, or an edit after which there is
nothing left to ask.

Expected costs are in mm times samples: with p the probability that a marker's samples are wrong, n of them, and m mm by
which they then are off, p n m.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from .edits import Edit

ASK_ABOVE = 0.05
"""Probability below which a problem is not worth a look: the stop rule; chosen: one in twenty is a false alarm's
rate that people still look at."""

ProblemKind = Literal[
    "swap", "join", "ghost", "spike", "filled", "label", "sides", "lost", "repeated", "moved", "shaken", "gap", "edit",
]  # fmt: skip
"""Two paths that go on as each other's; two pieces that are one marker, or a path that is two; a path that is no
marker; samples that jump away and back, or that nobody measured, as they stand still or go straight; a name that fits
no distance; left and right; frames that all markers lost, or repeat; a world that is another from a frame on, or for
some frames; missing samples; an edit that no longer finds its place."""

OF_WHOLE: tuple[ProblemKind, ...] = ("lost", "repeated", "moved", "shaken")
"""Kinds that are about all markers at once."""

OF_IDENTITY: tuple[ProblemKind, ...] = ("swap", "join", "ghost", "spike", "filled", "label", "sides", *OF_WHOLE)
"""Kinds that are errors where they are right; a gap and an edit that is an orphan are there for certain."""

Action = Literal[
    "keep", "exchange", "cut", "join", "no_marker", "erase", "mend", "rename", "fill", "leave_open", "drop_edit",
    "wait", "note",
]  # fmt: skip
"""What an alternative does; `mend` erases and cuts at several places, `note` says that it is so where no edit mends
it."""


@dataclass(frozen=True, slots=True)
class Alternative:
    """One way to settle a problem.

    Attributes:
        action: what it does. words: the same in a line.
        probability: that it is the right one, 0 to 1; NaN where nothing tells, as of ways to fill.
        cost: expected, mm times samples, of what is wrong where it is taken.
        jump_mm: how far the paths are from where their motion leads, at the place; NaN where it is not about motion.
        images: that are explained by a marker there; None where there are no cameras.
        edits: what it would say; empty where nothing must be said.
    """

    action: Action
    words: str
    probability: float
    cost: float
    jump_mm: float = float("nan")
    images: int | None = None
    edits: tuple[Edit, ...] = ()


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing to look at.

    Attributes:
        id: the same when the trial is processed again and the problem is still there.
        kind: of it. tracks: trajectories that it is about, as they are called now.
        first, last: frames, numbers in the recording; frame: the one to look at.
        wrong: probability, 0 to 1, that the trial is wrong here as it is.
        at_stake: samples that are then wrong. cost: expected, mm times samples, of leaving it as it is.
        words: what it is, in a line.
        alternatives: what can be done, the one of least expected cost first.
        values: numbers behind it, such as jump_mm or log_odds.
    """

    id: str
    kind: ProblemKind
    tracks: tuple[str, ...]
    first: int
    last: int
    frame: int
    wrong: float
    at_stake: int
    cost: float
    words: str
    alternatives: tuple[Alternative, ...] = ()
    values: Mapping[str, float] = field(default_factory=dict)

    @property
    def asked(self) -> bool:
        """Whether it is worth a look."""
        return self.wrong >= ASK_ABOVE

    @property
    def errors(self) -> float:
        """Expected number of errors of identity in it: of several that are looked at together their sum."""
        return self.values.get("errors", self.wrong) if self.kind in OF_IDENTITY else 0.0


@dataclass(frozen=True, slots=True)
class Problems:
    """What is to be looked at in a trial.

    Attributes:
        items: problems, the one whose looking at saves most first; those below the stop rule come last.
        head: of the journal that they follow from.
    """

    items: tuple[Problem, ...] = ()
    head: str = ""

    @property
    def asked(self) -> tuple[Problem, ...]:
        """Those worth a look."""
        return tuple(one for one in self.items if one.asked)

    @property
    def errors(self) -> float:
        """Expected number of errors of identity now."""
        return sum(one.errors for one in self.items)

    @property
    def errors_left(self) -> float:
        """Expected number of errors that are left when all that is worth a look was put right."""
        return sum(one.errors for one in self.items if not one.asked)

    def __getitem__(self, identity: str) -> Problem:
        for one in self.items:
            if one.id == identity:
                return one
        raise KeyError(f"no problem {identity!r}")


def problem_id(kind: str, *parts: object) -> str:
    """An id from what stays the same when a trial is processed again."""
    text = "/".join(map(str, (kind, *parts)))
    return f"{kind}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"
