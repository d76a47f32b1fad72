"""The state machine of semi-automatic digitising (UM²AS figures 3.10, 3.14 and 3.15).

The operator digitises the first two frames: a click on any white pixel of a marker gives its centroid. From then on the
machine does so by itself, frame by frame.

1. **The reference marker**, which does not move, is looked for on 5 × 5 pixels about its constant place r₀, where it
   was when the camera was calibrated, or in the first frame. Seen at r, it tells how far the image has shifted,

       s = r − r₀                                                        (1)

   and places without the shift are c = u − s (2). Where it is not present, s is that of the frame before. Where that is
   wanted, the operator is asked whether what was found is the marker, and again of what they then point at.
2. **The others** are expected on a straight line through their latest two places, and looked for there (`search`).
3. **What was not found is asked for**, in the order of the markers. "Not present" is an answer.
4. **The operator looks at the frame** and accepts it, or goes through it marker by marker; a wrong place is put where
   the cursor is. Only an accepted frame is saved. Any saved frame can be looked at again and changed.

A state is a value and `advance` makes the next one of it and an answer, so that taking an answer back is having the
state before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import singledispatch

import numpy as np

from ..data.answers import Absent, Accept, Answer, ByHand, No, Point, Revisit, Undo, Verify, Yes
from ..data.array_types import Bools, Floats
from .image_markers import ImageMarkers, clicked, nearest_free
from .search import constant_place, expected, images_taken, searched, shift_of
from .semi_automatic import FIRST, SemiAutomatic
from .state import (
    AskedQuestion,
    DigitisedFrame,
    DigitisingPhase,
    DigitisingState,
    MarkerStatus,
    PlaceProposal,
    Question,
)

ImageSource = Callable[[int], ImageMarkers]
"""Gives the image of a frame, counted from 0."""

Proposer = Callable[[int, int, Floats, Floats, ImageMarkers, Bools], PlaceProposal | None]
"""Called with frame, marker, shift (2,), where the marker is expected (2,), the image, and which markers are free."""


def begin(
    n_frames: int,
    images: ImageSource,
    *,
    method: SemiAutomatic,
    constant: Floats | None = None,
    proposer: Proposer | None = None,
) -> DigitisingState:
    """Nothing of n_frames is digitised yet, and the first marker of the first frame is asked for.

    Args:
        n_frames: of the camera.
        images: gives the images.
        method: the markers and how they are followed.
        constant: (2,) px the reference marker at the calibration.
        proposer: what other cameras say of a missing marker.

    Raises:
        ValueError: there are no frames, or a place of a reference marker that there is none of.
    """
    if n_frames < 1:
        raise ValueError(f"n_frames is {n_frames}, wanted 1 or more")
    if constant is not None and method.reference is None:
        raise ValueError("constant is the place of a reference marker, and the method has none: wanted None")
    state = DigitisingState(
        (None,) * n_frames, 0, DigitisedFrame.blank(len(method.markers)), DigitisingPhase.POINT, 0, constant
    )
    return _go_on(state, images, method, proposer)


def question_of(state: DigitisingState, *, method: SemiAutomatic) -> Question:
    """What a state asks the operator."""
    marker = state.marker
    name = method.markers[marker] if marker >= 0 else ""
    known = state.draft.uv[marker] if marker >= 0 else np.full(2, np.nan)
    if state.phase is DigitisingPhase.POINT:
        known = expected(state, method)[marker]
    ambiguous = marker >= 0 and state.draft.found[marker] == MarkerStatus.AMBIGUOUS
    return Question(state.phase, state.frame, marker, name, known, state.proposal, bool(ambiguous))


def advance(
    state: DigitisingState,
    answer: Answer,
    images: ImageSource,
    *,
    method: SemiAutomatic,
    proposer: Proposer | None = None,
) -> DigitisingState:
    """The state after an answer; the machine then does by itself all that it can.

    Args:
        state: that asks.
        answer: of the operator.
        images: gives the images.
        method: as in `begin`.
        proposer: what other cameras say of a missing marker.

    Raises:
        ValueError: the answer is none to this question, or there is no such frame, or nothing to take back.
        KinemarkError: an operator pointed at nothing.
    """
    if isinstance(answer, Undo):
        if state.before is None:
            raise ValueError("there is no answer to take back")
        return replace(state.before, asked=state.asked)
    after = _answered(answer, state, images, method)
    return replace(_go_on(after, images, method, proposer), before=state)


# ---- What an answer does ----


@singledispatch
def _answered(answer: Answer, state: DigitisingState, images: ImageSource, method: SemiAutomatic) -> DigitisingState:
    raise ValueError(f"{answer!r} is no answer")


@_answered.register
def _(answer: Point, state: DigitisingState, images: ImageSource, method: SemiAutomatic) -> DigitisingState:
    where = np.array([answer.u, answer.v])
    if state.phase is DigitisingPhase.CORRECT:
        if not np.isfinite(where).all():
            raise ValueError(f"the place is {where}, wanted finite pixels")
        return _verified(_put(state, where, MarkerStatus.PLACED, "corrected"), method)
    _only(state, answer, DigitisingPhase.POINT)
    image_markers = images(state.frame)
    at = image_markers.uv[clicked(image_markers, where)]
    pointed = _put(state, at, MarkerStatus.POINTED, _reason(state, method))
    again = method.confirm_reference and state.marker == method.fixed and not state.searched
    return replace(pointed, phase=DigitisingPhase.REFERENCE) if again else pointed


@_answered.register
def _(answer: Absent, state: DigitisingState, images: ImageSource, method: SemiAutomatic) -> DigitisingState:
    _only(state, answer, DigitisingPhase.POINT, DigitisingPhase.CORRECT)
    if state.phase is DigitisingPhase.CORRECT:
        return _verified(_put(state, None, MarkerStatus.NOT_PRESENT, "corrected"), method)
    taken = state.proposal is not None and not state.proposal.seen
    return _put(state, None, MarkerStatus.NOT_PRESENT, _reason(state, method), proposed=taken)


@_answered.register
def _(answer: Yes, state: DigitisingState, images: ImageSource, method: SemiAutomatic) -> DigitisingState:
    if state.phase is DigitisingPhase.VERIFY:
        return _verified(state, method)
    if state.phase is DigitisingPhase.REFERENCE:
        return replace(state, phase=DigitisingPhase.POINT, asked=(*state.asked, _asked(state, "reference")))
    _only(state, answer, DigitisingPhase.POINT)
    if state.proposal is None:
        raise ValueError("nothing is proposed; wanted a pixel of the marker, or that it is not present")
    return _taken(state, state.proposal, _reason(state, method))


@_answered.register
def _(answer: No, state: DigitisingState, images: ImageSource, method: SemiAutomatic) -> DigitisingState:
    _only(state, answer, DigitisingPhase.VERIFY, DigitisingPhase.REFERENCE)
    if state.phase is DigitisingPhase.VERIFY:
        return replace(state, phase=DigitisingPhase.CORRECT)
    asked = (*state.asked, _asked(state, "reference"))
    opened = state.draft.put(state.marker, None, MarkerStatus.OPEN)
    return replace(state, phase=DigitisingPhase.POINT, draft=opened, searched=False, asked=asked)


@_answered.register
def _(answer: Accept, state: DigitisingState, images: ImageSource, method: SemiAutomatic) -> DigitisingState:
    _only(state, answer, DigitisingPhase.REVIEW)
    saved = (*state.saved[: state.frame], state.draft, *state.saved[state.frame + 1 :])
    blank = DigitisedFrame.blank(len(method.markers))
    if None not in saved:
        return replace(state, saved=saved, phase=DigitisingPhase.DONE, marker=-1)
    after = saved.index(None)
    return replace(state, saved=saved, frame=after, draft=blank, phase=DigitisingPhase.POINT, searched=after < FIRST)


@_answered.register
def _(answer: Verify, state: DigitisingState, images: ImageSource, method: SemiAutomatic) -> DigitisingState:
    _only(state, answer, DigitisingPhase.REVIEW)
    return replace(state, phase=DigitisingPhase.VERIFY, marker=0)


@_answered.register
def _(answer: ByHand, state: DigitisingState, images: ImageSource, method: SemiAutomatic) -> DigitisingState:
    _only(state, answer, DigitisingPhase.REVIEW)
    return replace(state, draft=DigitisedFrame.blank(len(method.markers)), phase=DigitisingPhase.POINT, searched=True)


@_answered.register
def _(answer: Revisit, state: DigitisingState, images: ImageSource, method: SemiAutomatic) -> DigitisingState:
    if not 0 <= answer.frame < len(state.saved):
        raise ValueError(f"there is no frame {answer.frame + 1}; wanted 1 to {len(state.saved)}")
    draft = state.saved[answer.frame]
    if draft is None:
        raise ValueError(f"frame {answer.frame + 1} has not been saved yet; wanted one that has")
    return replace(
        state, frame=answer.frame, draft=draft, phase=DigitisingPhase.REVIEW, marker=-1, searched=True, proposal=None
    )


def _only(state: DigitisingState, answer: Answer, *phases: DigitisingPhase) -> None:
    if state.phase not in phases:
        raise ValueError(f"{type(answer).__name__} is no answer to a question of the kind {state.phase.value!r}")


def _reason(state: DigitisingState, method: SemiAutomatic) -> str:
    """Why a marker is asked for."""
    if state.frame < FIRST:
        return "first_two_frames"
    if state.marker == method.fixed:
        return "reference"
    return "ambiguous" if state.draft.found[state.marker] == MarkerStatus.AMBIGUOUS else "not_found"


def _asked(state: DigitisingState, reason: str, proposed: bool = False) -> AskedQuestion:
    return AskedQuestion(state.frame, state.marker, reason, proposed)


def _put(
    state: DigitisingState, uv: Floats | None, found: MarkerStatus, reason: str, *, proposed: bool = False
) -> DigitisingState:
    """The marker asked for is where the operator said."""
    asked = (*state.asked, _asked(state, reason, proposed))
    return replace(state, draft=state.draft.put(state.marker, uv, found), asked=asked)


def _taken(state: DigitisingState, proposal: PlaceProposal, reason: str) -> DigitisingState:
    """The marker asked for is where other cameras said."""
    found = MarkerStatus.PROPOSED if proposal.seen else MarkerStatus.NOT_PRESENT
    draft = state.draft.put(state.marker, proposal.uv if proposal.seen else None, found)
    return replace(state, draft=draft, asked=(*state.asked, _asked(state, reason, True)))


def _verified(state: DigitisingState, method: SemiAutomatic) -> DigitisingState:
    """On to the next marker, or back to the whole frame; the reference marker's place may have changed the shift."""
    last = state.marker == len(method.markers) - 1
    state = replace(state, draft=replace(state.draft, shift=shift_of(state, method)))
    return replace(
        state, phase=DigitisingPhase.REVIEW if last else DigitisingPhase.VERIFY, marker=-1 if last else state.marker + 1
    )


# ---- What the machine does by itself ----


def _go_on(
    state: DigitisingState, images: ImageSource, method: SemiAutomatic, proposer: Proposer | None
) -> DigitisingState:
    """The state in which the operator is needed again."""
    state = replace(state, proposal=None)
    if state.phase is not DigitisingPhase.POINT:
        return state
    if not state.searched:
        state = _reference(state, images, method)
        if not state.searched:
            return state
    while (left := state.draft.open).size:
        state = replace(state, marker=int(left[0]))
        proposal = _proposed(state, images, method, proposer)
        if proposal is None or not method.take_proposals:
            return replace(state, proposal=proposal)
        state = _taken(state, proposal, "unasked")
    draft = replace(state.draft, shift=shift_of(state, method))
    return replace(state, draft=draft, phase=DigitisingPhase.REVIEW, marker=-1)


def _reference(state: DigitisingState, images: ImageSource, method: SemiAutomatic) -> DigitisingState:
    """The reference marker and, once its place is settled, all others; not searched where it is to be asked for."""
    r, image_markers = method.fixed, images(state.frame)
    if r >= 0 and state.draft.found[r] == MarkerStatus.OPEN:
        refused = AskedQuestion(state.frame, r, "reference", False) in state.asked[-1:]
        state = replace(state, marker=r)
        near = nearest_free(image_markers, constant_place(state, method), free=image_markers.usable, side=method.grid)
        if near is None or refused:
            return state
        state = replace(state, draft=state.draft.put(r, image_markers.uv[near[1]], MarkerStatus.AUTOMATIC))
        if method.confirm_reference:
            return replace(state, phase=DigitisingPhase.REFERENCE)
    draft = replace(state.draft, shift=shift_of(state, method))
    state = replace(state, draft=draft, searched=True)
    return replace(state, draft=searched(draft, expected(state, method), image_markers, method))


def _proposed(
    state: DigitisingState, images: ImageSource, method: SemiAutomatic, proposer: Proposer | None
) -> PlaceProposal | None:
    """What other cameras say of the marker asked for; they do not see the reference marker as it shifts."""
    if proposer is None or state.marker == method.fixed:
        return None
    image_markers, shift = images(state.frame), shift_of(state, method)
    free = image_markers.usable & ~images_taken(state.draft, image_markers)
    return proposer(state.frame, state.marker, shift, expected(state, method)[state.marker], image_markers, free)
