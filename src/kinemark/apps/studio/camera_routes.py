"""A session's cameras: their calibration, made and looked at; control balls pointed at; numbers stated."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import HTMLResponse

from ...engine.calibration.results import PAGE
from ...engine.digitising.control_balls import ControlBalls
from ...io.images import png_bytes
from ...report.drawing_library import ASSETS, self_contained
from . import camera_messages as c
from .cameras import session_cameras, state_numbers
from .control import balls_of, control, say, set_threshold, white_pixels
from .export_routes import SANDBOX
from .home_routes import desk_of
from .live import TheLive
from .messages import Job
from .shelf import NotThere

PNG = {200: {"content": {"image/png": {"schema": {"type": "string", "format": "binary"}}}}}
"""What OpenAPI says of an image."""
router = APIRouter(prefix="/api/sessions/{session}")


def folder_of(request: Request, session: str) -> Path:
    """The folder of the session that an address names."""
    return desk_of(request).shelf.session(session)


Folder = Annotated[Path, Depends(folder_of)]


def _balls(folder: Folder) -> ControlBalls:
    return balls_of(folder)


Balls = Annotated[ControlBalls, Depends(_balls)]


@router.get("/cameras")
def get_cameras(session: str, folder: Folder) -> c.SessionCameras:
    """How the cameras are calibrated, and how good that is."""
    return session_cameras(session, folder)


@router.post("/numbers")
def post_numbers(session: str, folder: Folder, body: c.NumbersBody) -> c.SessionCameras:
    """State numbers of the calibration anew, in session.toml."""
    state_numbers(folder, body.numbers)
    return session_cameras(session, folder)


@router.post("/calibrate")
def post_calibrate(session: str, live: TheLive) -> Job:
    """Calibrate the cameras."""
    return live.calibrate(session)


@router.get("/calibration", response_class=HTMLResponse)
def get_page(folder: Folder) -> HTMLResponse:
    """The page of the last calibration, with all that it draws with."""
    results = folder / "results"
    if not (results / PAGE).is_file():
        raise NotThere("There is no calibration yet: calibrate the cameras.")
    return HTMLResponse(self_contained(results / PAGE, results / ASSETS), headers={"Content-Security-Policy": SANDBOX})


@router.get("/control")
def get_control(balls: Balls) -> c.Control:
    """Control balls, and what was said of them."""
    return control(balls)


@router.get("/control/{camera}/image", response_class=Response, responses=PNG)  # type: ignore[arg-type]
def get_control_image(balls: Balls, camera: str) -> Response:
    """A camera's image of the control balls."""
    return Response(png_bytes(balls.image(camera)), media_type="image/png")


@router.get("/control/{camera}/white")
def get_white_pixels(
    balls: Balls,
    camera: str,
    threshold: Annotated[float | None, Query(ge=0, le=255)] = None,
    inverted: bool | None = None,
) -> c.WhitePixels:
    """What can be pointed at in it by a threshold."""
    return white_pixels(balls, camera, threshold, inverted)


@router.post("/control/{camera}")
def post_ball(folder: Folder, balls: Balls, camera: str, body: c.BallBody) -> c.Control:
    """Say where a camera sees a ball."""
    say(balls, camera, body)
    return control(balls_of(folder))


@router.post("/threshold")
def post_threshold(folder: Folder, body: c.ThresholdBody) -> c.Control:
    """Say which pixels are white, in session.toml."""
    set_threshold(folder, body)
    return control(balls_of(folder))
