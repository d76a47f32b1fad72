"""Home: what may be opened."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Request

from .desk import Desk
from .home import home
from .messages import Home

router = APIRouter(prefix="/api")


def desk_of(request: Request) -> Desk:
    """The desk of the app."""
    desk = request.app.state.desk
    assert isinstance(desk, Desk)
    return desk


TheDesk = Annotated[Desk, Depends(desk_of)]


@router.get("/home")
def get_home(desk: TheDesk) -> Home:
    """Sessions with their trials, and files."""
    return home(desk.shelf, {})
