"""Writes the contract of the studio's page: `python -m kinemark.apps.studio.schema` → `ui/openapi.json`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from fastapi.openapi.utils import get_openapi
from pydantic.json_schema import models_json_schema

from . import (
    angle_messages,
    camera_messages,
    detect_messages,
    edit_messages,
    messages,
    new_session_messages,
    um2as_messages,
)
from .app import studio_app
from .desk import Desk
from .shelf import Shelf

FILE = Path(__file__).parents[4] / "ui" / "openapi.json"
REF = "#/components/schemas/{model}"
MODULES = (
    messages,
    edit_messages,
    new_session_messages,
    camera_messages,
    detect_messages,
    angle_messages,
    um2as_messages,
)
RECORDS = [
    one for module in MODULES for one in vars(module).values()
    if isinstance(one, type) and issubclass(one, messages.Message)
]  # fmt: skip
"""All of the contract: some travel in headers or over the socket, where OpenAPI has no place for them."""


def schema() -> dict[str, Any]:
    """The OpenAPI document of the app, with all records of the contract."""
    app = studio_app(Desk(Shelf((Path(),)), ""))
    found = get_openapi(title=app.title, version="1", routes=app.routes, separate_input_output_schemas=False)
    _, every = models_json_schema([(one, "validation") for one in RECORDS], ref_template=REF)
    found["components"]["schemas"] = every["$defs"] | found["components"]["schemas"]
    return found


def text() -> str:
    """As it stands in the file."""
    return json.dumps(schema(), indent=1, ensure_ascii=False, sort_keys=True) + "\n"


if __name__ == "__main__":
    FILE.write_text(text(), "utf-8")
