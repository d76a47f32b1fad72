"""What an operator answers while digitising, and how they type it.

312 204      a pixel of the marker              y  n      yes, no; y also takes what is proposed
-            the marker is not present          save      accept the frame; nothing is saved before
verify       go through the frame               hand      digitise the whole frame by hand
frame 12     look again at a saved frame        undo      take the last answer back
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True, slots=True)
class Point:
    """A pixel: any of the marker's, or, where a place is corrected, the very place."""

    u: float
    v: float


@dataclass(frozen=True, slots=True)
class Absent:
    """The marker is not present."""


@dataclass(frozen=True, slots=True)
class Yes:
    """It is right; or, what is proposed is."""


@dataclass(frozen=True, slots=True)
class No:
    """It is not right."""


@dataclass(frozen=True, slots=True)
class Accept:
    """Save the frame and go on."""


@dataclass(frozen=True, slots=True)
class Verify:
    """Go through the frame marker by marker."""


@dataclass(frozen=True, slots=True)
class ByHand:
    """Digitise the whole frame by hand."""


@dataclass(frozen=True, slots=True)
class Revisit:
    """Look again at a saved frame, counted from 0; what was not saved of the present one is dropped."""

    frame: int


@dataclass(frozen=True, slots=True)
class Undo:
    """Take the last answer back."""


Answer = Point | Absent | Yes | No | Accept | Verify | ByHand | Revisit | Undo


class Given(NamedTuple):
    """An answer: to which frame, counted from 0, and marker, empty where it is of the whole frame."""

    frame: int
    marker: str
    answer: Answer


FIXED: dict[str, Answer] = {
    "-": Absent(),
    "absent": Absent(),
    "y": Yes(),
    "yes": Yes(),
    "n": No(),
    "no": No(),
    "save": Accept(),
    "verify": Verify(),
    "hand": ByHand(),
    "undo": Undo(),
}
NUMBER = r"([-+]?\d+(?:\.\d*)?)"
POINT = re.compile(rf"{NUMBER}[\s,;]+{NUMBER}")
FRAME = re.compile(r"frame\s+(\d+)")


def parse_answer(text: str) -> Answer:
    """An answer as it is typed; frames count from 1.

    Raises:
        ValueError: it is none; the message says what there is.
    """
    text = text.strip().lower()
    if text in FIXED:
        return FIXED[text]
    if found := POINT.fullmatch(text):
        return Point(float(found[1]), float(found[2]))
    if found := FRAME.fullmatch(text):
        return Revisit(int(found[1]) - 1)
    raise ValueError(
        f"{text!r} is not understood; wanted a pixel as '312 204', '-' for not present, y, n, save, verify, hand, "
        "'frame 12' or undo"
    )


def answer_text(answer: Answer) -> str:
    """An answer as `parse_answer` reads it."""
    if isinstance(answer, Point):
        return f"{float(answer.u)!r} {float(answer.v)!r}"
    if isinstance(answer, Revisit):
        return f"frame {answer.frame + 1}"
    return next(text for text, known in FIXED.items() if known == answer)
