"""Tables of all methods and their parameters, as they are declared beside their functions."""

from __future__ import annotations

from generated import write
from sphinx.application import Sphinx

from kinemark.engine.settings import methods_table_markdown


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the fragment before sources are read."""
    app.connect("builder-inited", lambda app: write(app, "methods.md", methods_table_markdown()))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
