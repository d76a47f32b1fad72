"""The gait report of a session: whether there is one, or may be; made, and shown."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from ...data import KinemarkError
from ...data.model_markers import model_names
from ...engine.gait.of_session import gait_headline, gait_page, update_gait
from ...engine.session import Session
from ...engine.session_changes import change_session
from ...io.files import read_json
from ...report.drawing_library import ASSETS, self_contained
from .shelf import NotThere

MARKERS = frozenset({"LASI", "RASI", "LKNE", "RKNE", "LANK", "RANK", "LTOE", "RTOE"})
"""Markers by which a trial is one of the gait model; conventional: in all its variants the walks wear these."""
QUALITY = "quality.json"


def state(session: Session) -> Literal["", "possible", "there"]:
    """Whether there is a report, or a trial of motion was run that has the model's markers."""
    if session.settings.gait is not None:
        return "there" if gait_page(session.results) is not None else "possible"
    motion = [trial.name for trial in session.settings.trials if trial.kind == "motion"]
    return "possible" if any(_has_markers(session.results / name / QUALITY) for name in motion) else ""


def make(folder: Path) -> str:
    """Make it, by `[gait]` of session.toml, which is written where it is not there; one sentence of what it says.

    Raises:
        KinemarkError: it cannot be made; why.
    """
    if Session.open(folder).settings.gait is None:
        change_session(folder, {("gait", "method"): "physical"})
    session = Session.open(folder)
    figures = update_gait(session.root, session.results, session.settings, self_contained=session.assets is None)
    if figures is None:
        raise KinemarkError("None of the session's walks was run yet. Run them first.")
    if gait_page(session.results) is None:
        raise KinemarkError(gait_headline(figures))
    return gait_headline(figures)


def page(folder: Path) -> str:
    """The page of the report, with all that it draws with."""
    results = Session.open(folder).results
    file = gait_page(results)
    if file is None:
        raise NotThere("There is no gait report yet: make it on Home.")
    return self_contained(file, results / ASSETS)


def _has_markers(quality: Path) -> bool:
    figures = read_json(quality)
    if "trajectories" not in figures:
        return False
    return model_names([one["name"] for one in figures["trajectories"]["markers"]]).keys() >= MARKERS
