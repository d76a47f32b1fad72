"""The commands, from what each says of itself with `--help`."""

from __future__ import annotations

import importlib
import re
import tomllib
from pathlib import Path
from typing import Any

from generated import write
from sphinx.application import Sphinx

PROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"


def command() -> Any:
    """The app that the script `kinemark` of pyproject.toml runs."""
    module, _ = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]["scripts"]["kinemark"].split(":")
    return importlib.import_module(module).app


def text(app: Any) -> str:
    """Markdown, a heading a command."""
    said = app.generate_docs(output_format="markdown", heading_level=1)
    first = re.search(r"^## (?!Table of Contents)", said, re.MULTILINE)
    return said[first.start() :] if first else said


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the fragment before sources are read."""
    app.connect("builder-inited", lambda app: write(app, "commands.md", text(command())))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
