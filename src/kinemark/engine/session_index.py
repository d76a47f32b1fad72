"""The index of a session: `results/index.html`, from what the trials' folders hold."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ..report.index_page import IndexRow, index_row, write_index
from ..version import __version__
from .gait.of_session import gait_headline, gait_page, read_gait
from .settings import Settings

PAGE = "index.html"
FILES = {"report.html": "report", "gaps.html": "gaps", "sensitivity.html": "sensitivity", "quality.json": "figures"}
"""In a trial's folder, with their titles for the reader."""


def update_index(results: Path, settings: Settings) -> Path:
    """Write the index of a session by what is in its results now.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    rows = [_row(results, trial.name) for trial in settings.trials]
    calibration = _figures(results / "calibration.json")
    gait = read_gait(results) if settings.gait is not None else None
    write_index(
        results / PAGE, session=settings.name, calibration=calibration, rows=rows, version=__version__,
        gait=None if gait is None else (gait_headline(gait), gait_page(results) is not None),
    )  # fmt: skip
    return results / PAGE


def _row(results: Path, name: str) -> IndexRow:
    folder = results / name
    there = [(f"{name}/{file}", title) for file, title in FILES.items() if (folder / file).is_file()]
    c3d = [(f"{name}/{name}.c3d", "C3D")] if (folder / f"{name}.c3d").is_file() else []
    angles = [(page.relative_to(results).as_posix(), "angles") for page in sorted(folder.glob("*/angles.html"))]
    return index_row(name, _figures(folder / "quality.json"), [*there, *angles, *c3d])


def _figures(path: Path) -> dict[str, Any] | None:
    """What a file of figures holds; None where it is absent or of another version."""
    try:
        found = json.loads(path.read_text("utf-8"))
        return found if "verdict" in found else None
    except (OSError, ValueError):
        return None
