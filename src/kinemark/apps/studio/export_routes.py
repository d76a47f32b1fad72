"""What leaves the studio: the edited file, and the report as a page and on paper."""

from __future__ import annotations

import tempfile
from pathlib import Path

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, Response

from ...data import KinemarkError
from ...engine.editing.files import write_edited
from ...engine.trial_graph import REPORT
from ...io.notes import file_note_text
from ...report.drawing_library import ASSETS, self_contained
from ..pdf import print_pdf
from .desk import Desk, OpenDocument
from .home import newer
from .home_routes import TheDesk
from .messages import ExportBody, Exported
from .shelf import NotThere
from .trial_routes import Document

SANDBOX = (
    "sandbox allow-scripts allow-popups; default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; "
    "style-src 'unsafe-inline'; img-src data: blob:; frame-ancestors 'self'"
)
"""The report is a page of its own, with its scripts in it: it has no origin, so it can ask the server for nothing."""
MOST_NAMES = 1000
"""Files of one trial that are written beside each other; chosen."""
router = APIRouter(prefix="/api/trials/{trial}")


@router.post("/export")
def post_export(document: Document, body: ExportBody) -> Exported:
    """Write the edited trial beside what was given, which is never touched."""
    if document.trial is not None:
        return _of_session(document)
    target = free_name(document.place.path, body.ending)
    notes = write_edited(document.editing, target)
    return Exported(name=target.name, words=[file_note_text(note) for note in notes])


def _of_session(document: OpenDocument) -> Exported:
    """A run has written it; raises a KinemarkError where something was said since."""
    trial = document.trial
    assert trial is not None
    if not (trial.folder / f"{trial.name}.c3d").is_file() or newer(trial):
        raise KinemarkError("The file is written by a run, and something was said or set since. Run the trial first.")
    return Exported(name=f"results/{trial.name}/{trial.name}.c3d")


def free_name(given: Path, ending: str) -> Path:
    """A name beside a file that no file has: walk01-edited.c3d, walk01-edited-2.c3d, …

    Raises:
        KinemarkError: there are too many.
    """
    ending = ending if ending.startswith(".") and ending[1:].isalnum() else ".c3d"
    for k in range(1, MOST_NAMES):
        found = given.with_name(f"{given.stem}-edited{'' if k == 1 else f'-{k}'}{ending}")
        if not found.exists():
            return found
    raise KinemarkError(f"There are {MOST_NAMES} edited files of {given.name}. Remove some.")


@router.get("/report", response_class=HTMLResponse)
def get_report(trial: str, desk: TheDesk) -> HTMLResponse:
    """The report of the last run, with all that it draws with."""
    page = report_of(desk, trial)
    return HTMLResponse(self_contained(page, page.parents[1] / ASSETS), headers={"Content-Security-Policy": SANDBOX})


@router.get("/report.pdf", response_class=Response, responses={200: {"content": {"application/pdf": {}}}})
def get_report_pdf(trial: str, desk: TheDesk) -> Response:
    """The report of the last run on A4 pages, printed by a browser of this computer; 422 where there is none."""
    page = report_of(desk, trial)
    with tempfile.TemporaryDirectory(prefix="kinemark-") as folder:
        printed = print_pdf(page, Path(folder, "report.pdf")).read_bytes()
    return Response(printed, media_type="application/pdf")


class NoReport(NotThere):
    """The trial is there, and no report of it."""


def report_of(desk: Desk, trial: str) -> Path:
    """The report's page.

    Raises:
        NotThere: there is no such trial. NoReport: it is a file, or was not run to its end.
    """
    place = desk.place(trial)
    if place.trial is None:
        raise NoReport(
            f"{place.name} is a file of trajectories: a report is written where a session is run. History says what "
            "was changed here, and writes the edited file."
        )
    page = place.path / "results" / place.trial / REPORT
    if not page.is_file():
        raise NoReport("There is no report yet: run the trial.")
    return page
