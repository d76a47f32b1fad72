"""Reading the file, with methods and parameters given beside it, and with errors in its own words.

What is given beside the file, as `track.method=kiss_tracking` or `track.search_radius=30`, is what the file would say:
the same names, and values as TOML writes them (text may go without its quotes). A method that is not the file's leaves
the file's parameters of that stage aside, which are another method's.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from ...data import KinemarkError
from ...data.nearest_word import are, guess, some_names
from ...data.typed import typed
from ...io.toml_text import toml_table
from ..session_name import MARK
from .calibration_table import WAYS
from .method_tables import SETTABLE
from .session_file import Settings


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


ADVICE = "A session is a folder with a session.toml, saved as UTF-8; kinemark init FOLDER writes a first one."

MISSING = {
    "calibration": f"; say under [calibration] what the cameras are calibrated with, one of {', '.join(WAYS)}",
    "trials": '; each recording has a table [[trials]] with name = "…" and images, detections or answers',
    "name": '; call the session as you like, as name = "normal gait"',
}
"""What to write where a required key is missing."""

A_LIST, A_NUMBER, A_WHOLE_NUMBER = "wants a list in [ ]", "wants a number", "wants a whole number"
WANTED = {
    "tuple_type": A_LIST,
    "float_type": A_NUMBER,
    "float_parsing": A_NUMBER,
    "int_type": A_WHOLE_NUMBER,
    "int_parsing": A_WHOLE_NUMBER,
    "int_from_float": A_WHOLE_NUMBER,
    "bool_type": "wants true or false",
    "bool_parsing": "wants true or false",
    "string_type": 'wants a text, as "…"',
    "finite_number": "wants a finite number",
    "too_short": "wants at least one in it",
    "model_type": "wants a table",
    "dict_type": "wants a table",
}
"""What a value of the wrong kind should be, by pydantic's name of the error."""
KIND = re.compile(r"bool|(tuple|dict|literal)\[.*\]")
"""What pydantic puts into the place of a value that may be of several kinds."""


def _nearby(path: Path) -> str:
    """Which session may have been meant: the one that the folder belongs to, or those in its folders."""
    above = [*path.parent.parents, *path.parent.absolute().parents]
    owner = [folder for folder in above if (folder / path.name).is_file()][:1]
    found = [typed(folder) for folder in owner or sorted(file.parent for file in path.parent.glob(f"*/{path.name}"))]
    return f"Did you mean the session in {some_names(found)}? If not, make" if found else "Make"


def read_settings(path: Path, *, overrides: Sequence[str] = ()) -> Settings:
    """The settings of a session file.

    Args:
        path: the file.
        overrides: methods and parameters that go before those of the file, as "track.method=kiss_tracking".

    Raises:
        KinemarkError: it is absent, no TOML, or says something that is not understood; all such places are named.
    """
    try:
        if not path.exists() and (path.suffix != ".toml" or not path.parent.is_dir()):
            raise KinemarkError(
                f"{path} is not there. Look at its name and the folder that you are in, or make a session to look at: "
                f"kinemark simulate {typed(path)}"
            )
        if not path.is_file():
            raise KinemarkError(
                f"{path} is not there. {_nearby(path)} one from your recordings: kinemark init "
                f"{typed(path.parent)}, or one to look at: kinemark simulate FOLDER"
            )
        text = path.read_text("utf-8-sig")
        return Settings.model_validate(_with(toml_table(text, str(path)), overrides))
    except UnicodeDecodeError as error:
        raise KinemarkError(f"{path} is not UTF-8 text: {error.reason}. {ADVICE}") from error
    except OSError as error:
        raise KinemarkError(f"{path} cannot be read: {error}") from error
    except ValidationError as error:
        places = {row["loc"][0] for row in error.errors() if row["loc"]}
        follows = {"trials"} | ({"calibrate"} if "calibration" in places else set())  # from errors of other places
        rows = [row for row in error.errors() if {*row["loc"]} - follows or len(error.errors()) == 1]
        rows = [row for row in rows if row["type"] != "too_short" or row["input"] in ([], ())]  # an item is wrong: told
        lines = "\n".join(f"  {_said(row)}" for row in rows)
        beside = f" with {', '.join(overrides)}" if overrides else ""
        raise KinemarkError(
            f"{path}{beside} has settings that are not understood:\n{lines}\n"
            f"Correct these; kinemark schema has all keys.{_wanted(text)}"
        ) from error


def _wanted(text: str) -> str:
    """What a first session file has not been told yet, which may be all that is wrong with it."""
    lines = [line for line in text.splitlines() if line.startswith(f"# {MARK} ")]
    keys = some_names([line.split("=")[0][3:].strip() for line in lines])
    return f" The lines that begin with # {MARK} want a value, and are read without this mark: {keys}." if lines else ""


def _with(table: dict[str, Any], overrides: Sequence[str]) -> dict[str, Any]:
    """The file's table with the overrides in it."""
    try:
        return overridden(table, overrides)
    except ValueError as error:
        raise KinemarkError(f"--set {error}.") from error


def _said(row: Any) -> str:
    """One line of a pydantic error, in the words of the file."""
    where = _place(row["loc"])
    if row["type"] == "extra_forbidden":
        keys = _keys(row["loc"][:-1])
        return f"{where}: there is no such key{guess(str(row['loc'][-1]), keys)}; there {are(keys)}"
    if not where:
        return str(row["msg"].removeprefix("Value error, "))
    if row["type"] == "missing":
        return f"{where}: is missing{MISSING.get(where, '')}"
    if row["type"] == "tuple_type" and isinstance(row["input"], str):
        return f"{where}: wants a list: [{row['input']!r}]"
    if where == "trials" and isinstance(row["input"], dict):
        return "trials: wants a table for each recording: write [[trials]], with two brackets"
    wanted = WANTED.get(row["type"], row["msg"].removeprefix("Value error, ").replace("Input should", "should"))
    told = isinstance(row["input"], dict) or ", found " in wanted  # a table is in the file to be read
    found = "" if told else f", found {row['input']!r}"
    return f"{where}: {wanted}{found}"[:400]


def _place(keys: Sequence[str | int]) -> str:
    """Where a value stands, its place in a list counted from 1: `trials #1.name`."""
    told = [key for key in keys if isinstance(key, int) or not KIND.fullmatch(key)]
    return "".join(f" #{key + 1}" if isinstance(key, int) else f".{key}" for key in told).removeprefix(".")


def _keys(table: tuple[Any, ...]) -> list[str]:
    """The keys that a table of the file may have."""
    model: Any = Settings
    for part in table:
        if isinstance(part, str) and part in model.model_fields:
            model = _model_in(model.model_fields[part].annotation) or model
    hidden = "SkipJsonSchema"  # of keys that the file writes as tables within other tables
    fields = model.model_fields.items()
    return [key for key, field in fields if hidden not in [type(one).__name__ for one in field.metadata]]


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """The table that a type holds, as in `Table | None` and `tuple[Table, ...]`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next(filter(None, map(_model_in, get_args(annotation))), None)
