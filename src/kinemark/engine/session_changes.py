"""Changes of a `session.toml` by a program: its comments stay, and nothing is written that would not be understood."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit import TOMLDocument
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import Table

from ..data import KinemarkError
from ..io.files import replacing
from ..io.number_text import read_text
from .session_name import FILE
from .settings import read_settings


def change_session(root: Path, changes: Mapping[tuple[str, ...], Any]) -> None:
    """Set keys of the session in a folder, each by the tables that lead to it; None takes one away.

    Args:
        root: the folder. changes: values by keys, as {("detect", "threshold"): 90}.

    Raises:
        KinemarkError: the file cannot be read or written, or would not be understood then: it is left as it was.
    """
    path = root / FILE
    document = parsed(path)
    for key, value in changes.items():
        _put(document, key, value)
    write_session(path, document)


def _put(table: Any, key: tuple[str, ...], value: Any) -> None:
    """One key, with the tables on the way that are not there yet."""
    *tables, name = key
    for one in tables:
        if one not in table:
            if value is None:
                return
            table[one] = tomlkit.table()
        table = table[one]
    if value is None:
        table.pop(name, None)
    else:
        table[name] = value


def parsed(file: Path) -> TOMLDocument:
    """The file.

    Raises:
        KinemarkError: it is no TOML.
    """
    try:
        return tomlkit.parse(read_text(file))
    except TOMLKitError as error:
        raise KinemarkError(f"{file} is no TOML: {error}. Correct that line.") from error


def write_session(file: Path, document: TOMLDocument) -> None:
    """Write the file whole or not at all.

    Raises:
        KinemarkError: it cannot be written, or would not be understood then: what was there stays.
    """
    with replacing(file) as beside:
        beside.write_bytes(_with_its_line_ends(tomlkit.dumps(document)).encode())
        try:
            read_settings(beside)
        except KinemarkError as error:
            raise KinemarkError(str(error).replace(str(beside), file.name)) from error


def _with_its_line_ends(text: str) -> str:
    """The text with the ends of lines that it had, in what is new as well."""
    return text.replace("\r\n", "\n").replace("\n", "\r\n") if "\r\n" in text else text


def table_in(parent: Any, name: str, *, within: bool = False) -> Any:
    """A table by its name, made where it is not there; `within`: only a heading for others."""
    if name not in parent:
        if not isinstance(parent, Table):  # at the end of the file, apart from what is before
            parent.add(tomlkit.nl())
        parent[name] = tomlkit.table(within)
    return parent[name]
