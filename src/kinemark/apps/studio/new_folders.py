"""Folders below the roots that hold recordings and no session, each by an id: where a session can be made."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from ...engine.first_session import Role
from ...engine.first_session.calibration_way import WAYS
from ...engine.first_session.folder_files import is_picture, is_video
from ...engine.first_session.roles import role_of
from ...engine.keys import digest
from ...engine.session_name import FILE
from .new_session_messages import NewFolder
from .shelf import DEPTH, DROPPED, SKIPPED, NotThere, Shelf

OTHERS = (".tdf", ".da1", ".h5")
"""Endings of recordings that are no images."""
CALIBRATING = (*WAYS, Role.L_FRAME, Role.GRID, Role.CALIBRATION)
"""What recordings of a session are for, besides trials."""
CAMERAS_DEEP = 2
"""Folders below a session's that its recordings may lie in: of a trial, and of a camera; by convention."""


class Held(NamedTuple):
    """What a folder holds: images and other recordings, in it and below.

    near: how many folders deep the first lie. whole: whether a folder is among them that a session is made of for
    sure, or was.
    """

    stills: int = 0
    films: int = 0
    near: int = 99
    whole: bool = False


def new_folders(shelf: Shelf) -> dict[str, tuple[Path, NewFolder]]:
    """All of them by id, in order of their paths."""
    found = {}
    for root in shelf.roots:
        for folder, held in _looked(root, root, DEPTH + CAMERAS_DEEP)[0] if root.is_dir() else ():
            key = digest(str(folder), "recordings")
            place = folder.relative_to(root.parent).as_posix()
            found[key] = folder, NewFolder(id=key, title=folder.name, folder=place, words=_words(held))
    return found


def folder_of(shelf: Shelf, key: str) -> Path:
    """The folder of an id.

    Raises:
        NotThere: there is none, or a session was made of it.
    """
    found = new_folders(shelf).get(key)
    if found is None:
        raise NotThere("There is no such folder of recordings, or it has a session by now. Go to Home and look.")
    return found[0]


def _looked(folder: Path, root: Path, depth: int) -> tuple[list[tuple[Path, Held]], Held]:
    """The folders in one that a session can be made of, itself first; and what it holds."""
    if (folder / FILE).exists():
        return [], Held(whole=True)
    try:
        entries = sorted(folder.iterdir())
    except OSError:  # not ours to read
        return [], Held()
    names = [path.name for path in entries if path.is_file()]
    films = sum(is_video(name) or name.lower().endswith(OTHERS) for name in names)
    stills = sum(is_picture(name) for name in names) - sum(map(is_video, names))
    below = [_looked(path, root, depth - 1) for path in entries if depth and _ours(path, root)]
    found = [one for inner, _ in below for one in inner]
    near = min([0 if films or stills else 99, *(1 + held.near for _, held in below)])
    all_films, all_stills = films + sum(h.films for _, h in below), stills + sum(h.stills for _, h in below)
    whole, calibrated = any(held.whole for _, held in below), near <= CAMERAS_DEEP and _calibrated(entries)
    held = Held(all_stills, all_films, near, whole or calibrated)
    if calibrated and not whole:
        return [(folder, held)], held
    if near <= CAMERAS_DEEP and not whole:
        leaves = {path for path, inner in found if inner.near == 0 and not inner.films}  # images of a camera
        found = [(folder, held), *(one for one in found if one[0] not in leaves)]
    return found, held


def _calibrated(entries: list[Path]) -> bool:
    """Whether one of a folder's files or folders calibrates by its name, so that the others are its trials."""
    return any(role_of(path.name)[0] in CALIBRATING for path in entries)


def _ours(path: Path, root: Path) -> bool:
    """Whether it is a folder of recordings that lies below the root in truth."""
    skipped = path.name in (*SKIPPED, DROPPED) or path.name.startswith(".")
    return not skipped and path.is_dir() and path.resolve().is_relative_to(root)


def _words(held: Held) -> str:
    films = f"{held.films} recording{'s' * (held.films != 1)}" if held.films else ""
    stills = f"{held.stills} image{'s' * (held.stills != 1)}" if held.stills else ""
    return ", ".join(filter(None, (films, stills)))
