"""An operator at a terminal: questions are printed, answers are typed."""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats
from ..digitise import (
    Answer,
    DigitisingPhase,
    DigitisingState,
    DigitisingStopped,
    ImageMarkers,
    Point,
    Question,
    clicked,
    parse_answer,
    words,
)
from ..engine.digitising.files import DigitisedFrames

NEAR = 6
"""Markers of an image that are listed; chosen."""


class Terminal:
    """An operator at a terminal: questions are printed, answers are typed.

    Args:
        reel: shows the markers near to where one is expected.
    """

    def __init__(self, reel: DigitisedFrames) -> None:
        self._reel = reel

    def __call__(self, question: Question, state: DigitisingState) -> Answer:
        """What was typed.

        Raises:
            DigitisingStopped: quit was, or nothing more comes.
        """
        say(words(question))
        if question.phase in (DigitisingPhase.POINT, DigitisingPhase.CORRECT):
            say(nearby(self._reel(question.frame), question.uv))
        while True:
            text = typed()
            if text is None or text.strip().lower() == "quit":
                raise DigitisingStopped
            try:
                return parse_answer(text)
            except ValueError as error:
                say(f"  {error}, or quit")


def nearby(found: ImageMarkers, uv: Floats) -> str:
    """The markers of the image, those near to uv (2,) first."""
    order = np.argsort(np.hypot(*(found.uv - uv).T)) if np.isfinite(uv).all() else np.arange(len(found.uv))
    places = "   ".join(f"{found.uv[k, 0]:.0f} {found.uv[k, 1]:.0f}" for k in order[:NEAR])
    return f"  white: {places or 'nothing'}{' …' if len(order) > NEAR else ''}"


def typed() -> str | None:
    """A line from the terminal; None where no more come."""
    sys.stdout.write("> ")
    sys.stdout.flush()
    return sys.stdin.readline() or None


def pointed(found: ImageMarkers, what: str, at: str | None) -> Floats:
    """(2,) px the centroid of what an operator points at, who is asked until it is a marker."""
    if at is not None:
        return _centroid(found, what, at)
    while True:
        say(f"Point at {what}.\n{nearby(found, np.full(2, np.nan))}")
        text = typed()
        if text is None or text.strip().lower() == "quit":
            raise KinemarkError(f"DigitisingStopped before {what} was digitised, and nothing is written.")
        try:
            return _centroid(found, what, text)
        except KinemarkError as error:
            say(f"  {error}")


def _centroid(found: ImageMarkers, what: str, text: str) -> Floats:
    """(2,) px of the marker at a pixel that is written as '312 204'."""
    try:
        answer = parse_answer(text)
    except ValueError:
        answer = None
    if not isinstance(answer, Point):
        raise KinemarkError(f"{text.strip()!r} is no pixel of {what}. Say it as '312 204'.")
    return np.asarray(found.uv[clicked(found, np.array([answer.u, answer.v]))])


def say(value: Any, *, file: Any = None) -> None:
    """Text as it is, anything else as JSON."""
    out = file or sys.stdout
    out.write((value if isinstance(value, str) else json.dumps(value, indent=1)) + "\n")
    out.flush()
