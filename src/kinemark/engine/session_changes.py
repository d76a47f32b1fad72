"""Changes of a `session.toml` by a program: its comments stay, and nothing is written that would not be understood."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from ..data import KinemarkError
from ..io.files import replacing
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
    try:
        document = tomlkit.parse(path.read_text("utf-8"))
    except (OSError, ValueError, TOMLKitError) as error:
        raise KinemarkError(f"{path} cannot be read: {error}. Correct it.") from error
    for key, value in changes.items():
        _put(document, key, value)
    with replacing(path) as beside:
        beside.write_text(tomlkit.dumps(document), "utf-8")
        try:
            read_settings(beside)
        except KinemarkError as error:
            raise KinemarkError(str(error).replace(str(beside), FILE)) from error


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
