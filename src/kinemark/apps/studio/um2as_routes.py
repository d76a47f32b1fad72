"""The menu of UM²AS: how far its entries are, and those that are done on its own screen, as the aspect ratio."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import numpy as np
from fastapi import APIRouter, Depends, Query, Request

from ...data import KinemarkError
from ...detect import Centroids
from ...engine.bar_aspect import bar_aspect
from ...engine.first_session import propose_session
from ...engine.recordings import open_cameras
from ...engine.session import Session
from ...engine.session_changes import change_session
from ...engine.um2as.files import Um2asFiles
from ...engine.um2as.flow import table
from ...engine.um2as.menu import MENU, MenuEntry, Standing, level_standing, standings
from ...io.images import ImageSource
from ...io.um2as import read_da
from . import um2as_messages as u
from .camera_routes import Folder
from .digitise_routes import digitising_of
from .shelf import NotThere, Place

router = APIRouter(prefix="/api/sessions/{session}/um2as")


def files_of(folder: Folder, trial: Annotated[str, Query(max_length=200)] = "") -> Um2asFiles:
    """The files of a session and a trial by its name; of the first where none is named."""
    return _files(folder, trial)


Files = Annotated[Um2asFiles, Depends(files_of)]


@router.get("")
def get_menu(
    request: Request,
    session: str,
    files: Files,
    camera: Annotated[list[str], Query(max_length=64)] = [],  # noqa: B006  FastAPI copies it
    tdc: Annotated[str, Query(max_length=200)] = "",
) -> u.Um2asMenu:
    """The menu, and how far its entries are with these cameras and this file of places chosen."""
    names, root = files.cameras, files.session.root
    chosen = [name for name in names if name in camera]
    tdcs = sorted(path.name for path in files.folder.glob("*.tdc"))
    place = files.folder / tdc if tdc in tdcs else files.tdc(chosen)
    of = standings(files, saved=_saved(request, files), cameras=chosen, tdc=place)
    return u.Um2asMenu(
        session=session,
        title=files.session.settings.name,
        trial=files.trial,
        trials=[u.MenuTrial(id=Place(root, name).id, name=name) for name in files.session.names],
        cameras=list(names),
        chosen=chosen,
        tdc=place.name,
        tdcs=tdcs,
        folder=files.folder.relative_to(root).as_posix(),
        entries=[_row(entry, of.get(entry.key) or level_standing(entry.key, of)) for entry in MENU],
    )


@router.post("/parameters")
def post_parameters(files: Files, body: u.ParametersBody) -> u.Written:
    """Process L Parameters."""
    written = files.process_parameters(body.made)
    return _written(written, "" if written else "The session's files are taken as they are.")


@router.post("/markers")
def post_markers(request: Request, files: Files) -> u.Written:
    """Save Data."""
    opened = digitising_of(request, Place(files.session.root, files.trial))
    with opened.lock:
        return _written(files.save_markers(opened))


@router.post("/coordinates")
def post_coordinates(folder: Folder, body: u.CoordinatesBody) -> u.Written:
    """Process Coordinates."""
    return _written([_files(folder, body.trial).process_coordinates(body.cameras)])


@router.post("/angles")
def post_angles(folder: Folder, body: u.EulerBody) -> u.Written:
    """Calculate Euler Angles."""
    files = _files(folder, body.trial)
    return _written(files.process_angles(_named(files, body.tdc), signed=not body.inverse_cosines))


@router.get("/files/{name}")
def get_page(files: Files, name: str, frame: Annotated[int, Query(ge=1)] = 1) -> u.FilePage:
    """A frame of a file; the last one where there are fewer."""
    path = _named(files, name)
    heading, rows = table(path, markers=_markers(files, path))
    head = heading.split("\t")
    if head[0] != "frame":
        return u.FilePage(name=name, head=head, rows=[_cells(row) for row in rows], frame=1, frames=1)
    frames = int(rows[-1][0]) if rows else 0
    at = min(frame, frames)
    own = [_cells(row[1:]) for row in rows if row[0] == at]
    return u.FilePage(name=name, head=head[1:], rows=own, frame=at, frames=frames)


def _files(folder: Path, trial: str) -> Um2asFiles:
    session = Session.open(folder)
    if trial and trial not in session.names:
        raise NotThere(f"There is no trial {trial!r} in this session.")
    by_hand = (one.name for one in session.settings.trials if one.answers is not None)
    return Um2asFiles(session, trial or next(by_hand, session.names[0]))


def _saved(request: Request, files: Um2asFiles) -> dict[str, tuple[int, int]] | None:
    """Frames saved of each camera; None where nobody digitises the trial, or nothing can be said of it."""
    if files.session.trial(files.trial).entry.answers is None:
        return None
    try:
        opened = digitising_of(request, Place(files.session.root, files.trial))
    except KinemarkError:  # which its own screen says
        return None
    return {name: (opened.saved(name), opened.n_frames) for name in files.cameras}


def _named(files: Um2asFiles, name: str) -> Path:
    """A file that the menu shows, by its name."""
    own = [*files.folder.glob("*"), *files.cps(), *([files.measured] if files.measured else [])]
    known = {path.name: path for path in own if path.is_file()}
    if name not in known:
        raise NotThere(f"There is no file {name} yet.")
    return known[name]


def _markers(files: Um2asFiles, path: Path) -> int | None:
    """How many a frame of a `.da` file has that does not say it."""
    first = files.das()[0]
    other = path.suffix.startswith(".da") and path != first
    return len(read_da(first)) if other and first.is_file() else None


def _row(entry: MenuEntry, standing: Standing) -> u.MenuRow:
    return u.MenuRow(
        **asdict(entry),
        state=standing.state,
        words=standing.words,
        files=[path.name for path in standing.files],
    )


def _cells(row: tuple[float | int, ...]) -> list[float | None]:
    return [None if math.isnan(value) else value for value in row]


def _written(paths: list[Path], otherwise: str = "") -> u.Written:
    names = [path.name for path in paths]
    return u.Written(names=names, words=f"Written: {', '.join(names)}." if names else otherwise)


DECIMALS = 5
"""Of the factor that is written; chosen: bars give it to 1e-3."""


@router.get("/aspect")
def get_bars(folder: Folder) -> u.Bars:
    """Recordings that may be of the bar."""
    return u.Bars(images=_recordings(folder), factor=Session.open(folder).settings.cameras.aspect_ratio)


@router.post("/aspect")
def post_bar(folder: Folder, body: u.BarBody) -> u.BarMeasured:
    """What a recording of the bar says; nothing is written."""
    if body.images not in _recordings(folder):
        raise NotThere(f"There is no recording {body.images!r} of all cameras in the session's folder.")
    settings = Session.open(folder).settings
    sources = open_cameras(folder, settings, body.images, settings.cameras.names)
    method = Centroids(threshold=body.threshold, inverted=body.inverted)
    rows = [_bar_row(name, source, method) for name, source in sources.items()]
    known = [row.factor for row in rows if row.factor is not None]
    return u.BarMeasured(cameras=rows, factor=round(float(np.mean(known)), DECIMALS) if known else None)


@router.post("/aspect/factor")
def post_factor(folder: Folder, body: u.FactorBody) -> u.Bars:
    """State it; files are made anew with it."""
    change_session(folder, {("cameras", "aspect_ratio"): body.factor})
    return get_bars(folder)


def _recordings(folder: Folder) -> list[str]:
    """Images of all cameras, of whatever they are."""
    names = Session.open(folder).settings.cameras.names
    found = propose_session(folder).recordings
    return [one.path for one in found if one.content == "images" and names and {*names} <= {*one.cameras}]


def _bar_row(camera: str, source: ImageSource, method: Centroids) -> u.BarRow:
    try:
        found = bar_aspect(source, method=method)
    except KinemarkError as error:
        return u.BarRow(camera=camera, factor=None, sd=None, words=str(error))
    return u.BarRow(camera=camera, factor=found.ratio.factor, sd=found.ratio.sd, words=found.said())
