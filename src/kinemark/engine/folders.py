"""Folders where files of trajectories are wanted: whoever has a hundred trials names their folder."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from ..data import KinemarkError
from .session_name import FILE

RECORDINGS = (".c3d", ".trc", ".tdf", ".tdc")
"""Endings of files that hold trajectories and nothing else that a folder might be full of, as CSV are."""


def trials_in(paths: Iterable[Path], *, besides: Sequence[Path | None] = ()) -> tuple[Path, ...]:
    """The paths, with the files of a folder that end as `RECORDINGS` in its place, by name.

    Folders in it are not looked at. A session stays as it is. A file that several of them name counts once.

    Args:
        paths: of files and folders. besides: files that are no trials, as the standing one, which folders leave out.

    Raises:
        KinemarkError: a folder has no such file.
    """
    left_out = {path.resolve() for path in besides if path is not None}
    found: dict[Path, Path] = {}
    for path in paths:
        some = _of_folder(path, left_out) if path.is_dir() and not (path / FILE).is_file() else (path,)
        for one in some:
            found.setdefault(one.resolve(), one)
    return tuple(found.values())


def _of_folder(folder: Path, left_out: set[Path]) -> list[Path]:
    there = sorted(path for path in folder.iterdir() if path.suffix.lower() in RECORDINGS and path.is_file())
    if kept := [path for path in there if path.resolve() not in left_out]:
        return kept
    deeper = sorted({str(path.parent) for path in folder.glob("*/*") if path.suffix.lower() in RECORDINGS})
    advice = f" There are some in {', '.join(deeper[:3])}: name those folders." if deeper else ""
    raise KinemarkError(f"{folder} has no file that ends with {', '.join(RECORDINGS)}, and no {FILE}.{advice}")
