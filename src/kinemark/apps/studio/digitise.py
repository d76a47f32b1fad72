"""Digitising of a trial, as its screen shows it and asks."""

from __future__ import annotations

import numpy as np

from ...data import KinemarkError
from ...data.answers import Absent, Accept, Answer, ByHand, No, Point, Revisit, Undo, Verify, Yes
from ...data.array_types import Floats
from ...digitise import DigitisedFrame, DigitisingPhase, MarkerStatus, Question
from ...engine.digitising.open_digitising import OpenDigitising
from ...engine.session import Session
from . import detect_messages as m
from .messages import EpipolarLine
from .shelf import Place

MOST_SPOTS = 200
"""That are sent; chosen: more are not stepped through."""
PLAIN: dict[str, Answer] = {
    "absent": Absent(), "yes": Yes(), "no": No(), "save": Accept(), "verify": Verify(), "hand": ByHand(),
    "undo": Undo(),
}  # fmt: skip
HOW: dict[MarkerStatus, m.How] = {
    MarkerStatus.OPEN: "open", MarkerStatus.NOT_PRESENT: "not present", MarkerStatus.AUTOMATIC: "automatic",
    MarkerStatus.POINTED: "pointed", MarkerStatus.PLACED: "placed", MarkerStatus.PROPOSED: "proposed",
    MarkerStatus.AMBIGUOUS: "ambiguous",
}  # fmt: skip


class AnsweredMeanwhile(KinemarkError):
    """Somebody else has answered since the page asked."""


def open_digitising(place: Place) -> OpenDigitising:
    """The trial, as far as its answers go.

    Raises:
        KinemarkError: it is not digitised by an operator, or its cameras or images cannot be used.
    """
    session = Session.open(place.path)
    entry = session.trial(place.name).entry
    if entry.images is None or entry.answers is None:
        raise KinemarkError(
            f"Nobody digitises {place.name} by hand: its markers are found by themselves. Where they cannot be, say "
            "which markers an operator points at."
        )
    return OpenDigitising(session.digitising(place.name, session.calibrate().rig))


def now(opened: OpenDigitising, place: Place, title: str) -> m.DigitisingNow:
    """Where the operator is."""
    state, question = opened.state, opened.question
    markers = opened.task.method.markers
    cameras = []
    for name in opened.names:
        source = opened.task.images[name]
        width, height = source.size
        cameras.append(
            m.DigitisedCamera(
                name=name, width=width, height=height, tall=bool(source.interlaced), saved=opened.saved(name)
            )
        )
    return m.DigitisingNow(
        trial=place.name, session=title, cameras=cameras, frames=opened.n_frames,
        every=next(iter(opened.task.images.values())).every, camera=opened.camera,
        kept=opened.kept[opened.camera], markers=list(markers), reference=opened.task.method.reference,
        question=_question(opened, question), draft=_placed(opened, state.draft), can_undo=opened.can_undo,
        finished=opened.finished(opened.names[-1]),
    )  # fmt: skip


def saved_frame(opened: OpenDigitising, frame: int) -> list[m.PlacedMarker]:
    """What is saved of a frame of the camera whose turn it is; raises a KinemarkError where nothing is."""
    saved = opened.state.saved[frame - 1] if 1 <= frame <= opened.n_frames else None
    if saved is None:
        raise KinemarkError(f"Frame {frame} of {opened.camera} is not saved yet.")
    return _placed(opened, saved)


def _placed(opened: OpenDigitising, frame: DigitisedFrame) -> list[m.PlacedMarker]:
    return [
        m.PlacedMarker(name=name, u=_known(uv[0]), v=_known(uv[1]), how=HOW[MarkerStatus(found)])
        for name, uv, found in zip(opened.task.method.markers, frame.uv, frame.found, strict=True)
    ]


def take(opened: OpenDigitising, body: m.AnswerBody) -> None:
    """Take an answer.

    Raises:
        AnsweredMeanwhile: it is to a question that is not asked any more.
        KinemarkError: it is none to this question, or points at nothing.
    """
    if body.camera != opened.camera or body.kept != opened.kept[opened.camera]:
        raise AnsweredMeanwhile("Somebody else has answered meanwhile. This is where digitising stands now.")
    try:
        opened.answer(_answer(body))
    except ValueError as error:
        raise KinemarkError(f"{str(error)[:1].upper()}{str(error)[1:]}.") from error


def _answer(body: m.AnswerBody) -> Answer:
    said = body.said
    if isinstance(said, m.PointSaid):
        return Point(said.u, said.v)
    return Revisit(said.frame - 1) if isinstance(said, m.FrameSaid) else PLAIN[said.kind]


def _question(opened: OpenDigitising, question: Question) -> m.DigitiseQuestion:
    method = opened.task.method
    searched = question.phase is DigitisingPhase.POINT and bool(np.isfinite(question.uv).all())
    side = method.grid if question.marker == method.fixed else method.grid * method.expansions
    said = question.proposal
    return m.DigitiseQuestion(
        phase=question.phase.value, frame=question.frame + 1, marker=question.name, words=spoken(opened, question),
        at=_pixel(question.uv), search=side if searched else 0, ambiguous=question.ambiguous,
        said=None if said is None else m.PlaceSaid(at=_pixel(said.uv), seen=said.seen),
        lines=[
            EpipolarLine(camera=name, points=[(u, v) for u, v in line.tolist()])
            for name, line in opened.lines().items()
        ],
        spots=[(u, v) for u, v in opened.spots()[:MOST_SPOTS].tolist()],
    )  # fmt: skip


def spoken(opened: OpenDigitising, question: Question) -> str:
    """A question as a screen puts it."""
    name, reference = _called(question), opened.task.method.reference
    if question.phase is DigitisingPhase.POINT:
        what = f"the reference marker, {question.name}" if question.name == reference else name
        why = " Two images would do." if question.ambiguous else ""
        return f"Where is {what}?{why}{_proposed(question)}"
    return {
        DigitisingPhase.REFERENCE: f"Is this the reference marker, {question.name}?",
        DigitisingPhase.REVIEW: "Have successfully detected all markers. Look at them, then save the frame.",
        DigitisingPhase.VERIFY: _verified(question),
        DigitisingPhase.CORRECT: f"Click where the centre of {name} is.",
        DigitisingPhase.DONE: f"The last frame of {opened.camera} is saved: all {opened.n_frames} are digitised.",
    }[question.phase]


def _verified(question: Question) -> str:
    missing = np.isnan(question.uv).any()
    name = _called(question)
    return f"{name[:1].upper()}{name[1:]} is not present. Is that right?" if missing else f"Is this {name}?"


def _called(question: Question) -> str:
    """A marker that has a number for a name is said to be one."""
    return f"marker {question.name}" if question.name.isdecimal() else question.name


def _proposed(question: Question) -> str:
    said = question.proposal
    if said is None:
        return ""
    return " The other cameras say: here, at the +." if said.seen else " The other cameras say: it is hidden."


def _pixel(uv: Floats) -> m.Pixel | None:
    return (float(uv[0]), float(uv[1])) if np.isfinite(uv).all() else None


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
