"""The JSON schema of `session.toml`, for editors that complete and check it, and for forms.

The tables are those of `Settings`; the methods are added as they are declared. What a schema cannot say, as that an
L-frame goes only with some ways of calibrating, is checked when the file is read.
"""

from __future__ import annotations

import math
from typing import Any, get_args, get_origin

from ...data.method import ONE, Declaration, Parameter, Stage, plain
from ...detect import DETECT
from ...label import LABEL
from .calibration_table import WAYS
from .method_tables import COMMON, SETTABLE, methods_of_way
from .session_file import Settings
from .tables import SubjectTable

DIALECT = "https://json-schema.org/draft/2020-12/schema"

TYPES = {bool: "boolean", int: "integer", float: "number", str: "string"}

OF_CAMERAS = "parameters of single cameras by their names, in place of those for all"

OF_SUBJECTS = "several subjects by their names, which stand before those of their markers, as in A:LKNE"

BOUNDS = {"low": "minimum", "high": "maximum", "above": "exclusiveMinimum", "below": "exclusiveMaximum"}


def session_schema() -> dict[str, Any]:
    """The schema of a session file, as a value of JSON."""
    schema = _without_null(Settings.model_json_schema())
    for stage in SETTABLE.values():
        methods = [_ref(stage, name) for name in stage]
        schema["properties"][stage.name] = {"description": stage.meaning, "anyOf": methods}
        schema["$defs"] |= {_key(stage, name): method_schema(stage, declared) for name, declared in stage.items()}
    title = {"$schema": DIALECT, "title": "session.toml", "description": "A recording session of Kinemark."}
    return title | schema | {"description": title["description"], "title": title["title"], "allOf": _of_ways()}


def method_schema(stage: Stage, declared: Declaration) -> dict[str, Any]:
    """The table of a stage that is done by a method."""
    parameters = (*COMMON.get(stage.name, ()), *declared.stateable)
    named = {"const": declared.name, "description": declared.summary}
    required = [] if _unnamed(stage, declared) else ["method"]
    own = {p.name: parameter_schema(p) for p in parameters}
    return {
        "type": "object",
        "title": declared.name,
        "description": declared.summary,
        "properties": {"method": named} | own | _tables_below(stage, own),
        "required": required + [p.name for p in parameters if p.required],
        "additionalProperties": False,
    }


def _tables_below(stage: Stage, own: dict[str, Any]) -> dict[str, Any]:
    """The tables of single cameras, `[detect.cameras.NAME]`, or of single subjects, `[label.subjects.NAME]`."""
    if stage is DETECT:
        camera = {"type": "object", "additionalProperties": False, "properties": own}
        return {"cameras": {"type": "object", "description": OF_CAMERAS, "additionalProperties": camera}}
    if stage is LABEL:
        subject = _without_null(SubjectTable.model_json_schema())
        return {"subjects": {"type": "object", "description": OF_SUBJECTS, "additionalProperties": subject}}
    return {}


def parameter_schema(p: Parameter) -> dict[str, Any]:
    """One parameter with its range, default and meaning."""
    schema = _schema(p.inner, p)
    if p.default is not None:
        schema["default"] = plain(p.default)
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
    bounds = p.range._asdict() if kind in (int, float) else {}
    finite = {BOUNDS[key]: value for key, value in bounds.items() if value is not None and math.isfinite(value)}
    return ({"type": TYPES[kind]} if kind in TYPES else {}) | finite


def _unnamed(stage: Stage, declared: Declaration) -> bool:
    """Whether a table without a name may mean this method; of calibrating, which one it is follows from the way."""
    if declared.ways:
        return any(methods_of_way(way)[0] == declared.name for way in declared.ways)
    return declared.name == stage.default


def _of_ways() -> list[dict[str, Any]]:
    """For each way of calibrating, the methods that `[calibrate]` may have."""
    stage = SETTABLE["calibrate"]
    return [
        {
            "if": {"properties": {"calibration": {"required": [way]}}},
            "then": {"properties": {"calibrate": {"anyOf": [_ref(stage, name) for name in methods_of_way(way)]}}},
        }
        for way in WAYS
        if methods_of_way(way)
    ]


def _key(stage: Stage, name: str) -> str:
    return f"{stage.name}.{name}"


def _ref(stage: Stage, name: str) -> dict[str, str]:
    return {"$ref": f"#/$defs/{_key(stage, name)}"}


def _without_null(schema: Any) -> Any:
    """A schema without null, which TOML does not have: what may be None may be left out."""
    if isinstance(schema, list):
        return [_without_null(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    rest = {key: _without_null(part) for key, part in schema.items() if not (key == "default" and part is None)}
    some = [part for part in rest.get("anyOf", []) if part != {"type": "null"}]
    if len(some) == len(rest.get("anyOf", [])):
        return rest
    del rest["anyOf"]
    return some[0] | rest if len(some) == 1 else rest | {"anyOf": some}
