"""Calibration targets in a session's images, as they are found."""

from __future__ import annotations

from fastapi import APIRouter, Response

from ...engine.calibration import last_calibration
from ...engine.found_targets import found_target, target_image, targets_of
from ...engine.session import Session
from ...io.images import png_bytes
from . import camera_messages as c
from .camera_routes import PNG, Folder

WORDS = {"control_frame": "Rods", "wand": "Wand", "l_frame": "L-frame", "linearisation": "Grid"}
router = APIRouter(prefix="/api/sessions/{session}/targets")


@router.get("")
def get_targets(folder: Folder) -> c.Targets:
    """What can be looked at."""
    return c.Targets(kinds={kind: WORDS[kind] for kind in targets_of(Session.open(folder).settings)})


@router.get("/{kind}/{camera}/{frame}")
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


@router.get("/{kind}/{camera}/{frame}/image", response_class=Response, responses=PNG)  # type: ignore[arg-type]
def get_image(folder: Folder, kind: str, camera: str, frame: int) -> Response:
    """The image."""
    settings = Session.open(folder).settings
    return Response(png_bytes(target_image(folder, settings, kind, camera, frame)), media_type="image/png")
