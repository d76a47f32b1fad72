"""TOML as untrusted text: its table, and values of the wanted kinds in it."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from importlib.resources.abc import Traversable
from typing import Any

from ..data import KinemarkError
from ..data.nearest_word import guess

MOST = 2000
"""Most entries of a list in a file; chosen, lest a broken file take memory."""


def toml_table(text: str, what: str, *, advice: str = "Correct that line.") -> dict[str, Any]:
    """The table that a text holds.

    Args:
        text: of the file.
        what: the file, or what it describes, as an error begins with it.
        advice: what to do where it is no TOML.

    Raises:
        KinemarkError: it is no TOML, or nested deeper than Python goes.
    """
    try:
        return tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise KinemarkError(f"{what} is no TOML: {error}. {advice}") from None


def names_in(folder: Traversable) -> tuple[str, ...]:
    """Names of the TOML files in a folder, without their ending, sorted."""
    return tuple(sorted(p.name.removesuffix(".toml") for p in folder.iterdir() if p.name.endswith(".toml")))


def check_keys(where: str, table: Iterable[str], known: Iterable[str]) -> None:
    """Refuse keys that a table does not have, lest a mistyped one be passed over.

    Args:
        where: the table, as an error begins with it.
        table: its keys.
        known: those that it may have.

    Raises:
        ValueError: there is another one.
    """
    there = list(known)
    for key in table:
        if key not in there:
            raise ValueError(f"{where} has the unknown key {key!r}{guess(key, there)}; known are {', '.join(there)}")


def list_of(key: str, value: Any) -> list[Any]:
    """A value that must be a list of at most `MOST`; key: what an error calls it.

    Raises:
        ValueError: it is none, or longer.
    """
    if not isinstance(value, list) or len(value) > MOST:
        raise ValueError(f"{key} must be a list of at most {MOST}, found {str(value)[:60]}")
    return value


def text_of(key: str, value: Any) -> str:
    """A value that must be text.

    Raises:
        ValueError: it is none.
    """
    if not isinstance(value, str):
        raise ValueError(f"{key} is {value!r}, wanted text")
    return value


def texts_of(key: str, value: Any) -> tuple[str, ...]:
    """A value that must be a list of texts.

    Raises:
        ValueError: it is none, or longer than `MOST`.
    """
    return tuple(text_of(f"an entry of {key}", item) for item in list_of(key, value))
