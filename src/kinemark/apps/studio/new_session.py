"""The form of a first session: what the recordings propose, with what the person says of them."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any, Literal

from ...data import KinemarkError
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
from ...engine.keys import digest
from ...engine.session_name import FILE
from ...engine.settings import read_settings
from ...report.words.first_session import ROLES, question_text, reason_text
from .new_session_messages import Asked, ProposedSession, RecordingRow, RoleRow, SaidOfRecordings


def said_of(folder: Path, said: SaidOfRecordings) -> tuple[SessionProposal, dict[str, str]]:
    """The proposal with what was said, and why answers are none, by the keys of their questions.

    Raises:
        KinemarkError: the folder has no recordings, or what was said cannot be.
    """
    proposal, wrong = propose_session(folder), dict[str, str]()
    paths = {_id(one): one.path for one in proposal.recordings}
    try:
        for key, role in said.roles.items():
            proposal = with_role(proposal, paths.get(key, ""), role)
        names = {paths.get(key, ""): name for key, name in said.names.items()}
        field: Any = {None: None, "whole": False}.get(said.fields, said.fields)
        proposal = with_facts(proposal, name=said.name, date=said.date, rate=said.rate, interlaced=field, names=names)
    except ValueError as error:
        raise KinemarkError(f"{error}.") from error
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
    return RecordingRow(
        id=_id(one),
        file=one.path,
        content=one.content,
        cameras=list(one.cameras),
        role=one.role,
        why=reason_text(one.why),
        name=one.name,
        frames=one.frames,
        rate=one.rate,
        size=one.size,
        unequal=one.unequal,
    )


def asked_row(question: Question, answer: str, wrong: str) -> Asked:
    """A question as the page shows it."""
    return Asked(
        key=question.key,
        words=question_text(question),
        least=question.least,
        most=question.most,
        choices=list(question.choices),
        optional=question.optional,
        answer=answer,
        wrong=wrong,
    )


def _id(one: FoundRecording) -> str:
    """What the page calls a recording."""
    return digest(one.path)
