"""What may be opened, files that are dropped, and sessions that are made from recordings."""

from __future__ import annotations

import re
import secrets
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request
from starlette.concurrency import run_in_threadpool

from ...data import KinemarkError
from ...engine.editing.editing import Editing
from ...engine.first_session import write_first_session
from .desk import Desk
from .home import home
from .messages import Dropped, Home
from .new_session import folder_of, form, lacking, new_folders, said_of
from .new_session_messages import MadeSession, NewFolders, ProposedSession, SaidOfRecordings
from .problems import worth_a_look
from .shelf import ENDINGS, Place, session_names

LONGEST_NAME = 120
"""Characters of a dropped file's name; chosen, as file systems take 255 bytes."""
router = APIRouter(prefix="/api")


def bytes_of(kind: str) -> dict[int | str, dict[str, Any]]:
    """What OpenAPI says of an answer that is no JSON, by its media type."""
    return {200: {"content": {kind: {"schema": {"type": "string", "format": "binary"}}}}}


BINARY, PNG, JPEG = map(bytes_of, ("application/octet-stream", "image/png", "image/jpeg"))


def desk_of(request: Request) -> Desk:
    """The desk of the app."""
    desk = request.app.state.desk
    assert isinstance(desk, Desk)
    return desk


async def desk_at_once(request: Request) -> Desk:
    """The same without waiting for a thread, as what is not awaited does."""
    return desk_of(request)


TheDesk = Annotated[Desk, Depends(desk_at_once)]


@router.get("/home")
def get_home(request: Request, desk: TheDesk) -> Home:
    """Sessions with their trials, and files."""
    looked = {key: worth_a_look(document) for key, document in desk.documents().items()}
    return home(desk.shelf, request.app.state.live.failed, looked)


@router.post("/files", openapi_extra={"requestBody": {"content": {"application/octet-stream": {}}, "required": True}})
async def post_file(request: Request, desk: TheDesk, name: str) -> Dropped:
    """Keep a file that was dropped on the page, in the studio's own folder, if it can be read."""
    folder = desk.shelf.home
    target = kept_name(folder, name)
    beside = folder / f".{secrets.token_hex(8)}.part{target.suffix}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with beside.open("xb") as file:
            async for part in request.stream():
                file.write(part)
        editing = await run_in_threadpool(Editing.of_file, beside)
        target = beside.rename(kept_name(folder, name))
    except KinemarkError as error:
        raise KinemarkError(str(error).replace(str(beside), name)) from error
    except OSError as error:
        raise KinemarkError(f"{target} cannot be written: {error}.") from error
    finally:
        beside.unlink(missing_ok=True)
    assert editing.source is not None
    return Dropped(id=Place(target.resolve()).id, words=list(editing.source.notes))


def kept_name(folder: Path, name: str) -> Path:
    """A name in the folder that no file has, made of what was given: letters, digits, space, dot, dash.

    Raises:
        KinemarkError: it has an ending that is not read.
    """
    given = Path(name.replace("\\", "/")).name[-LONGEST_NAME:]
    if (ending := Path(given).suffix.lower()) not in ENDINGS:
        raise KinemarkError(f"{given!r} has none of the endings {', '.join(ENDINGS)}. Convert it: kinemark convert.")
    stem = re.sub(r"[^\w\- .]", "_", Path(given).stem).strip(" .") or "trial"
    k = 1
    while (found := folder / f"{stem}{'' if k == 1 else f' {k}'}{ending}").exists():
        k += 1
    return found


@router.get("/recordings")
def get_folders(desk: TheDesk) -> NewFolders:
    """Folders that hold recordings and no session."""
    return NewFolders(folders=[folder for _, folder in new_folders(desk.shelf).values()])


@router.post("/recordings/{folder}/proposal")
def post_proposal(folder: str, desk: TheDesk, body: SaidOfRecordings) -> ProposedSession:
    """What a folder's recordings propose, with what was said; nothing is written."""
    return form(folder, folder_of(desk.shelf, folder), body)


@router.post("/recordings/{folder}/session")
def post_session(folder: str, desk: TheDesk, body: SaidOfRecordings) -> MadeSession:
    """Write the first session.toml, never over one that is there."""
    place = folder_of(desk.shelf, folder)
    proposal, wrong = said_of(place, body)
    if why := lacking(proposal, wrong):
        raise KinemarkError(why)
    write_first_session(proposal)
    trials = [Place(place, name).id for name in session_names(place)]
    return MadeSession(session=Place(place).id, trials=trials)
