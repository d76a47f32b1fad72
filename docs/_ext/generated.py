"""Fragments of pages that are made from the code at every build, in `_generated/`."""

from __future__ import annotations

from pathlib import Path

from sphinx.application import Sphinx


def write(app: Sphinx, name: str, text: str) -> None:
    """A fragment, left alone where it is the same, so that its page is not built again."""
    path = Path(app.srcdir) / "_generated" / name
    path.parent.mkdir(exist_ok=True)
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")
