"""The aspect ratio of pixels by the rotating bar: measured, and written into session.toml."""

from __future__ import annotations

import numpy as np
from fastapi import APIRouter

from ...data import KinemarkError
from ...detect import Centroids
from ...engine.bar_aspect import bar_aspect
from ...engine.first_session import propose_session
from ...engine.recordings import open_cameras
from ...engine.session import Session
from ...engine.session_changes import change_session
from ...io.images import ImageSource
from . import um2as_messages as u
from .camera_routes import Folder
from .shelf import NotThere

DECIMALS = 5
"""Of the factor that is written; chosen: bars give it to 1e-3."""
router = APIRouter(prefix="/api/sessions/{session}/um2as/aspect")


@router.get("")
def get_bars(folder: Folder) -> u.Bars:
    """Recordings that may be of the bar."""
    return u.Bars(images=_recordings(folder), factor=Session.open(folder).settings.cameras.aspect_ratio)


@router.post("")
def post_bar(folder: Folder, body: u.BarBody) -> u.BarMeasured:
    """What a recording of the bar says; nothing is written."""
    if body.images not in _recordings(folder):
        raise NotThere(f"There is no recording {body.images!r} of all cameras in the session's folder.")
    settings = Session.open(folder).settings
    sources = open_cameras(folder, settings, body.images, settings.cameras.names)
    method = Centroids(threshold=body.threshold, inverted=body.inverted)
    rows = [_row(name, source, method) for name, source in sources.items()]
    known = [row.factor for row in rows if row.factor is not None]
    return u.BarMeasured(cameras=rows, factor=round(float(np.mean(known)), DECIMALS) if known else None)


@router.post("/factor")
def post_factor(folder: Folder, body: u.FactorBody) -> u.Bars:
    """State it; files are made anew with it."""
    change_session(folder, {("cameras", "aspect_ratio"): body.factor})
    return get_bars(folder)


def _recordings(folder: Folder) -> list[str]:
    """Images of all cameras, of whatever they are."""
    names = Session.open(folder).settings.cameras.names
    found = propose_session(folder).recordings
    return [one.path for one in found if one.content == "images" and names and {*names} <= {*one.cameras}]


def _row(camera: str, source: ImageSource, method: Centroids) -> u.BarRow:
    try:
        found = bar_aspect(source, method=method)
    except KinemarkError as error:
        return u.BarRow(camera=camera, factor=None, sd=None, words=str(error))
    return u.BarRow(camera=camera, factor=found.ratio.factor, sd=found.ratio.sd, words=found.said())
