"""A session is made from recordings: which folders hold some, what they propose, and the first session.toml."""

from __future__ import annotations

from fastapi import APIRouter

from ...data import KinemarkError
from ...engine.first_session import write_first_session
from .home_routes import TheDesk
from .new_folders import folder_of, new_folders
from .new_session import form, lacking, said_of
from .new_session_messages import MadeSession, NewFolders, ProposedSession, SaidOfRecordings
from .shelf import Place, session_names

router = APIRouter(prefix="/api/recordings")


@router.get("")
def get_folders(desk: TheDesk) -> NewFolders:
    """Folders that hold recordings and no session."""
    return NewFolders(folders=[folder for _, folder in new_folders(desk.shelf).values()])


@router.post("/{folder}/proposal")
def post_proposal(folder: str, desk: TheDesk, body: SaidOfRecordings) -> ProposedSession:
    """What a folder's recordings propose, with what was said; nothing is written."""
    return form(folder, folder_of(desk.shelf, folder), body)


@router.post("/{folder}/session")
def post_session(folder: str, desk: TheDesk, body: SaidOfRecordings) -> MadeSession:
    """Write the first session.toml, never over one that is there."""
    place = folder_of(desk.shelf, folder)
    proposal, wrong = said_of(place, body)
    if why := lacking(proposal, wrong):
        raise KinemarkError(why)
    write_first_session(proposal)
    trials = [Place(place, name).id for name in session_names(place)]
    return MadeSession(session=Place(place).id, trials=trials)
