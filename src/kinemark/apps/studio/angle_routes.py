"""Joint angles of a trial: curves, what made one leap, and UM²AS's files."""

from __future__ import annotations

from fastapi import APIRouter

from . import angle_messages as a
from .angles import angles_shown, export, spike
from .trial_routes import Document

router = APIRouter(prefix="/api/trials/{trial}/angles")


@router.post("")
def post_angles(document: Document, body: a.AngleChoice) -> a.AnglesShown:
    """The angles of a trial, taken as is said; nothing is written."""
    return angles_shown(document, body)


@router.post("/spike")
def post_spike(document: Document, body: a.SpikeBody) -> a.Spike:
    """The frame, marker and image that made an angle leap."""
    return spike(document, body)


@router.post("/export")
def post_euler(document: Document, body: a.AngleChoice) -> a.EulerFiles:
    """Write the three Euler files, never over what was given."""
    return export(document, body)
