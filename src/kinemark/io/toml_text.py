"""TOML as untrusted text."""

from __future__ import annotations

import tomllib
from typing import Any

from ..data import KinemarkError


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
