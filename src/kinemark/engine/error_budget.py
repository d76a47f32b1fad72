"""What limits the accuracy of a session's trial: the command `kinemark sensitivity` as a function.

results/trial/sensitivity.json     every figure
results/trial/sensitivity.html     the same as a page
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from ..data import KinemarkError, Trajectories
from ..data.edits import is_named
from ..findings.quality import write_quality
from ..findings.sensitivity_figures import sensitivity_figures
from ..io.model_toml import load_model
from ..io.trial import read_trial
from ..report.sensitivity_page import write_sensitivity_page
from ..report.words import with_words
from ..sensitivity import ErrorBudget, SampledFrames, gather, gather_named, rank
from ..sensitivity.joints import kinematics_of
from .open_trial import OpenTrial
from .progress import Progress, silent
from .session import Session, update_index


class ErrorBudgetResult(NamedTuple):
    """Figures of what limits a trial, and where the page is."""

    figures: dict[str, Any]
    page: Path


def error_budget(
    session: Path | str,
    *,
    trial: str | None = None,
    method: ErrorBudget = ErrorBudget(),  # noqa: B008  frozen
    model: str | None = None,
    markers: Path | None = None,
    rate_hz: float | None = None,
    length_unit: str | None = None,
    partial: bool = False,
    self_contained: bool = False,
    progress: Progress = silent,
) -> ErrorBudgetResult:
    """What limits the accuracy of a trial, ranked; runs the session as far as it was not run before.

    Args:
        session: a folder with a session.toml, or such a file.
        trial: its name; the first where None.
        method: what is asked.
        model: of `kinemark.io.model_toml`, its name or file, for joint angles; directions of segments without.
        markers: a file of the same recording whose markers have names, as a model wants them; any of trajectories. The
            names that the trial itself has where None.
        rate_hz, length_unit: of that file, where it is silent or wrong. partial: read what there is of it.
        self_contained: the page holds the drawing library, as where the session's file says so.
        progress: called with each step.

    Raises:
        KinemarkError: the session, trial, model or markers cannot be used.
    """
    opened = Session.open(session)
    name = trial or opened.settings.trials[0].name
    results = opened.run([name], progress=progress)[name]
    named = _names_of(results) if markers is None else _named(markers, rate_hz, length_unit, partial)
    there = _there(results, named, method.frames)
    angles = kinematics_of(load_model(model), there.names) if model else None
    rig = results.rig.select(results.detections.cameras)
    ranking = rank(rig, there, method=method, angles=angles)
    figures = with_words(sensitivity_figures(ranking, session=opened.settings.name, trial=name))
    figures["identity"] = results.quality["identity"]
    write_quality(results.folder / "sensitivity.json", figures)
    page, assets = results.folder / "sensitivity.html", None if self_contained else opened.assets
    write_sensitivity_page(page, figures=figures, ranking=ranking, rig=rig, assets=assets)
    update_index(opened.results, opened.settings)
    return ErrorBudgetResult(figures, page)


def _names_of(results: OpenTrial) -> Trajectories | None:
    """The trial's own markers, where at least one has a name."""
    found = results.trajectories
    return found if any(map(is_named, found.names)) else None


def _there(results: OpenTrial, named: Trajectories | None, frames: int) -> SampledFrames:
    """Markers and their images."""
    if named is None:
        return gather(results.tracks, results.detections_in_time, frames=frames)
    return gather_named(named, results.tracks, results.detections_in_time, frames=frames)


def _named(path: Path, rate_hz: float | None, length_unit: str | None, partial: bool) -> Trajectories:
    """The markers of a file."""
    found = read_trial(path, rate_hz=rate_hz, length_unit=length_unit, partial=partial).trajectories
    if not len(found):
        raise KinemarkError(f"{path} has no named markers. Name a file of the same recording that has.")
    return found
