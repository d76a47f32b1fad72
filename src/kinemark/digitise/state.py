"""States, questions and answers of digitising: plain values."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum, IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Floats, Ints
from ..data.arrays import column, set_columns


class MarkerStatus(IntEnum):
    """How a marker of a frame came to its place."""

    OPEN = 0
    NOT_PRESENT = 1
    AUTOMATIC = 2
    POINTED = 3
    PLACED = 4
    PROPOSED = 5
    AMBIGUOUS = 6


@dataclass(frozen=True, slots=True, eq=False)
class DigitisedFrame:
    """One frame of M markers.

    Attributes:
        uv: (M, 2) px where they are seen in the image; NaN where not present, or not known yet.
        found: (M) a `MarkerStatus` each.
        shift: (2,) px of the image, as the reference marker shows it.
    """

    uv: Floats
    found: NDArray[np.uint8]
    shift: Floats

    def __post_init__(self) -> None:
        n = len(self.uv)
        set_columns(
            self,
            uv=column("uv", self.uv, np.float64, n, 2),
            found=column("found", self.found, np.uint8, n),
            shift=column("shift", self.shift, np.float64, 2),
        )

    @classmethod
    def blank(cls, n: int) -> DigitisedFrame:
        """Nothing is known of n markers."""
        return cls(np.full((n, 2), np.nan), np.zeros(n, np.uint8), np.zeros(2))

    @property
    def open(self) -> Ints:
        """The markers that nothing is settled of yet, ambiguous ones among them."""
        return np.flatnonzero(np.isin(self.found, (MarkerStatus.OPEN, MarkerStatus.AMBIGUOUS)))

    def put(self, marker: int, uv: Floats | None, found: MarkerStatus) -> DigitisedFrame:
        """The frame with a marker at (2,) px, or nowhere."""
        places, how = self.uv.copy(), self.found.copy()
        places[marker], how[marker] = (np.nan if uv is None else uv), found
        return replace(self, uv=places, found=how)


class DigitisingPhase(Enum):
    """What is asked."""

    POINT = "point"
    REFERENCE = "reference"
    REVIEW = "review"
    VERIFY = "verify"
    CORRECT = "correct"
    DONE = "done"


class PlaceProposal(NamedTuple):
    """What other cameras say of a missing marker: uv (2,) px, NaN if only that it is hidden; and whether it is seen."""

    uv: Floats
    seen: bool


class AskedQuestion(NamedTuple):
    """A question that was put to the operator and why, and whether they took the proposal.

    The reason "unasked" stands for a proposal that was taken without a question.
    """

    frame: int
    marker: int
    reason: str
    proposed: bool


class Question(NamedTuple):
    """What a state asks.

    Attributes:
        phase: the kind of question.
        frame: counted from 0.
        marker: index; −1 where the question is of the whole frame.
        name: the marker's.
        uv: (2,) px where it is, or where it was expected; NaN where neither is known.
        proposal: of other cameras, where there is one.
        ambiguous: the marker is asked for because two images would do.
    """

    phase: DigitisingPhase
    frame: int
    marker: int
    name: str
    uv: Floats
    proposal: PlaceProposal | None = None
    ambiguous: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class DigitisingState:
    """Digitising of one camera's F frames at one moment.

    Attributes:
        saved: (F) what was accepted of each frame, else None.
        frame: the present one.
        draft: what is known of it; nothing of it is saved yet.
        phase: what is asked.
        marker: of which marker; −1 for none.
        constant: (2,) px where the reference marker was at the calibration; None where the first frame says it.
        searched: whether the machine has looked for the markers of this frame.
        proposal: what other cameras say of the marker asked for.
        asked: all questions answered so far, those that were taken back as well.
        before: the state before the last answer.
    """

    saved: tuple[DigitisedFrame | None, ...]
    frame: int
    draft: DigitisedFrame
    phase: DigitisingPhase
    marker: int = -1
    constant: Floats | None = None
    searched: bool = True
    proposal: PlaceProposal | None = None
    asked: tuple[AskedQuestion, ...] = ()
    before: DigitisingState | None = field(default=None, repr=False)


def words(question: Question) -> str:
    """A question for the operator; frames count from 1."""
    frame, who = f"Frame {question.frame + 1}", f"marker {question.name}"
    place = "" if np.isnan(question.uv).any() else f" near ({question.uv[0]:.0f}, {question.uv[1]:.0f})"
    if question.phase is DigitisingPhase.POINT:
        where = f", expected{place}" if place else ""
        why = " Two images would do." if question.ambiguous else ""
        return f"{frame}: point at {who}{where}, or - if it is not present.{why}{_proposed(question)}"
    return {
        DigitisingPhase.REFERENCE: f"{frame}: is the reference marker the one{place}? y or n",
        DigitisingPhase.REVIEW: f"{frame}: all markers are settled. save, verify, hand, frame N or undo",
        DigitisingPhase.VERIFY: f"{frame}: {who} is {'not present' if not place else place[6:]}. Right? y or n",
        DigitisingPhase.CORRECT: f"{frame}: give the place of {who}, or - if it is not present.",
        DigitisingPhase.DONE: "All frames are saved.",
    }[question.phase]


def _proposed(question: Question) -> str:
    """What other cameras propose."""
    said = question.proposal
    if said is None:
        return ""
    place = "" if np.isnan(said.uv).any() else f" at ({said.uv[0]:.1f}, {said.uv[1]:.1f})"
    return f" The other cameras say: {'it is' if said.seen else 'hidden'}{place}. y takes that."
