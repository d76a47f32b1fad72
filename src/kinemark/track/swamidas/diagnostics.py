"""What the tracking tells of an angle model that was given to it."""

from __future__ import annotations

from collections.abc import Iterator

from ...data import Finding
from ...data.finding_kinds import make_finding
from .predictions import ModelUse


def diagnose_model(use: ModelUse | None) -> Iterator[Finding]:
    """A model that corrected nothing, and why; nothing where it did, or where there was none."""
    if use is None or use.placed:
        return
    if not use.recognised:
        yield make_finding("angle_model_unused", why="unrecognised", missing=None)
    elif use.missing:
        yield make_finding("angle_model_unused", why="no_neighbour", missing=use.missing)
    else:
        yield make_finding("angle_model_unused", severity="info", why="not_needed", missing=0)
