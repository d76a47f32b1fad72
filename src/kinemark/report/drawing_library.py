"""The drawing library, plotly.js: one file that the pages of a folder share, or inside a page for mailing."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from markupsafe import Markup
from plotly.offline import get_plotlyjs, get_plotlyjs_version

from ..io.files import replacing
from .templating import render, write_text

ASSETS = "assets"
"""Folder, in that of the results, of what pages share."""
FARTHEST = 3
"""Folders above a page in which a library that is already there is looked for; chosen."""


class DrawingLibrary(NamedTuple):
    """What a page draws with: the address of a file, or the library's text."""

    address: str = ""
    text: Markup = Markup()


def library_name() -> str:
    """Of the file; pages of an older version of the library keep their own."""
    return f"plotly-{get_plotlyjs_version()}.min.js"


def drawing_library(page: Path | str, assets: Path | None) -> DrawingLibrary:
    """What a page links to, written where it is not there yet; the library itself where `assets` is None.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    if assets is None:
        return inside()
    file = assets / library_name()
    _put(file)
    return _linked(Path(page), file)


def inside() -> DrawingLibrary:
    """The library itself, for a page that needs no other file."""
    return DrawingLibrary(text=Markup(get_plotlyjs()))


def relink(page: Path, assets: Path, *, self_contained: bool) -> None:
    """Make a page that was written before share the library, or hold it; one that does stays as it is.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    if not page.is_file():
        return
    way = drawing_library(page, assets) if not self_contained else _linked(page, assets / library_name())
    shared, text = render("library.html", library=way), page.read_text("utf-8")
    if (shared in text) != self_contained:
        return  # before the library, of some MB, is looked at
    whole = render("library.html", library=inside())
    again = text.replace(shared, whole) if self_contained else text.replace(whole, shared)
    if again != text:
        write_text(page, again)


def self_contained(page: Path, assets: Path) -> str:
    """The text of a page with the library in it, whether or not its file shares one.

    Raises:
        OSError: the page cannot be read.
    """
    shared, own = (render("library.html", library=way) for way in (_linked(page, assets / library_name()), inside()))
    return page.read_text("utf-8").replace(shared, own)


def _linked(page: Path, file: Path) -> DrawingLibrary:
    return DrawingLibrary(address=quote(Path(os.path.relpath(file, page.parent)).as_posix()))


def _put(file: Path) -> None:
    """Write the library, whole or not at all; a file that is whole stays."""
    if not file.is_file() or file.stat().st_size != _size():
        with replacing(file) as beside:
            beside.write_bytes(get_plotlyjs().encode())


@cache
def _size() -> int:
    """Of the library, bytes."""
    return len(get_plotlyjs().encode())


def assets_for(folder: Path) -> Path:
    """The assets of a folder of pages: those of a folder above that has the library, else its own."""
    above = [folder.absolute(), *folder.absolute().parents][: FARTHEST + 1]
    return next((near / ASSETS for near in above if (near / ASSETS / library_name()).is_file()), folder / ASSETS)
