"""`session.toml` as text that is changed in places: comments and order stay."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import tomlkit
from tomlkit import TOMLDocument
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import Table

from ..data import KinemarkError
from ..io.number_text import read_text


def parsed(file: Path) -> TOMLDocument:
    """The file.

    Raises:
        KinemarkError: it is no TOML.
    """
    try:
        return tomlkit.parse(read_text(file))
    except TOMLKitError as error:
        raise KinemarkError(f"{file} is not TOML: {error}. Correct that line.") from error


def table_in(parent: Any, name: str, *, within: bool = False) -> Any:
    """A table by its name, made where it is not there; `within`: only a heading for others."""
    if name not in parent:
        if not isinstance(parent, Table):  # at the end of the file, apart from what is before
            parent.add(tomlkit.nl())
        parent[name] = tomlkit.table(within)
    return parent[name]
