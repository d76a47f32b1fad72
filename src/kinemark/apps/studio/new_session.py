"""A session that is made from recordings, on the screen: folders that hold some, what they propose, what is asked."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any, Literal, NamedTuple

from ...data import KinemarkError
from ...data.errors import users_mistake
from ...engine.first_session import (
    FoundRecording,
    Question,
    Role,
    SessionProposal,
    answered,
    propose_session,
    session_text,
    with_facts,
    with_role,
)
from ...engine.first_session.calibration_way import WAYS
from ...engine.first_session.folder_files import is_picture, is_video
from ...engine.first_session.role_words import role_of
from ...engine.keys import digest
from ...engine.session_name import FILE
from ...engine.settings import read_settings
from ...report.words.first_session import ROLES, question_text, reason_text
from .new_session_messages import Asked, NewFolder, ProposedSession, RecordingRow, RoleRow, SaidOfRecordings
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


def said_of(folder: Path, said: SaidOfRecordings) -> tuple[SessionProposal, dict[str, str]]:
    """The proposal with what was said, and why answers are none, by the keys of their questions.

    Raises:
        KinemarkError: the folder has no recordings, or what was said cannot be.
    """
    proposal, wrong = propose_session(folder), dict[str, str]()
    paths = {_id(one): one.path for one in proposal.recordings}
    with users_mistake():
        for key, role in said.roles.items():
            proposal = with_role(proposal, paths.get(key, ""), role)
        names = {paths.get(key, ""): name for key, name in said.names.items()}
        field: Any = {None: None, "whole": False}.get(said.fields, said.fields)
        proposal = with_facts(proposal, name=said.name, date=said.date, rate=said.rate, interlaced=field, names=names)
    for key, text in said.answers.items():
        if text.strip() and key in [one.key for one in proposal.questions]:
            try:
                proposal = answered(proposal, key, text)
            except ValueError as error:
                wrong[key] = str(error)
    return proposal, wrong


def form(key: str, folder: Path, said: SaidOfRecordings) -> ProposedSession:
    """The proposal as the page shows it; raises as `said_of` does."""
    proposal, wrong = said_of(folder, said)
    fields: Literal["whole", "top", "bottom"] = proposal.interlaced or "whole"
    return ProposedSession(
        id=key,
        folder=folder.name,
        name=proposal.name,
        date=proposal.date,
        cameras=list(proposal.cameras),
        cameras_why=reason_text(proposal.cameras_why),
        rate=proposal.rate,
        rate_why=reason_text(proposal.rate_why),
        fields=fields,
        fields_why=reason_text(proposal.interlaced_why),
        recordings=[_row(one) for one in proposal.recordings],
        roles=[RoleRow(key=role, words=ROLES[role]) for role in Role],
        way="" if proposal.way is None else _id(proposal.way),
        questions=[asked_row(one, said.answers.get(one.key, ""), wrong.get(one.key, "")) for one in proposal.questions],
        notes=[reason_text(note) for note in proposal.notes],
        text=session_text(proposal),
        lacking=lacking(proposal, wrong),
    )


def lacking(proposal: SessionProposal, wrong: dict[str, str]) -> str:
    """Why a session cannot be made of a proposal yet; empty where it can."""
    if wrong:
        return "An answer is not understood."
    if proposal.open:
        return f"Asked is: {question_text(proposal.open[0])}"
    if not proposal.cameras:
        return "Nothing says which recording is of which camera. Name files or folders after them: cam1, cam2."
    if proposal.way is None:
        return "Nothing calibrates the cameras. Say which recording does."
    if not proposal.trials:
        return "No recording is a trial. Say which are."
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / FILE
        file.write_text(session_text(proposal), "utf-8")
        try:
            read_settings(file)
        except KinemarkError as error:
            return str(error).replace(str(file), FILE)
    return ""


def _row(one: FoundRecording) -> RecordingRow:
    return RecordingRow.like(one, id=_id(one), file=one.path, why=reason_text(one.why))


def asked_row(question: Question, answer: str, wrong: str) -> Asked:
    """A question as the page shows it."""
    return Asked.like(question, words=question_text(question), answer=answer, wrong=wrong)


def _id(one: FoundRecording) -> str:
    """What the page calls a recording."""
    return digest(one.path)
