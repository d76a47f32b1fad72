"""Digitise: the question that is asked now, and answers, each kept before it counts."""

from __future__ import annotations

from dataclasses import asdict

from fastapi import APIRouter, Request

from ...engine.digitising.open_digitising import OpenDigitising
from ...engine.digitising.setup import DigitisingSetup, choices, leave_off, set_up
from ...engine.session import Session
from ...engine.session_name import FILE
from . import detect_messages as m
from .detect_routes import ThePlace
from .digitise import now, open_digitising, saved_frame, take
from .home_routes import TheDesk
from .kept import Kept, stamp_of
from .shelf import Place

router = APIRouter(prefix="/api/trials/{trial}/digitise")


def digitising_of(request: Request, place: Place) -> OpenDigitising:
    """The trial that is being digitised, gone through anew where its session or its answers were changed."""
    kept = request.app.state.digitising
    assert isinstance(kept, Kept)
    stamp = stamp_of(place.path / FILE)
    opened = kept.get(place.id, stamp, lambda: open_digitising(place))
    if opened.outdated:
        kept.forget(place.id)
        opened = kept.get(place.id, stamp, lambda: open_digitising(place))
    assert isinstance(opened, OpenDigitising)
    return opened


@router.get("")
def get_digitising(request: Request, place: ThePlace) -> m.DigitisingNow:
    """Where the operator is."""
    return _now(digitising_of(request, place), place)


@router.post("/answers")
def post_answer(request: Request, place: ThePlace, body: m.AnswerBody) -> m.DigitisingNow:
    """Answer the question that is asked; 409 where somebody else has."""
    opened = digitising_of(request, place)
    with opened.lock:
        take(opened, body)
        return _now(opened, place)


@router.get("/setup")
def get_setup(place: ThePlace) -> m.StartUp:
    """What may be chosen before the first answer."""
    found = choices(place.path, place.name)
    now = m.SetupBody(**asdict(found.now) | {"markers": list(found.now.markers)})
    files = list(found.reference_files)
    return m.StartUp(frames=found.frames, reference_files=files, now=now, operated=found.operated)


@router.post("/setup")
def post_setup(request: Request, place: ThePlace, desk: TheDesk, body: m.SetupBody) -> m.DigitisingNow:
    """Name the markers, as long as nothing was answered; written into the session."""
    setup = DigitisingSetup(**body.model_dump() | {"markers": tuple(body.markers)})
    set_up(place.path, place.name, setup)
    desk.forget_session(place)
    return _now(digitising_of(request, place), place)


@router.delete("/setup", status_code=204)
def delete_setup(place: ThePlace, desk: TheDesk) -> None:
    """Nobody digitises the trial, as long as nothing was answered."""
    leave_off(place.path, place.name)
    desk.forget_session(place)


@router.get("/frames/{frame}")
def get_saved(request: Request, place: ThePlace, frame: int) -> list[m.PlacedMarker]:
    """What is saved of a frame of the camera whose turn it is."""
    opened = digitising_of(request, place)
    with opened.lock:
        return saved_frame(opened, frame)


def _now(opened: OpenDigitising, place: Place) -> m.DigitisingNow:
    with opened.lock:
        return now(opened, place, Session.open(place.path).settings.name)
