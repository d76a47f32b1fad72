"""What the cameras saw of a trial: images and detections."""

from __future__ import annotations

import json
from typing import Annotated

from fastapi import APIRouter, Query, Response

from ...data import KinemarkError
from .home_routes import BINARY, JPEG, PNG
from .images import MOST_FRAMES, seen, seen_between
from .trial_routes import Document

KEPT = "private, max-age=3600"
"""Images of a frame never change while the page is open."""
router = APIRouter(prefix="/api/trials/{trial}")


@router.get("/mosaic/{frame}", response_class=Response, responses=JPEG)
def get_mosaic(document: Document, frame: int, ahead: bool = False) -> Response:
    """The images of all cameras in a frame, by its number; `ahead` of being looked at, nothing where not made yet."""
    if ahead:
        found = seen(document).ready(frame - 1)
        return Response(found, 200 if found else 204, {"Cache-Control": "no-store"}, "image/jpeg")
    return Response(seen(document).jpeg(frame - 1), media_type="image/jpeg", headers={"Cache-Control": KEPT})


@router.get("/cameras/{camera}/{frame}", response_class=Response, responses=PNG)
def get_crop(
    document: Document,
    camera: str,
    frame: int,
    x: Annotated[int, Query(ge=0)],
    y: Annotated[int, Query(ge=0)],
    w: Annotated[int, Query(gt=0)],
    h: Annotated[int, Query(gt=0)],
) -> Response:
    """A part of an image in its own pixels: what a mosaic shows too small."""
    png = seen(document).crop(camera, frame - 1, x, y, w, h)
    return Response(png, media_type="image/png", headers={"Cache-Control": KEPT})


@router.get("/detections", response_class=Response, responses=BINARY)
def get_detections(document: Document, first: int, last: int) -> Response:
    """What was detected in some frames, as `DetectionsHeader` says."""
    if not 0 <= last - first < MOST_FRAMES:
        raise KinemarkError(f"Frames {first} to {last} are none, or more than {MOST_FRAMES} at a time.")
    about, body = seen_between(document, first, last)
    said = {"X-Kinemark-Detections": json.dumps(about.model_dump())}
    return Response(body, media_type="application/octet-stream", headers=said)
