"""One trial: its header and samples, what is wrong with it, what was said and what can be."""

from __future__ import annotations

import json
from contextlib import suppress
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, Response

from ...data import KinemarkError, Trajectories
from ...engine.keys import digest
from . import edit_messages as e
from . import messages as m
from .acts import act, preview, seen_anew
from .desk import OpenDocument
from .gaps import candidates, chosen_fills, gap_table
from .header import header
from .history import history, versions_apart
from .home_routes import BINARY, TheDesk, desk_of
from .images import mosaic_of, mosaics_of
from .labels import labels
from .live import TheLive
from .paths import COLUMNS, DEFAULT, encoded, forget_others
from .problems import listed
from .shelf import NotThere
from .worn_sets import choose_set, set_choices

router = APIRouter(prefix="/api/trials/{trial}")


def document_of(request: Request, trial: str) -> OpenDocument:
    """The open trial that an address names."""
    return desk_of(request).document(trial)


Document = Annotated[OpenDocument, Depends(document_of)]


@router.get("")
def get_header(document: Document) -> m.TrialHeader:
    """All but the samples."""
    if (mosaics := mosaics_of(document)) is not None:
        mosaics.begin()
    return header(document, mosaic_of(document))


@router.get("/paths", response_class=Response, responses=BINARY)
def get_paths(
    request: Request,
    document: Document,
    marker: Annotated[list[str], Query(max_length=2000)] = [],  # noqa: B006  FastAPI copies it
    view: m.View = "edited",
    column: Annotated[list[m.Column], Query(max_length=len(COLUMNS))] = list(DEFAULT),  # noqa: B006
) -> Response:
    """Samples as `PathsHeader` says; all trajectories where none is named."""
    (shown, pending), head = viewed(document, view), document.head
    names = marker or list(shown.names)
    if strange := sorted({*names} - {*shown.names}):
        raise NotThere(f"There is no {strange[0]!r} in this trial.")
    tag = f'"{digest(head, document.ran, view, names, column)}"'
    if request.headers.get("if-none-match") == tag and view != "filled":
        return Response(status_code=304, headers={"ETag": tag})
    about = m.PathsHeader(
        view=view, names=names, first_frame=shown.first_frame, n_frames=shown.n_frames, columns=column, head=head,
        pending=pending,
    )  # fmt: skip
    paths = {path.name: path for path in shown}
    with document.lock:
        forget_others(document, (document.editing.trajectories, document.now.trajectories, shown))
        body = encoded(document, [paths[name] for name in names], column)
    said = {"X-Kinemark-Paths": json.dumps(about.model_dump()), "ETag": tag, "Cache-Control": "no-cache"}
    return Response(body, media_type="application/octet-stream", headers=said)


def viewed(document: OpenDocument, view: m.View) -> tuple[Trajectories, bool]:
    """The trajectories of a view, and whether some of it is still computed."""
    if view == "filled":
        return chosen_fills(document)
    return (document.editing.trajectories if view == "before" else document.now.trajectories), False


@router.get("/problems")
def get_problems(document: Document) -> e.Problems | None:
    """What is probably wrong, what saves most first; nothing where the trial is edited while they are looked for."""
    return listed(document)


@router.post("/acts", response_model=e.ActDone)
def post_act(trial: str, body: e.ActBody, live: TheLive, desk: TheDesk) -> Response:
    """Say something of the trial."""
    document = desk.document(trial)  # all in one turn of a thread, and no second check: somebody waits for the picture
    before = document.now
    done = act(document, body)
    if document.editing.outdated:
        done = seen_anew(before, desk.document(trial), done)
    live.moved(trial, done.head)
    return Response(done.model_dump_json(), media_type="application/json")


@router.post("/preview")
def post_preview(document: Document, body: e.PreviewBody) -> e.Preview | None:
    """What an act would give, nothing where it cannot be (any more): said as an act, it is refused in words."""
    with suppress(KinemarkError):
        return preview(document, body.act)
    return None


@router.get("/gaps")
def get_gaps(document: Document) -> e.Gaps:
    """All gaps, with what is known of how they can be filled."""
    return gap_table(document)


@router.get("/gaps/{marker}/{first}")
def get_gap(document: Document, marker: str, first: int) -> e.GapCandidates | None:
    """All ways to fill one gap, nothing where there is no such gap (any more)."""
    with suppress(KinemarkError):
        return candidates(document, marker, first)
    return None


@router.get("/labels")
def get_labels(document: Document, ask: bool = False) -> e.Labels:
    """Names of tracks, proposed; for a file without a session where they are asked for, which takes seconds."""
    return labels(document, ask=ask)


@router.get("/marker-sets")
def get_marker_sets(document: Document) -> list[e.MarkerSetChoice]:
    """Marker sets that the subject may wear."""
    return set_choices(document)


@router.post("/marker-set")
def post_marker_set(document: Document, desk: TheDesk, body: e.MarkerSetSaid) -> list[e.MarkerSetChoice]:
    """The marker set that the subject wears; the trial's header has it then."""
    choose_set(desk, document, body.name)
    return set_choices(desk.document(document.place.id))


@router.get("/history")
def get_history(document: Document) -> e.History:
    """What was said."""
    return history(document)


@router.get("/diff")
def get_difference(document: Document, of: int, other: int) -> e.Difference:
    """How two versions differ."""
    return versions_apart(document, of, other)
