"""Digitising from the first frame to the last, with whoever answers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import KinemarkError
from ..data.answers import Answer
from ..data.array_types import Floats
from .machine import ImageSource, Proposer, advance, begin, question_of
from .semi_automatic import DIGITISE, SemiAutomatic
from .state import DigitisingPhase, DigitisingState, MarkerStatus, Question

Operator = Callable[[Question, DigitisingState], Answer]
"""Answers a question; the state is there to be drawn."""


REASONS = ("first_two_frames", "not_found", "ambiguous", "reference")
"""Why the operator is asked."""


class DigitisingStopped(Exception):
    """The operator stops; what they saved stands."""


class DigitisedImages(NamedTuple):
    """What came of digitising a camera's F frames and M markers.

    Attributes:
        uv: (M, F, 2) px without the shift of the image, the reference marker as it was seen; NaN where not present.
        seen: (M, F, 2) px in the image.
        found: (M, F) a `MarkerStatus` each.
        shift: (F, 2) px.
        figures: the number of questions and why they were asked, for `quality.json`.
    """

    uv: Floats
    seen: Floats
    found: NDArray[np.uint8]
    shift: Floats
    figures: dict[str, Any]


@DIGITISE.method("semi_automatic", SemiAutomatic, source="UM²AS, 3.5")
def drive(
    operator: Operator,
    images: ImageSource,
    *,
    n_frames: int,
    method: SemiAutomatic,
    constant: Floats | None = None,
    proposer: Proposer | None = None,
    refuse: Callable[[Exception], None] | None = None,
    on_answer: Callable[[Question, Answer], None] | None = None,
    reopened: Callable[[Question], bool] | None = None,
) -> DigitisingState:
    """The state in which all frames are saved, or in which the operator stopped.

    Args:
        operator: answers; raises `DigitisingStopped` to stop.
        images: gives the images.
        n_frames: of the camera.
        method: the markers and how they are followed.
        constant: (2,) px the reference marker at the calibration.
        proposer: what other cameras say of a missing marker.
        refuse: called with why an answer cannot be used, before the question is put again; without it the error is
            raised.
        on_answer: called with every question and the answer that was used.
        reopened: whether something was said after the last frame was saved, as a frame looked at again; then the
            operator is asked on.

    Raises:
        ValueError: as `begin`.
        KinemarkError: an answer is none to the question, or points at nothing.
    """
    state = begin(n_frames, images, method=method, constant=constant, proposer=proposer)
    while True:
        question = question_of(state, method=method)
        if state.phase is DigitisingPhase.DONE and not (reopened and reopened(question)):
            break
        try:
            answer = operator(question, state)
        except DigitisingStopped:
            break
        try:
            state = advance(state, answer, images, method=method, proposer=proposer)
        except (ValueError, KinemarkError) as error:
            _refused(question, error, refuse)
            continue
        if on_answer is not None:
            on_answer(question, answer)
    return state


def _refused(question: Question, error: Exception, refuse: Callable[[Exception], None] | None) -> None:
    """Tell that an answer cannot be used, or raise where nobody listens."""
    if refuse is None:
        raise KinemarkError(f"Frame {question.frame + 1}, marker {question.name or 'none'}: {error}") from error
    refuse(error)


def result(state: DigitisingState, *, method: SemiAutomatic) -> DigitisedImages:
    """What the saved frames hold, up to the first that is not saved.

    Raises:
        KinemarkError: not even the first frame is saved.
    """
    n = state.saved.index(None) if None in state.saved else len(state.saved)
    frames = [frame for frame in state.saved[:n] if frame is not None]
    if not frames:
        raise KinemarkError("No frame was saved. Answer the questions of the first one, and accept it.")
    seen, shift = np.stack([frame.uv for frame in frames], 1), np.stack([frame.shift for frame in frames])
    uv = seen - shift
    if method.fixed >= 0:
        uv[method.fixed] = seen[method.fixed]
    found = np.stack([frame.found for frame in frames], 1)
    return DigitisedImages(uv, seen, found, shift, _figures(state, found))


def _figures(state: DigitisingState, found: NDArray[np.uint8]) -> dict[str, Any]:
    """How much the operator had to do."""
    reasons = Counter(asked.reason for asked in state.asked)
    corrected, unasked = reasons.pop("corrected", 0), reasons.pop("unasked", 0)
    asked = sum(reasons.values())
    return {
        "frames": found.shape[1],
        "markers": found.shape[0],
        "questions": asked,
        "questions_share": asked / found.size,
        "questions_by_reason": {name: reasons[name] for name in REASONS},
        "proposals_confirmed": sum(q.proposed for q in state.asked) - unasked,
        "proposals_taken_unasked": unasked,
        "corrected": corrected,
        "not_present": int((found == MarkerStatus.NOT_PRESENT).sum()),
    }
