"""The JSON schema of quality.json, made from the declarations of its keys and of the kinds of findings.

The package ships it as `quality.schema.json`; `python -m kinemark.findings.schema` writes it anew.
"""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path
from typing import Any

from ..data import KINDS, FindingKind
from ..data.finding import Unit
from .plain import SCHEMA_VERSION

FILE = "quality.schema.json"


def quality_schema() -> dict[str, Any]:
    """The schema as the package ships it."""
    return dict(json.loads(files(__package__).joinpath(FILE).read_text(encoding="utf-8")))


def declared_schema() -> dict[str, Any]:
    """The schema as the declarations have it; each finding has the values of its kind, and no others."""
    from pydantic import TypeAdapter  # takes half a second, and only this needs it

    from .quality_document import Quality

    schema = _untitled(TypeAdapter(Quality).json_schema())
    definitions = {**schema.pop("$defs"), **{f"kind_{kind.name}": _of_kind(kind) for kind in KINDS.values()}}
    found = definitions["FindingData"]
    found["properties"]["kind"] |= {"enum": list(KINDS)}
    found["allOf"] = [{"$ref": f"#/$defs/kind_{name}"} for name in KINDS]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": f"kinemark:quality:{SCHEMA_VERSION}",
        **schema,
        "$defs": definitions,
    }


def _untitled(schema: Any) -> Any:
    """The same without titles, which say what the keys say already."""
    if isinstance(schema, list):
        return [_untitled(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    return {key: _untitled(value) for key, value in schema.items() if not (key == "title" and isinstance(value, str))}


def _of_kind(kind: FindingKind) -> dict[str, Any]:
    """If a finding is of this kind, it has this stage and these values."""
    values = {name: _value(name, unit) for name, unit in kind.values.items()}
    then = {
        "stage": {"const": kind.stage},
        "values": {"properties": values, "required": list(values), "additionalProperties": False},
    }
    return {
        "description": kind.about,
        "if": {"properties": {"kind": {"const": kind.name}}},
        "then": {"properties": then},
    }


def _value(name: str, unit: Unit) -> dict[str, Any]:
    types = {"text": ["string", "null"], "flag": ["boolean"], "count": ["integer", "null"]}
    one = {"type": types.get(unit, ["number", "null"]), "description": unit}
    return {"type": "array", "items": one} if name.endswith("_list") else one


def schema_text() -> str:
    """The schema as the file has it, a definition a line."""
    schema = declared_schema()
    rows = [f"  {json.dumps(name)}: {_compact(one)}" for name, one in schema.pop("$defs").items()]
    head = [f" {json.dumps(key)}: {_compact(value)}" for key, value in schema.items()]
    return "{\n" + ",\n".join([*head, ' "$defs": {\n' + ",\n".join(rows) + "\n }"]) + "\n}\n"


def _compact(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


if __name__ == "__main__":
    Path(__file__).with_name(FILE).write_text(schema_text(), encoding="utf-8")
