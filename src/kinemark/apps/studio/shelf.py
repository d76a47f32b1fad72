"""What may be opened: the sessions, trials and files below the roots of the command line, each by an id.

The page never names a path: it names an id, which is looked up here. What a symbolic link leads out of its root for is
not there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ...data import KinemarkError
from ...engine.folders import is_recording
from ...engine.keys import digest
from ...engine.session import Session
from ...engine.session_name import FILE

ENDINGS = (".c3d", ".trc", ".tdf", ".tsv")
"""Of files of trajectories that are shown without being named."""
DEPTH = 3
"""Folders below a root that are looked into; chosen: a laboratory's year, patient and session."""
MOST = 2000
"""Files and sessions of a root that are shown; chosen: more are not read on a screen."""
DROPPED = "dropped"
"""Folder below the first root where files are kept that were dropped on the page."""
SKIPPED = ("results", "edits")
"""Folders that hold what is ours."""


class NotThere(KinemarkError):
    """Nothing has this id."""


@dataclass(frozen=True, slots=True)
class Place:
    """A trial: of a session, by its name; or a file of trajectories, where `trial` is None."""

    path: Path
    trial: str | None = None

    @property
    def id(self) -> str:
        """What the page calls it."""
        return digest(str(self.path), self.trial)

    @property
    def name(self) -> str:
        """What people call it."""
        return self.trial or self.path.name


@dataclass(frozen=True, slots=True)
class Shelf:
    """The roots: folders and files, resolved."""

    roots: tuple[Path, ...]

    @classmethod
    def of(cls, paths: tuple[Path, ...]) -> Shelf:
        """The shelf of what the command line names.

        Raises:
            KinemarkError: one of them is not there.
        """
        for path in paths:
            if not path.exists():
                raise KinemarkError(f"{path} is not there. Give a folder of sessions, a session, or a file.")
        return cls(tuple(dict.fromkeys(path.resolve() for path in paths)))

    @property
    def home(self) -> Path:
        """The folder where dropped files are kept."""
        first = self.roots[0]
        return (first if first.is_dir() else first.parent) / DROPPED

    def sessions(self) -> list[Path]:
        """The folders of sessions."""
        found = [path for path in self._found() if path.name == FILE]
        return [path.parent for path in found]

    def files(self) -> list[Place]:
        """Files of trajectories."""
        return [Place(path) for path in self._found() if path.name != FILE]

    def trials(self) -> Iterator[Place]:
        """Every trial and file."""
        for folder in self.sessions():
            yield from (Place(folder, name) for name in session_names(folder))
        yield from self.files()

    def place(self, key: str) -> Place:
        """The trial or file of an id.

        Raises:
            NotThere: there is none.
        """
        for place in self.trials():
            if place.id == key:
                return place
        raise NotThere("There is no such trial. Go to Home and look what is there now.")

    def session(self, key: str) -> Path:
        """The folder of the session of an id.

        Raises:
            NotThere: there is none.
        """
        for folder in self.sessions():
            if Place(folder).id == key:
                return folder
        raise NotThere("There is no such session. Go to Home and look what is there now.")

    def _found(self) -> list[Path]:
        """Session files and files of trajectories below the roots."""
        found = dict[Path, None]()
        for root in (*self.roots, *([self.home.resolve()] if self.home.is_dir() else [])):
            if root.is_file():
                found[root] = None
                continue
            below = (path for path in _below(root, DEPTH) if path.resolve().is_relative_to(root))
            for path, _ in zip(below, range(MOST), strict=False):
                found[path] = None
        return list(found)


def session_names(folder: Path) -> tuple[str, ...]:
    """The trials of a session; none where it cannot be read."""
    try:
        return Session.open(folder).names
    except KinemarkError:
        return ()


def _below(folder: Path, depth: int) -> Iterator[Path]:
    """Session files and files of trajectories in a folder and those below it; a session's own folders are its own."""
    try:
        entries = sorted(folder.iterdir())
    except OSError:  # not ours to read
        return
    if (folder / FILE).is_file():
        yield folder / FILE
        entries = [path for path in entries if path.name == DROPPED]
    yield from (path for path in entries if is_recording(path, ENDINGS))
    for path in entries:
        if depth and path.is_dir() and path.name not in SKIPPED and not path.name.startswith("."):
            yield from _below(path, depth - 1)
