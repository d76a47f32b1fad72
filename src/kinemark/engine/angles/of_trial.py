"""Joint angles of one trial, from its file to CSV, C3D and a page: what `kinemark angles` does."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from ...data import Angles, Finding, KinemarkError, Trajectories, Trial, make_finding
from ...data.array_types import Floats
from ...data.model_markers import model_names
from ...data.models import LABORATORY, JointMotion
from ...data.nearest_word import some_names
from ...findings.angles import angle_figures
from ...gait.lower_limb import absent_markers
from ...io.angles_csv import write_angles_csv, write_cycles_csv
from ...io.c3d import write_c3d
from ...io.files import write_json
from ...io.model_toml import load_model, models
from ...io.notes import FileNote, read_notes
from ...io.trial import read_trial
from ...kinematics import (
    SMOOTH,
    Cycles,
    Model,
    Template,
    cycles,
    joint_angles,
    smooth,
    spans_of,
    static_template,
    with_marker_sd,
)
from ...kinematics.chain import Points, chosen, complete, in_room, points_of
from ...report.angles_page import write_angles_page
from ...report.drawing_library import assets_for
from ...report.formatting import millimetres
from ...report.words import with_words
from ..identities import identity_of_file
from ..vertical import UNKNOWN, vertical
from .settings import AngleSettings


class TrialAngles(NamedTuple):
    """The angles of a trial, all that its page shows, and where the files are."""

    angles: Angles
    model: Model
    points: Points
    cycles: Cycles | None
    figures: dict[str, Any]
    folder: Path | None = None
    notes: tuple[FileNote, ...] = ()


def trial_angles(
    trial: Trial,
    *,
    model: Model,
    template: Template | None = None,
    settings: AngleSettings | None = None,
    side: Finding | None = None,
) -> TrialAngles:
    """The joint angles of a trial with what there is to say of them, `side` among it where that was told by markers.

    Raises:
        KinemarkError: the trial has no frames, markers of the model are not in it, its cycles are not, or the cut-off
            is not below half its rate.
    """
    settings = settings or AngleSettings()
    raw = trial.trajectories
    if not raw.n_frames:
        raise KinemarkError(f"The trial {trial.name!r} has no frames. Check the file.")
    used = chosen(raw, model, template)
    stated = with_marker_sd(used, settings.marker_sd_mm)
    smoothed = _smoothed(stated, settings)
    points = complete(points_of(smoothed), model, template)
    model = in_room(model, points, up=_up(trial))
    angles = joint_angles(smoothed, model=model, method=settings.method, template=template)
    spans = _spans(trial, settings)
    found = cycles(angles, spans=spans) if spans else None
    how = _words(model, used, stated, settings)
    figures = with_words(
        angle_figures(angles, model, name=trial.name, trajectories=smoothed, how=how, cycles=found, side=side)
    )
    return TrialAngles(angles, model, points, found, figures)


def _up(trial: Trial) -> Floats | None:
    """(3) the axis that goes up; None where neither the file nor the body shows it."""
    with suppress(KinemarkError):  # the pelvis lies
        axis, known = vertical(trial)
        return None if known == UNKNOWN else axis
    return None


def with_angles(trial: Trial, angles: Angles, model: Model) -> Trial:
    """The trial with the angles among its signals, those of the same names replaced, their axes named by the model.

    Raises:
        KinemarkError: the angles have another number of frames than the trial, or a marker has the name of a joint.
    """
    trajectories = trial.trajectories
    if angles.deg.shape[1] != trajectories.n_frames:
        raise KinemarkError(f"The angles have {angles.deg.shape[1]} frames and the trial {trajectories.n_frames}.")
    if taken := [name for name in angles.joints if name in trajectories.names]:
        raise KinemarkError(f"The trial has a marker called {', '.join(taken)}, as a joint is. Rename the joint.")
    axes = [[_axis(k, motion) for k, motion in enumerate(joint.motions)] for joint in model.joints]
    return replace(trial, signals=trial.signals.updated(angles.signals(axes)))


def _axis(k: int, motion: JointMotion | None) -> str:
    """What a joint does where its k-th angle is above zero; its number where the model gives it no name."""
    return f"angle {k + 1}" if motion is None else motion.positive


def write_trial_angles(trial: Trial, result: TrialAngles, folder: Path, *, self_contained: bool = False) -> TrialAngles:
    """Write angles.csv, angles.html, angles.json, the trial with its angles as C3D, and cycles.csv if there are some.

    The page shares the drawing library of the results that it lies in, or of its own folder, unless it is to be
    self-contained.

    Raises:
        KinemarkError: the folder cannot be written, or a marker is called as a joint is.
    """
    angles, model, first = result.angles, result.model, trial.trajectories.first_frame
    write_angles_csv(folder / "angles.csv", angles, model, first_frame=first)
    notes = (
        *read_notes(trial.notes),
        *write_c3d(folder / f"{trial.name}_angles.c3d", with_angles(trial, angles, model)),
    )
    if result.cycles is not None:
        write_cycles_csv(folder / "cycles.csv", result.cycles, model)
    write_json(folder / "angles.json", result.figures)
    write_angles_page(
        folder / "angles.html",
        figures=result.figures,
        angles=angles,
        model=model,
        points=result.points,
        cycles=result.cycles,
        assets=None if self_contained else assets_for(folder),
    )
    return result._replace(folder=folder, notes=notes)


def angles_of_file(
    path: Path,
    *,
    model: str,
    folder: Path | None = None,
    static: Path | None = None,
    functional: Path | None = None,
    settings: AngleSettings | None = None,
    self_contained: bool = False,
) -> TrialAngles:
    """Read a trial, take its joint angles, and write them.

    Args:
        path: of the trial.
        model: name of a model, or path of its TOML file.
        folder: of the results; beside the trial, its name and `_angles`, where none is given.
        static: trial that shows the points which clusters carry; functional: motion that shows joint centres.
        settings: all else.
        self_contained: the page holds the drawing library.

    Raises:
        KinemarkError: as `trial_angles` and `write_trial_angles`, or a file cannot be read.
    """
    settings = settings or AngleSettings()
    trial, still = _read(path, settings), None
    shown = trial.trajectories if static is None else _read(static, settings).trajectories
    chain, side = sided_model(model, settings.side, shown.names)
    if functional is not None and static is None:
        raise KinemarkError("A functional trial needs the static one as well. Give --static.")
    if static is not None:
        moving = None if functional is None else _read(functional, settings).trajectories
        still = static_template(shown, chain, functional=moving)
    result = trial_angles(trial, model=chain, template=still, settings=settings, side=side)
    result.figures["identity"] = identity_of_file(trial, path)
    return write_trial_angles(trial, result, folder or folder_beside(path), self_contained=self_contained)


def folder_beside(path: Path) -> Path:
    """Of a trial's results, where none is given."""
    return path.with_name(f"{path.stem}_angles")


def _read(file: Path, settings: AngleSettings) -> Trial:
    return read_trial(file, rate_hz=settings.rate_hz, length_unit=settings.length_unit, partial=settings.partial)


def model_of_file(path: Path, *, static: Path | None = None, settings: AngleSettings | None = None) -> str | None:
    """Name of the model all of whose markers a trial shows, or its static trial does; of several the one with most.

    None where they are those of the gait model, which takes the angles of lower limbs.

    Raises:
        KinemarkError: the file cannot be read, or shows the markers of none, or those of the gait model, of which such
            settings are none.
    """
    settings = settings or AngleSettings()
    names = _read(static or path, settings).trajectories.names
    fitting = [chain for one in models() if fits(chain := sided_model(one, None, names)[0], names)]
    if fitting:
        return max(fitting, key=lambda chain: len(chain.markers)).name
    if absent := absent_markers(model_names(names)):
        raise KinemarkError(
            f"{path} has all markers of none of the models {', '.join(models())}, nor of the gait model, which wants "
            f"{some_names(absent)}. Give --model: one of these, or a TOML file with their names here."
        )
    if settings != AngleSettings():
        raise KinemarkError("These are the gait model's markers, whose angles have other options: kinemark gait.")
    return None


def sided_model(
    model: str, side: Literal["right", "left"] | None, names: Sequence[str]
) -> tuple[Model, Finding | None]:
    """A model of the stated side; else of its own, or of the other where only that one's markers are there.

    Raises:
        KinemarkError: there is no such model.
    """
    own = load_model(model, side=side)
    if side is not None or fits(own, names):
        return own, None
    other = load_model(model, side="left" if own.side == "right" else "right")
    if not fits(other, names):
        return own, None
    return other, make_finding("side_of_markers", side=other.side, usual=own.side)


def fits(model: Model, names: Sequence[str]) -> bool:
    """Whether markers of these names are all that a model wants, or are aliases of them."""
    return not missing(model, names)


def missing(model: Model, names: Sequence[str]) -> tuple[str, ...]:
    """The markers that a model wants and that are not among these names, by its own or by an alias."""
    bare = {name.rsplit(":", 1)[-1] for name in names}
    return tuple(marker for marker in model.markers if not bare & {marker, *model.aliases.get(marker, ())})


def _smoothed(raw: Trajectories, settings: AngleSettings) -> Trajectories:
    if settings.smoothing == "none":
        return raw
    try:
        return smooth(raw, method=SMOOTH.make(settings.smoothing, cutoff_hz=settings.cutoff_hz))
    except ValueError as error:
        raise KinemarkError(f"The markers cannot be smoothed: {error}. Change --cutoff-hz.") from None


def _spans(trial: Trial, settings: AngleSettings) -> list[tuple[float, float]]:
    """Beginning and end of each cycle, s from the first frame; the trial's clock starts at frame 1."""
    start = (trial.trajectories.first_frame - 1) / trial.trajectories.rate
    if settings.cycle_event is not None:
        return spans_of(trial.events, label=settings.cycle_event, side=settings.cycle_side, start_s=start)
    return [_span(text, start) for text in settings.cycle]


def _span(text: str, start: float) -> tuple[float, float]:
    first, dash, last = text.partition("-")
    try:
        span = float(first) - start, float(last) - start
    except ValueError:
        span = (0.0, 0.0)
    if not dash or not span[0] < span[1]:
        raise KinemarkError(f"The cycle {text!r} is no span of time. Say it in s as 0.5-2.75.")
    return span


def _room(model: Model) -> str:
    """Which axes forward and up are, where a joint is measured against them; nothing else."""
    if not any(joint.parent == LABORATORY for joint in model.joints):
        return ""
    return f"{model.forward} is forward and {model.up} is up."


def _words(model: Model, before: Trajectories, stated: Trajectories, settings: AngleSettings) -> dict[str, Any]:
    """What was done, in words and numbers for the page and the machine."""
    sd = np.array([np.sqrt(np.trace(path.cov, axis1=1, axis2=2) / 3) for path in stated])
    seen = sd[np.isfinite(sd)]
    median = float(np.median(seen)) if seen.size else None
    unknown = np.array([np.isnan(path.cov).any((1, 2)) & np.isfinite(path.xyz).all(1) for path in before]).any()
    origin = "stated" if not unknown else "estimated" if settings.marker_sd_mm is None else "assumed"
    origins = {
        "stated": "As the covariance of each marker in the file states.",
        "assumed": f"Assumed for all markers without one: {settings.marker_sd_mm} mm along each axis.",
        "estimated": "Estimated from the unsteadiness of each marker from frame to frame (twelfth differences); slow "
        "errors and what a filter took away are not in it.",
    }
    turns = {
        False: "With their sign; whole and half turns follow the frame before.",
        True: "By inverse cosines, as UM²AS (A.29 to A.36): the first and third angle have no sign.",
    }
    cutoff = "chosen from the data" if settings.cutoff_hz is None else f"{settings.cutoff_hz:g} Hz"
    return {
        "method": turns[settings.inverse_cosines],
        "noise": origins[origin] + ("" if median is None else f" The median is {millimetres(median)}."),
        "laboratory": _room(model),
        "smoothing": "None." if settings.smoothing == "none" else f"{settings.smoothing.title()}, cut-off {cutoff}.",
        "noise_from": origin,
        "marker_sd_mm": median,
        "lock_deg": settings.lock_deg,
    }
