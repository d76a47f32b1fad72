"""Whose recordings they are, and of which day: as a session's file says it, or the recording's own file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, replace
from datetime import datetime
from pathlib import Path

from ..data import Identity, Trial
from ..io.c3d import subject_of
from .recordings import files_of
from .settings import Settings, TrialEntry


def stated_identity(settings: Settings, entry: TrialEntry | None = None) -> Identity:
    """What the session's file says of a trial, or of the session."""
    subject, date = settings.subject or ", ".join(settings.subjects_of(entry)), settings.date
    if entry is not None:
        subject, date = entry.subject or subject, entry.date or date
    return Identity(subject or "", date.isoformat() if date else "")


def identity_of_entry(
    root: Path, settings: Settings, entry: TrialEntry, about: Mapping[str, str] | None = None
) -> dict[str, str]:
    """The same with the date of the trial's files, as plain data; what nobody states is as the recording says it.

    Args:
        root: the session's folder; settings, entry: what its file says.
        about: what the recording says of itself, "subject" and "date".
    """
    stated = _completed(stated_identity(settings, entry), about or {})
    if entry.detections is not None:
        paths = [root / entry.detections]
    else:
        paths = files_of(root, settings, entry.images, settings.cameras.names)
    return asdict(Identity(stated.subject, stated.date, file_date(paths)))


def identity_of_file(trial: Trial, path: Path) -> dict[str, str]:
    """What a file of a trial says of itself, as plain data."""
    own = Identity(subject_of(trial.source), file_date=file_date([path]))
    return asdict(_completed(own, trial.about))


def with_identity(about: Mapping[str, str], identity: Mapping[str, str]) -> dict[str, str]:
    """What is known of a recording, with subject and day as they stand on its pages."""
    said = {key: identity[key] for key in ("subject", "date")}
    return dict(about) | {key: text for key, text in said.items() if not about.get(key, "").startswith(text)}


def _completed(stated: Identity, about: Mapping[str, str]) -> Identity:
    """With subject and day as a recording says them, where they were not stated."""
    subject, date = about.get("subject", ""), about.get("date", "")[:10]
    return replace(stated, subject=stated.subject or subject, date=stated.date or date)


def file_date(paths: Iterable[Path]) -> str:
    """The day when the first of these files was last changed, YYYY-MM-DD; empty where there are none."""
    times = [path.stat().st_mtime for path in paths if path.is_file()]
    return datetime.fromtimestamp(min(times)).date().isoformat() if times else ""
