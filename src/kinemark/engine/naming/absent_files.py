"""Whether the files that a session names its markers by are there, looked at before hours of work."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ...data import KinemarkError
from ..settings import Settings, TrialEntry


def check_files_of_names(root: Path, settings: Settings, entry: TrialEntry) -> None:
    """Raises KinemarkError, which names all, where files of `[label]` for a trial are not in the session's folder."""
    absent = [file for file in dict.fromkeys(_named(settings, entry)) if not (root / file).is_file()]
    if absent:
        verb, they = ("is not a file", "it") if len(absent) == 1 else ("are no files", "them")
        raise KinemarkError(
            f"[label] names {', '.join(absent)}, which {verb} in {root}. Correct the path, or leave {they} out."
        )


def _named(settings: Settings, entry: TrialEntry) -> Iterator[str]:
    """The files by which the markers of a trial's subjects are named."""
    apart = [settings.of_subject(name) for name in settings.subjects_of(entry)] or [settings]
    for label in (one.label for one in apart):
        if label is not None:
            yield from (*label.template, *label.static, *((label.names,) if label.names else ()))
