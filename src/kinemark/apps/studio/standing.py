"""Whether a trial can be shown on a screen, asked before it is: what stands in its way is an answer, no error."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request

from ...data import KinemarkError
from .desk import Desk
from .detect_routes import opened_of, place_of
from .digitise_routes import digitising_of
from .export_routes import NoReport, report_of
from .home_routes import desk_of
from .messages import Standing
from .shelf import NotThere

Screen = Literal["trial", "detect", "digitise", "report"]
router = APIRouter(prefix="/api/trials/{trial}")


@router.get("/standing")
def get_standing(request: Request, trial: str, screen: Annotated[Screen, Query()] = "trial") -> Standing:
    """Whether a screen can be shown, and why not; what is opened for it is kept for what is asked next."""
    desk = desk_of(request)
    runs = desk.place(trial).trial is not None
    try:
        _open(request, desk, trial, screen)
    except NoReport as error:
        return Standing(ready=False, words=str(error), runs=runs)
    except NotThere:
        raise
    except KinemarkError as error:
        return Standing(ready=False, words=str(error), runs=runs)
    return Standing(ready=True, runs=runs)


def _open(request: Request, desk: Desk, trial: str, screen: Screen) -> None:
    if screen == "trial":
        desk.document(trial)
    elif screen == "report":
        report_of(desk, trial)
    elif screen == "detect":
        opened_of(request, place_of(request, trial))
    else:
        digitising_of(request, place_of(request, trial))
