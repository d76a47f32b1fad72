"""The JSON schema of `session.toml`, for editors that complete and check it, and for forms.

The tables are those of `Settings`; the methods are added as they are declared. What a schema cannot say, as that an
L-frame goes only with some ways of calibrating, is checked when the file is read.
"""

from __future__ import annotations

import math
from typing import Any, get_args, get_origin

from ...data.method import Declaration, Parameter, Stage
from ...data.parameter import ONE
from .method_tables import COMMON, SETTABLE, methods_of_way
from .session_file import Settings

DIALECT = "https://json-schema.org/draft/2020-12/schema"

TYPES = {bool: "boolean", int: "integer", float: "number", str: "string"}


def session_schema() -> dict[str, Any]:
    """The schema of a session file, as a value of JSON."""
    schema = Settings.model_json_schema()
    for name, stage in SETTABLE.items():
        schema["properties"][name] = stage_schema(stage)
    title = {"$schema": DIALECT, "title": "session.toml", "description": "A recording session of Kinemark."}
    return schema | title


def stage_schema(stage: Stage) -> dict[str, Any]:
    """The table of a stage: one of its methods with its parameters."""
    found = [_method_schema(stage, declared) for declared in stage.values()]
    return {"description": stage.meaning, "anyOf": found}


def _method_schema(stage: Stage, declared: Declaration) -> dict[str, Any]:
    parameters = (*COMMON.get(stage.name, ()), *declared.stateable)
    named = {"const": declared.name, "description": declared.summary}
    required = [p.name for p in parameters if p.required]
    if not _default(stage, declared):
        required.insert(0, "method")
    return {
        "type": "object",
        "title": declared.name,
        "description": declared.summary,
        "properties": {"method": named} | {p.name: parameter_schema(p) for p in parameters},
        "required": required,
        "additionalProperties": False,
    }


def _default(stage: Stage, declared: Declaration) -> bool:
    """Whether a table without a name may mean this method; of calibrating, which one it is follows from the way."""
    if declared.ways:
        return any(methods_of_way(way)[0] == declared.name for way in declared.ways)
    return declared.name == stage.default


def parameter_schema(p: Parameter) -> dict[str, Any]:
    """One parameter with its range, default and meaning."""
    schema = _schema(p.inner, p)
    if p.default is not None:
        schema["default"] = p.default
    if p.unit not in ("", ONE):
        schema["x-unit"] = p.unit
    return schema | {"description": p.meaning}


def _schema(kind: Any, p: Parameter) -> dict[str, Any]:
    if p.choices:
        return {"enum": list(p.choices)}
    if get_origin(kind) is tuple:
        parts = get_args(kind)
        count = {} if parts[-1] is Ellipsis else {"minItems": len(parts), "maxItems": len(parts)}
        return {"type": "array", "items": _schema(parts[0], p)} | count
    schema: dict[str, Any] = {"type": TYPES[kind]} if kind in TYPES else {}
    return schema | (_bounds(p) if kind in (int, float) else {})


def _bounds(p: Parameter) -> dict[str, float]:
    words = {"low": "minimum", "high": "maximum", "above": "exclusiveMinimum", "below": "exclusiveMaximum"}
    given = {words[key]: value for key, value in p.range._asdict().items() if value is not None}
    return {word: value for word, value in given.items() if math.isfinite(value)}
