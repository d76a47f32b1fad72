"""Methods and parameters given beside the file, as `track.method=kiss_tracking` or `track.search_radius=30`.

They are what the file would say: the same names, and values as TOML writes them (text may go without its quotes). A
method that is not the file's leaves the file's parameters of that stage aside, which are another method's.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from typing import Any

from ...data.nearest_word import are, guess
from .method_tables import SETTABLE


def overridden(table: dict[str, Any], overrides: Iterable[str]) -> dict[str, Any]:
    """The table of a file with the overrides in it.

    Raises:
        ValueError: one is not of the form stage.parameter=value, or its stage is not known.
    """
    given: dict[str, dict[str, Any]] = {}
    for text in overrides:
        name, equals, value = text.partition("=")
        stage, dot, key = name.strip().partition(".")
        if not (equals and dot and key and value.strip()):
            raise ValueError(f"{text!r} is not understood, wanted stage.parameter=value, as track.method=kiss_tracking")
        if stage not in SETTABLE:
            raise ValueError(
                f"{stage!r} of {text!r} is no stage{guess(stage, list(SETTABLE))}; there {are(list(SETTABLE))}"
            )
        _put(given.setdefault(stage, {}), key, _value(value.strip()))
    return table | {stage: _merged(stage, table.get(stage), new) for stage, new in given.items()}


def _put(table: dict[str, Any], key: str, value: Any) -> None:
    """A value by its key; `cameras.left.threshold` is one of the camera left."""
    if not key.startswith("cameras."):
        table[key] = value
        return
    camera, dot, name = key.removeprefix("cameras.").rpartition(".")
    if not (camera and dot and name):
        raise ValueError(f"{key!r} is not understood, wanted cameras.NAME.parameter, as cameras.left.threshold")
    table.setdefault("cameras", {}).setdefault(camera, {})[name] = value


def _with_cameras(old: dict[str, Any], new: dict[str, Any]) -> dict[str, Any]:
    """Both tables; what each says of single cameras is put together."""
    before, after = old.get("cameras"), new.get("cameras")
    if not (isinstance(before, dict) and isinstance(after, dict)):
        return old | new
    own = {name: (before.get(name) or {}) | after.get(name, {}) for name in before | after}
    return old | new | {"cameras": own}


def _merged(stage: str, old: Any, new: dict[str, Any]) -> dict[str, Any]:
    """The table of a stage with what is given, without parameters of another method."""
    old = old if isinstance(old, dict) else {}
    if stage == "calibrate" and "method" not in old:  # its default is not known here: it follows from [calibration]
        return old | new
    usual = old.get("method", SETTABLE[stage].default)
    return _with_cameras(old, new) if new.get("method", usual) == usual else new


def _value(text: str) -> Any:
    """A value as TOML has it, or else the text itself."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
