"""The page itself: what was built lies in the folder `page`."""

from __future__ import annotations

from pathlib import Path

from fastapi import APIRouter
from fastapi.responses import FileResponse, PlainTextResponse, Response

from .shelf import NotThere

PAGE = Path(__file__).parent / "page"
NOT_BUILT = "The page of the studio is not built in this checkout: run `python3 dev.py studio`, then load this again.\n"

router = APIRouter()


@router.get("/", include_in_schema=False)
def index() -> Response:
    """The page, or what to do to have it."""
    file = PAGE / "index.html"
    return FileResponse(file) if file.is_file() else PlainTextResponse(NOT_BUILT, 503)


@router.get("/assets/{name}", include_in_schema=False)
def asset(name: str) -> Response:
    """A part of the page, by its name: one of those that are there, never a path."""
    folder = PAGE / "assets"
    there = {path.name: path for path in folder.iterdir()} if folder.is_dir() else {}
    if name not in there or not there[name].is_file():
        raise NotThere(f"The page has no part {name!r}.")
    return FileResponse(there[name], headers={"Cache-Control": "private, max-age=31536000, immutable"})
