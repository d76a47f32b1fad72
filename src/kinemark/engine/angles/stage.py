"""The stage `angles` of a trial's graph: joint angles by `[angles]`, in a folder beside the trial's other results."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...data import Finding, KinemarkError, Trial, make_finding
from ...io.files import write_text
from ...kinematics import static_template
from ..identities import identity_of_entry
from ..keys import file_key
from ..naming import Earlier
from ..naming.label_stage import static_of
from ..sources import Recording
from .of_trial import sided_model, trial_angles, write_trial_angles

FOLDER = "angles"
ANGLE_FILES = (f"{FOLDER}/angles.json",)
"""What the stage leaves for the next; the page, CSV and C3D lie beside it."""
REASON = "not_computed"
"""Key of the reason, where a trial has no angles."""


def model_key(of: Recording) -> str:
    """Of the model's file, where the session has one of its own."""
    table = of.settings.angles
    return "" if table is None else file_key(of.root / table.model)


def compute_angles(
    trial: Trial, of: Recording, folder: Path, earlier: Sequence[Earlier], assets: Path | None
) -> dict[str, Any]:
    """The figures of the angles, which are written as `kinemark angles` writes them; the reason where there are none.

    A trial of which the model wants other markers keeps nobody from its trajectories.

    Args:
        trial: with names and without gaps. of: what is recorded. folder: of its results. earlier: the trials before.
        assets: folder of what pages share; None where each page is to hold it.
    """
    table = of.settings.angles
    assert table is not None  # else there is no such stage
    into = folder / FOLDER
    try:
        model = table.model if not (of.root / table.model).is_file() else str(of.root / table.model)
        chain, side = sided_model(model, table.side, trial.trajectories.names)
        static = static_of(earlier)
        still = static_template(static, chain) if static is not None and chain.clusters else None
        result = trial_angles(trial, model=chain, template=still, settings=table.settings(), side=side)
        about = trial.about
        result.figures["identity"] = identity_of_entry(of.root, of.settings, of.entry, about)
        return write_trial_angles(trial, result, into, self_contained=assets is None).figures
    except KinemarkError as error:
        for old in ("angles.html", "angles.csv", "cycles.csv", f"{trial.name}_angles.c3d"):
            (into / old).unlink(missing_ok=True)
        figures = {REASON: str(error)}
        write_text(into / "angles.json", json.dumps(figures, ensure_ascii=False) + "\n")
        return figures


def found_by_angles(figures: Mapping[str, Any]) -> Iterator[Finding]:
    """Why a trial has no angles."""
    if REASON in figures:
        yield make_finding("angles_not_computed", reason=figures[REASON])
