"""The kinds of findings, from their declarations and words."""

from __future__ import annotations

from generated import write
from kinemark.data import KINDS
from sphinx.application import Sphinx

PARTS = {
    "record": "The recording",
    "calibrate": "Calibration",
    "detect": "Detection",
    "match": "Matching",
    "reconstruct": "Reconstruction",
    "track": "Tracking",
    "fill": "Filling",
    "kinematics": "Joint angles",
    "sensitivity": "Error budget",
    "plan": "Plan of cameras",
}
"""Heading of each stage."""


def text() -> str:
    """Markdown, a heading a stage, a row a kind."""
    lines = []
    for stage, heading in PARTS.items():
        lines += [
            f"### {heading}: `{stage}`",
            "",
            "| kind | severity | meaning | values |",
            "| --- | --- | --- | --- |",
        ]
        for kind in KINDS.values():
            if kind.stage == stage:
                values = ", ".join(f"`{name}` ({unit})" for name, unit in kind.values.items())
                lines.append(f"| `{kind.name}` | {kind.severity} | {kind.about} | {values} |")
        lines.append("")
    return "\n".join(lines)


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the fragment before sources are read."""
    app.connect("builder-inited", lambda app: write(app, "findings.md", text()))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
