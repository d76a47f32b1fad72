"""The commands, from what each says of itself with `--help`."""

from __future__ import annotations

import re
from typing import Any

from generated import write
from sphinx.application import Sphinx

from kinemark.apps.cli import app as commands


def text(app: Any) -> str:
    """Markdown, a heading a command."""
    said = app.generate_docs(output_format="markdown", heading_level=1)
    first = re.search(r"^## (?!Table of Contents)", said, re.MULTILINE)
    said = said[first.start() :] if first else said
    # cyclopts takes the call of the builder, python -m sphinx, for that of the command
    return re.sub(r"(?m)^(kinemark .*?) -m sphinx\b", r"\1", said)


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the fragment before sources are read."""
    app.connect("builder-inited", lambda app: write(app, "commands.md", text(commands)))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
