"""Whether the files that a session names its markers by are there, looked at before hours of work."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ...data import KinemarkError
from ..settings import Settings


def check_files_of_names(root: Path, settings: Settings) -> None:
    """Raises KinemarkError, which names all, where files of `[label]` are not in the session's folder `root`."""
    absent = [file for file in dict.fromkeys(_named(settings)) if not (root / file).is_file()]
    if absent:
        verb, they = ("is not a file", "it") if len(absent) == 1 else ("are no files", "them")
        raise KinemarkError(
            f"[label] names {', '.join(absent)}, which {verb} in {root}. Correct the path, or leave {they} out."
        )


def _named(settings: Settings) -> Iterator[str]:
    """The files by which the markers of all subjects are named."""
    apart = [settings.of_subject(name) for name in settings.subjects_of()] or [settings]
    for label in (one.label for one in apart):
        if label is not None:
            yield from (*label.template, *label.static, *((label.names,) if label.names else ()))
