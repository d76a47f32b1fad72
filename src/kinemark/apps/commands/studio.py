"""The studio: trials on a screen in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...data import KinemarkError
from ..output import errors

ABSENT = (
    "The studio needs FastAPI and uvicorn, and {name} is not there. Install them: in a copy of the project "
    'python3 dev.py studio, which also builds the page; else pip install "kinemark[studio]"'
)


def studio(
    *paths: Path,
    host: Annotated[
        str, Parameter(help="Address to listen on; another than 127.0.0.1 is seen by others.")
    ] = "127.0.0.1",
    port: Annotated[int, Parameter(help="Port to listen on; 0 takes a free one.")] = 0,
    browser: Annotated[bool, Parameter(help="Open the browser.")] = True,
) -> None:
    """Open trials on a screen in the browser: look, correct, name, fill, sign; Ctrl-C ends it, nothing is lost.

    Args:
        paths: folders of sessions, sessions, and files of trajectories; the current folder where none is given.
    """
    try:
        from ..studio.server import serve
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] == "kinemark":
            raise
        raise KinemarkError(ABSENT.format(name=error.name)) from error

    def say(text: str) -> None:
        errors().print(f"kinemark: {text}", markup=False, highlight=False, soft_wrap=True)

    serve(paths or (Path(),), host=host, port=port, browser=browser, say=say)
