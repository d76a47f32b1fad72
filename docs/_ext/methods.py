"""Tables of all methods and their parameters, from `kinemark methods --json`."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

from generated import write
from sphinx.application import Sphinx

Said = dict[str, dict[str, dict[str, Any]]]
FACTS = ("default", "unit", "range", "meaning")


def said() -> Said:
    """stage → method → parameter → its default, or a table of `FACTS`."""
    ran = subprocess.run([sys.executable, "-m", "kinemark", "methods", "--json"], capture_output=True, check=True)
    return json.loads(ran.stdout)


def text(found: Said) -> str:
    """Markdown, a heading a stage, a table a method."""
    lines = []
    for stage, methods in found.items():
        lines += [f"## `[{stage}]`", ""]
        for name, parameters in methods.items():
            lines += [f"### `{name}`", "", *_table(parameters), ""]
    return "\n".join(lines)


def _table(parameters: dict[str, Any]) -> list[str]:
    """A row a parameter; the columns that any of them fills."""
    rows = {name: value if isinstance(value, dict) else {"default": value} for name, value in parameters.items()}
    facts = [fact for fact in FACTS if any(fact in row for row in rows.values())]
    if not rows:
        return ["No parameters."]
    head = [f"| parameter | {' | '.join(facts)} |", "| --- " * (1 + len(facts)) + "|"]
    return head + [f"| `{name}` | {' | '.join(_cell(f, row.get(f)) for f in facts)} |" for name, row in rows.items()]


def _cell(fact: str, value: Any) -> str:
    """Defaults as a session file has them; none where there is no value."""
    if value is None:
        return "none" if fact == "default" else ""
    if fact == "default":
        return f"`{json.dumps(value)}`"
    return str(value).replace("|", "\\|")


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the fragment before sources are read."""
    app.connect("builder-inited", lambda app: write(app, "methods.md", text(said())))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
