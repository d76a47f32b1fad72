"""Questions in the operator's words; `data.answers` has the answers as they type them."""

from __future__ import annotations

import numpy as np

from .state import DigitisingPhase, Question


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
