"""The app: its routes, and what becomes of errors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from ...data import KinemarkError
from ...engine.detection.open_detection import OpenDetection
from ...engine.digitising.open_digitising import OpenDigitising
from ...engine.editing.journal import StaleJournal
from ...version import __version__
from . import (
    angle_routes,
    camera_routes,
    detect_routes,
    digitise_routes,
    export_routes,
    home_routes,
    image_routes,
    live,
    page_routes,
    standing,
    trial_routes,
    um2as_routes,
)
from .desk import Desk, NotRun
from .digitise import AnsweredMeanwhile
from .guard import Limits
from .kept import Kept
from .messages import Refusal
from .shelf import NotThere

STATUS: dict[type[Exception], int] = {NotThere: 404, NotRun: 424, AnsweredMeanwhile: 409}
"""Of HTTP, for errors of the user's that are not 422; by definition."""
MOST_WORDS = 20
"""Mistakes of a message that are named; chosen."""


def studio_app(desk: Desk) -> FastAPI:
    """The app over a desk, without its guard."""
    app = FastAPI(
        title="Kinemark studio", version=__version__, docs_url=None, redoc_url=None, openapi_url=None,
        responses={422: {"model": Refusal}}, separate_input_output_schemas=False,
    )  # fmt: skip
    app.state.desk, app.state.live = desk, live.Live(desk)
    app.state.detecting, app.state.digitising = Kept[OpenDetection](), Kept[OpenDigitising]()
    for part in (
        home_routes, trial_routes, image_routes, detect_routes, digitise_routes, export_routes, live, page_routes,
        camera_routes, angle_routes, standing, um2as_routes,
    ):  # fmt: skip
        app.include_router(part.router)
    app.add_exception_handler(KinemarkError, _refused)
    app.add_exception_handler(RequestValidationError, _malformed)
    app.add_exception_handler(HTTPException, _other)
    app.add_middleware(Limits)
    return app


async def _refused(request: Request, error: Exception) -> JSONResponse:
    """An error of the user's, in words."""
    if isinstance(error, StaleJournal):
        key = request.path_params.get("trial", "")
        head = request.app.state.desk.document(key).head if key else None
        return _answer(409, str(error), head)
    return _answer(next((status for kind, status in STATUS.items() if isinstance(error, kind)), 422), str(error))


async def _malformed(request: Request, error: Exception) -> JSONResponse:
    """A message that is none of the contract."""
    mistakes: Sequence[Any] = error.errors() if isinstance(error, RequestValidationError) else ()
    said = [f"{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in mistakes[:MOST_WORDS]]
    return _answer(422, "; ".join(said) or "This is no message that the studio knows.")


async def _other(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    return _answer(error.status_code, str(error.detail))


def _answer(status: int, words: str, head: str | None = None) -> JSONResponse:
    return JSONResponse(Refusal(words=words, head=head).model_dump(), status)
