"""The baseline of the benchmarks as tables."""

from __future__ import annotations

import tomllib
from pathlib import Path

from generated import write
from sphinx.application import Sphinx

FILE = Path(__file__).resolve().parents[2] / "benchmarks" / "baseline.toml"


def text() -> str:
    """Markdown, a heading and a table a benchmark."""
    lines = []
    for name, metrics in tomllib.loads(FILE.read_text(encoding="utf-8")).items():
        lines += [f"## {name}", "", "| metric | value | unit | better | tolerance |", "| --- | --- | --- | --- | --- |"]
        for metric, fields in metrics.items():
            slack = f"{100 * fields['relative']:g} %" if fields["relative"] else f"{fields['absolute']:g}"
            lines.append(f"| {metric} | {fields['value']:.4g} | {fields['unit']} | {fields['better']} | {slack} |")
        lines.append("")
    return "\n".join(lines)


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the fragment before sources are read."""
    app.connect("builder-inited", lambda app: write(app, "benchmarks.md", text()))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
