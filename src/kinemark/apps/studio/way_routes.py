"""Another way of calibration for a session: what its recordings allow, and the change."""

from __future__ import annotations

from pathlib import Path

from fastapi import APIRouter

from ...engine.calibration_change import change_way, ways_of
from ...engine.first_session import Role, SessionProposal
from ...engine.first_session.session_text import points_file
from ...engine.session import Session
from ...report.words.first_session import ROLES, reason_text
from . import camera_messages as c
from .camera_routes import Folder
from .cameras import session_cameras
from .new_session import asked_row

router = APIRouter(prefix="/api/sessions/{session}/ways")


@router.get("")
def get_ways(folder: Folder) -> c.Ways:
    """The recordings that could calibrate the session."""
    used = _used(folder)
    return c.Ways(ways=[_row(one, used) for one in ways_of(folder)])


@router.post("")
def post_way(session: str, folder: Folder, body: c.WayBody) -> c.SessionCameras:
    """Calibrate by another one from now on, in session.toml."""
    change_way(folder, body.path, Role(body.role), body.answers)
    return session_cameras(session, folder)


def _row(one: SessionProposal, used: set[str]) -> c.WayRow:
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
