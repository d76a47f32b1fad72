"""Detect: the images of all cameras in one frame, what is found in them, and what of it would be found otherwise."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Request, Response

from ...data import KinemarkError
from ...engine.detection.open_detection import OpenDetection
from ...engine.detection.settings_file import apply
from ...engine.session_name import FILE
from . import detect_messages as m
from .detect import detection, draft_of, found_in, why_there
from .home_routes import PNG, TheDesk, desk_of
from .image_routes import KEPT as FOR_AN_HOUR
from .kept import Kept, stamp_of
from .shelf import Place

router = APIRouter(prefix="/api/trials/{trial}")


def place_of(request: Request, trial: str) -> Place:
    """The trial of a session that an address names, run or not.

    Raises:
        NotThere: there is none.
        KinemarkError: it is a file.
    """
    place = desk_of(request).place(trial)
    if place.trial is None:
        raise KinemarkError(f"{place.name} is a file of trajectories: it has no images.")
    return place


ThePlace = Annotated[Place, Depends(place_of)]


def opened_of(request: Request, place: ThePlace) -> OpenDetection:
    """The images of the trial, opened anew where its session was changed."""
    kept = request.app.state.detecting
    assert isinstance(kept, Kept) and place.trial is not None
    name = place.trial
    opened = kept.get(place.id, stamp_of(place.path / FILE), lambda: OpenDetection(place.path, name))
    assert isinstance(opened, OpenDetection)
    return opened


Opened = Annotated[OpenDetection, Depends(opened_of)]


@router.get("/pictures/{camera}/{frame}", response_class=Response, responses=PNG)
def get_picture(opened: Opened, camera: str, frame: int) -> Response:
    """The whole image of a camera in a frame, as it was recorded; deeper ones as 8 bits."""
    return Response(opened.picture(camera, frame), media_type="image/png", headers={"Cache-Control": FOR_AN_HOUR})


@router.get("/detect")
def get_detection(opened: Opened, place: ThePlace) -> m.Detection:
    """How markers are detected, as the session says it."""
    return detection(opened, place)


@router.post("/detect/frame")
def post_frame(opened: Opened, body: m.DetectFrameBody) -> m.DetectFrame:
    """What would be found in a frame; nothing is written."""
    return found_in(opened, body)


@router.post("/detect/why")
def post_why(opened: Opened, body: m.WhyBody) -> m.PlaceWhy:
    """Why there is a marker or none at a place; nothing is written."""
    return why_there(opened, body)


@router.post("/detect/apply")
def post_apply(request: Request, opened: Opened, place: ThePlace, desk: TheDesk, body: m.DetectDraft) -> m.Detection:
    """Write what was tried into the session, whose trials are stale then."""
    apply(opened, draft_of(body))
    desk.forget_session(place)
    return detection(opened_of(request, place), place)
