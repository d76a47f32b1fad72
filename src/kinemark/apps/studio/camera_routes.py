"""A session's cameras: their calibration, made, looked at, or made another way; control balls; targets in images."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import HTMLResponse

from ...engine.calibration import last_calibration
from ...engine.calibration.results import PAGE
from ...engine.calibration_change import change_way, ways_of
from ...engine.digitising.control_balls import ControlBalls
from ...engine.first_session import Role, SessionProposal
from ...engine.first_session.session_text import points_file
from ...engine.found_targets import found_target, target_image, targets_of
from ...engine.session import Session
from ...io.images import png_bytes
from ...report.drawing_library import ASSETS, self_contained
from ...report.words.first_session import ROLES, reason_text
from . import camera_messages as c
from . import session_gait
from .cameras import balls_of, control, say, session_cameras, set_threshold, state_numbers, white_pixels
from .export_routes import SANDBOX
from .home_routes import PNG, desk_of
from .live import TheLive
from .messages import Job, Standing
from .new_session import asked_row
from .shelf import NotThere

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


@router.get("/gait", response_class=HTMLResponse)
def get_gait(folder: Folder) -> HTMLResponse:
    """The page of the session's gait report."""
    return HTMLResponse(session_gait.page(folder), headers={"Content-Security-Policy": SANDBOX})


@router.post("/gait")
def post_gait(folder: Folder) -> Standing:
    """Make the session's gait report."""
    return Standing(ready=True, words=session_gait.make(folder))


@router.get("/control")
def get_control(balls: Balls) -> c.Control:
    """Control balls, and what was said of them."""
    return control(balls)


@router.get("/control/{camera}/image", response_class=Response, responses=PNG)
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


WORDS = {"control_frame": "Rods", "wand": "Wand", "l_frame": "L-frame", "linearisation": "Grid"}


@router.get("/targets")
def get_targets(folder: Folder) -> c.Targets:
    """What can be looked at."""
    return c.Targets(kinds={kind: WORDS[kind] for kind in targets_of(Session.open(folder).settings)})


@router.get("/targets/{kind}/{camera}/{frame}")
def get_found(folder: Folder, kind: str, camera: str, frame: int) -> c.FoundInImage:
    """A target in an image; the L-frame where the last calibration has it."""
    session = Session.open(folder)
    last = last_calibration(folder, session.results, session.settings) if kind == "l_frame" else None
    found = found_target(folder, session.settings, kind, camera, frame, last.rig if last else None)
    points = zip(found.names, found.uv.tolist(), strict=True)
    return c.FoundInImage(
        width=found.size[0],
        height=found.size[1],
        frames=found.frames,
        points=[c.TargetPoint(name=name, u=u, v=v) for name, (u, v) in points],
        lines=list(found.lines),
        spots=[(u, v) for u, v in found.spots.tolist()],
        words=found.words,
    )


@router.get("/targets/{kind}/{camera}/{frame}/image", response_class=Response, responses=PNG)
def get_image(folder: Folder, kind: str, camera: str, frame: int) -> Response:
    """The image."""
    settings = Session.open(folder).settings
    return Response(png_bytes(target_image(folder, settings, kind, camera, frame)), media_type="image/png")


@router.get("/ways")
def get_ways(folder: Folder) -> c.Ways:
    """The recordings that could calibrate the session."""
    used = _used(folder)
    return c.Ways(ways=[_way_row(one, used) for one in ways_of(folder)])


@router.post("/ways")
def post_way(session: str, folder: Folder, body: c.WayBody) -> c.SessionCameras:
    """Calibrate by another one from now on, in session.toml."""
    change_way(folder, body.path, Role(body.role), body.answers)
    return session_cameras(session, folder)


def _way_row(one: SessionProposal, used: set[str]) -> c.WayRow:
    assert one.way is not None
    questions = [asked_row(ask, "", "") for ask in one.questions if ask.key.startswith("calibration.")]
    return c.WayRow(
        path=one.way.path,
        role=one.way.role,
        words=ROLES[one.way.role],
        why="" if one.way.why.kind == "stated" else reason_text(one.way.why),  # nobody did yet
        now=points_file(one.way.path) in used,
        questions=questions,
    )


def _used(folder: Path) -> set[str]:
    """Files and patterns that the session's way names."""
    calibration = Session.open(folder).settings.calibration
    way = getattr(calibration, calibration.way)
    return {str(value) for value in ([way] if isinstance(way, Path) else dict(way).values())}
