"""The start of digitising, written into `session.toml`: the markers, the reference marker, where answers are kept."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import date
from pathlib import Path
from typing import Any

from tomlkit import TOMLDocument

from ...data import KinemarkError
from ...io.answers_csv import read_answers
from ...io.um2as import read_rf
from ..recordings import open_cameras
from ..session import Session
from ..session_changes import parsed, table_in, write_session
from ..session_name import FILE
from ..settings import TrialEntry
from .files import answer_files

MOST_MARKERS = 30
"""Of a frame, the reference marker included; as UM²AS has it (thesis 3.5)."""


@dataclass(frozen=True, slots=True)
class DigitisingSetup:
    """What `[digitise]` and the trial say.

    Attributes:
        markers: their names, in the order in which they are asked for.
        reference: the one that does not move; None where there is none.
        confirm_reference: whether it is asked about in every frame.
        take_proposals: whether what the other cameras say is taken without a question.
        history: frames for which a hidden marker is remembered.
        every: one frame of so many of the recording is taken.
        last_frame: that is digitised, counted from 1 among those that are taken; None for all.
        reference_files: what UM²AS's files of the reference marker are called before `.rf1` …; None: the first frame
            says where it is.
        recorded: the day of the recording, which stands on every page; None where nobody says it.
    """

    markers: tuple[str, ...]
    reference: str | None = None
    confirm_reference: bool = True
    take_proposals: bool = False
    history: int = 2
    every: int = 1
    last_frame: int | None = None
    reference_files: str | None = None
    recorded: date | None = None


@dataclass(frozen=True, slots=True)
class DigitisingChoices:
    """What may be chosen: of so many frames of the recording; names of sets of `.rf` files; and what is chosen now.

    `operated`: whether the trial is one that an operator digitises.
    """

    frames: int
    reference_files: tuple[str, ...]
    now: DigitisingSetup
    operated: bool


def choices(root: Path, trial: str) -> DigitisingChoices:
    """What may be chosen for a trial.

    Raises:
        KinemarkError: it has no images, or they cannot be read.
    """
    session = Session.open(root)
    entry, cameras = _entry(session, trial), session.camera_names
    sources = open_cameras(root, session.settings, str(entry.images), cameras)
    method = session.settings.digitise
    last = entry.frames[1] if entry.frames else None
    now = DigitisingSetup((), every=entry.every, last_frame=last, recorded=entry.date or session.settings.date)
    if method is not None:
        now = replace(
            now, markers=method.markers, reference=method.reference, confirm_reference=method.confirm_reference,
            take_proposals=method.take_proposals, history=method.history,
        )  # fmt: skip
    shortest = min(source.n_frames for source in sources.values())
    return DigitisingChoices(shortest, _reference_sets(root, len(cameras)), now, entry.answers is not None)


def set_up(root: Path, trial: str, setup: DigitisingSetup) -> None:
    """Write the start of digitising a trial; comments stay.

    Raises:
        KinemarkError: there are no markers or too many, an answer was given already, or the file would not be
            understood then.
    """
    if not 1 <= len(setup.markers) <= MOST_MARKERS:
        raise KinemarkError(f"There are {len(setup.markers)} markers. Name 1 to {MOST_MARKERS}.")
    session = Session.open(root)
    entry = _entry(session, trial)
    if entry.answers is not None:
        _check_unanswered(session, trial, entry.answers)
    document = parsed(root / FILE)
    _method(table_in(document, "digitise"), setup)
    if setup.reference_files is not None:
        marks = table_in(document["calibration"], "reference_marker")
        for name, place in _reference_places(root, setup.reference_files, session.camera_names).items():
            marks[name] = [place]
    own = _table_of(document, trial)
    if "answers" not in own:
        own["answers"] = f"answers/{trial}/{{camera}}.csv"
    if setup.every > 1:
        own["every"] = setup.every
    else:
        own.pop("every", None)
    if setup.last_frame is not None:
        own["frames"] = [1, setup.last_frame]
    else:
        own.pop("frames", None)
    if setup.recorded not in (None, session.settings.date):
        own["date"] = setup.recorded
    write_session(root / FILE, document)


def leave_off(root: Path, trial: str) -> None:
    """Nobody digitises the trial: its markers are found by themselves, as long as no answer was given.

    Raises:
        KinemarkError: one was, or the file cannot be written.
    """
    session = Session.open(root)
    entry = _entry(session, trial)
    if entry.answers is None:
        return
    _check_unanswered(session, trial, entry.answers)
    document = parsed(root / FILE)
    _table_of(document, trial).pop("answers")
    write_session(root / FILE, document)


def _table_of(document: TOMLDocument, trial: str) -> Any:
    """A trial's own table."""
    trials: Any = document["trials"]
    return next(one for one in trials if one["name"] == trial)


def _method(table: Any, setup: DigitisingSetup) -> None:
    """`[digitise]`; what else stands there stays."""
    table["markers"] = list(setup.markers)
    for key in ("confirm_reference", "take_proposals", "history"):
        table[key] = getattr(setup, key)
    if setup.reference is None:
        table.pop("reference", None)
    else:
        table["reference"] = setup.reference


def _entry(session: Session, trial: str) -> TrialEntry:
    entry = session.trial(trial).entry
    if entry.images is None:
        raise KinemarkError(f"{trial} has no images: its detections were made elsewhere.")
    return entry


def _check_unanswered(session: Session, trial: str, pattern: str) -> None:
    """Answers are to the questions that the present markers lead to."""
    for path in answer_files(session.root, pattern, session.camera_names).values():
        if n := len(read_answers(path)):
            raise KinemarkError(
                f"{path.name} has {n} answers, which are of the present markers. Take them back, or remove the file, "
                f"before {trial} is set up otherwise."
            )


def _reference_sets(root: Path, cameras: int) -> tuple[str, ...]:
    """Names in the session's folder that have an `.rf` file for every camera."""
    names = sorted(path.stem for path in root.glob("*.rf1"))
    return tuple(name for name in names if all((root / f"{name}.rf{k + 1}").is_file() for k in range(cameras)))


def _reference_places(root: Path, name: str, cameras: tuple[str, ...]) -> dict[str, list[float]]:
    """[u, v] px of each camera's reference marker.

    Raises:
        KinemarkError: there is no such set, or a file is wrong.
    """
    there = _reference_sets(root, len(cameras))
    if name not in there:
        raise KinemarkError(f"There are no files {name}.rf1 … of all cameras; there are {', '.join(there) or 'none'}.")
    return {camera: read_rf(root / f"{name}.rf{k + 1}").tolist() for k, camera in enumerate(cameras)}
