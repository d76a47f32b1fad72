"""Questions in the operator's words, and answers as he types them.

312 204      a pixel of the marker              y  n      yes, no; y also takes what is proposed
-            the marker is not present          save      accept the frame; nothing is saved before
verify       go through the frame               hand      digitise the whole frame by hand
frame 12     look again at a saved frame        undo      take the last answer back
"""

from __future__ import annotations

import re

import numpy as np

from .state import Absent, Accept, Answer, ByHand, DigitisingPhase, No, Point, Question, Revisit, Undo, Verify, Yes

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


def words(question: Question) -> str:
    """A question for the operator; frames count from 1."""
    frame, who = f"Frame {question.frame + 1}", f"marker {question.name}"
    place = "" if np.isnan(question.uv).any() else f" near ({question.uv[0]:.0f}, {question.uv[1]:.0f})"
    if question.phase is DigitisingPhase.POINT:
        where = f", expected{place}" if place else ""
        why = " Two images would do." if question.in_doubt else ""
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
