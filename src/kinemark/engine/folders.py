"""A folder in place of files of trajectories: all that it holds, for commands that take many files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from ..data import KinemarkError
from ..data.typed import typed
from ..io.formats import IMAGES
from ..io.qualisys_tsv import holds_markers
from ..io.toml_text import toml_table
from .session_name import FILE

RECORDINGS = (".c3d", ".trc", ".tdf", ".tdc", ".tsv")
"""Endings of files that hold trajectories, TSV where they have markers; a folder may be full of other CSV."""
FILLED, GAIT = "_filled", "_gait"
"""What follows a recording's name in that of its results; of gait, a C3D file."""


def trials_in(
    paths: Iterable[Path], *, besides: Sequence[Path | None] = (), say: Callable[[str], None] | None = None
) -> tuple[Path, ...]:
    """The paths, with the files of a folder that end as `RECORDINGS` in its place, by name.

    Folders in it are not looked at, hidden files and results of files beside them are left out. A session and its
    trials stay as they are, and so does a folder without such files: `check_folder` says what is wrong with it. A file
    that several of them name counts once.

    Args:
        paths: of files and folders. besides: files that are no trials, as the standing one, which folders leave out.
        say: told once which results were left out.

    Raises:
        KinemarkError: all are folders without such a file.
    """
    no_trials = {path.resolve() for path in besides if path is not None}
    found, results = dict[Path, Path](), list[Path]()
    for path in paths:
        there = _recordings(path) if _holds_files(path) else []
        results += (made := [one for one in there if _is_result(one, {other.stem for other in there})])
        kept = [one for one in there if one not in made and one.resolve() not in no_trials]
        for one in kept or [path]:
            found.setdefault(one.resolve(), one)
    if found and all(map(_holds_files, found.values())):
        check_folder(next(iter(found.values())))
    if results and say is not None:
        say(f"left out, as results of files beside them: {', '.join(map(str, dict.fromkeys(results)))}")
    return tuple(found.values())


def check_folder(path: Path) -> None:
    """Raises a KinemarkError where a path that `trials_in` gave is a folder, in which there was nothing."""
    if _holds_files(path):
        deeper = sorted(
            {str(one.parent) for folder in path.iterdir() if folder.is_dir() for one in _recordings(folder)}
        )
        advice = f" There are some in {', '.join(deeper[:3])}: name those folders." if deeper else _of_cameras(path)
        raise KinemarkError(f"{path} has no file that ends with {', '.join(RECORDINGS)}, and no {FILE}.{advice}")


def _of_cameras(folder: Path) -> str:
    """What to do with a folder of images and videos."""
    there = any(one.suffix.lower() in IMAGES for one in folder.iterdir())
    return f" Its images or videos need one: kinemark init {typed(folder)}" if there else ""


def is_recording(path: Path, endings: Sequence[str] = RECORDINGS) -> bool:
    """Whether a file is one of trajectories, by its ending; a TSV by its heading, as others end alike."""
    ending = path.suffix.lower()
    return ending in endings and path.is_file() and (ending != ".tsv" or holds_markers(path))


def _holds_files(path: Path) -> bool:
    """Whether it is a folder, and neither a session nor a trial of one."""
    return path.is_dir() and not (path / FILE).is_file() and not _is_trial(path)


def _is_trial(path: Path) -> bool:
    """Whether the session around a folder has a trial of its name; images of a trial often lie in such a folder."""
    file = path.parent / FILE
    if not file.is_file():
        return False
    try:
        trials = toml_table(file.read_text("utf-8-sig"), str(file)).get("trials", [])
        return path.name in [trial.get("name") for trial in trials]
    except (KinemarkError, OSError, ValueError, AttributeError, TypeError):
        # whoever opens the session says what is wrong with it
        return True


def _recordings(folder: Path) -> list[Path]:
    """By name; macOS leaves hidden files as ._walk.c3d beside those that it copies."""
    return sorted(path for path in folder.iterdir() if is_recording(path) and not path.name.startswith("."))


def _is_result(path: Path, names: set[str]) -> bool:
    """Whether it was made of another recording there."""
    ends = (FILLED, GAIT) if path.suffix.lower() == ".c3d" else (FILLED,)
    return any(path.stem.endswith(end) and path.stem.removesuffix(end) in names for end in ends)
