"""One trial: its header and its samples."""

from __future__ import annotations

import json
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, Response

from ...data import Trajectories
from ...engine.keys import digest
from .desk import OpenDocument
from .header import header
from .home_routes import desk_of
from .messages import PathsHeader, TrialHeader, View
from .paths import COLUMNS, DEFAULT, encoded, forget_others
from .shelf import NotThere

BINARY = {200: {"content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}}}}
router = APIRouter(prefix="/api/trials/{trial}")


def document_of(request: Request, trial: str) -> OpenDocument:
    """The open trial that an address names."""
    return desk_of(request).document(trial)


Document = Annotated[OpenDocument, Depends(document_of)]


@router.get("")
def get_header(document: Document) -> TrialHeader:
    """All but the samples."""
    return header(document, None)


@router.get("/paths", response_class=Response, responses=BINARY)  # type: ignore[arg-type]
def get_paths(
    request: Request,
    document: Document,
    marker: Annotated[list[str], Query(max_length=2000)] = [],  # noqa: B006  FastAPI copies it
    view: View = "edited",
    column: Annotated[list[str], Query(max_length=len(COLUMNS))] = list(DEFAULT),  # noqa: B006
) -> Response:
    """Samples as `PathsHeader` says; all trajectories where none is named."""
    shown, head = viewed(document, view), document.head
    names = marker or list(shown.names)
    strange = [*({*names} - {*shown.names}), *({*column} - {*COLUMNS})]
    if strange:
        raise NotThere(f"There is no {strange[0]!r} in this trial.")
    tag = f'"{digest(head, document.ran, view, names, column)}"'
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers={"ETag": tag})
    about = PathsHeader(
        view=view, names=names, first_frame=shown.first_frame, n_frames=shown.n_frames, columns=column, head=head
    )  # type: ignore[arg-type]
    with document.lock:
        forget_others(document, (document.editing.trajectories, document.now.trajectories, shown))
        body = encoded(document, [shown[name] for name in names], column)
    said = {"X-Kinemark-Paths": json.dumps(about.model_dump()), "ETag": tag, "Cache-Control": "no-cache"}
    return Response(body, media_type="application/octet-stream", headers=said)


def viewed(document: OpenDocument, view: View) -> Trajectories:
    """The trajectories of a view."""
    return document.editing.trajectories if view == "before" else document.now.trajectories
