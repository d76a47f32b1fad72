"""Where cameras should stand: the command `kinemark plan` as a function.

FOLDER/plan.toml     the cameras, as a rig file
FOLDER/plan.json     every figure
FOLDER/plan.html     the same as a page
"""

from __future__ import annotations

import pathlib
from typing import Any, NamedTuple

import numpy as np

from ..data import KinemarkError
from ..data.progress import listening
from ..findings.plan_figures import plan_figures
from ..findings.quality import write_quality
from ..io.rig_toml import read_rig_toml, write_rig_toml
from ..planning import Planning, Room, Sensor, plan_cameras
from ..report.drawing_library import assets_for
from ..report.plan_page import write_plan_page
from ..report.words import with_words
from .plan_settings import PlanSettings
from .progress import Progress, Watch, silent


class PlanResult(NamedTuple):
    """Figures of a plan, and where its files are."""

    figures: dict[str, Any]
    folder: pathlib.Path


def camera_plan(
    folder: pathlib.Path | str,
    *,
    settings: PlanSettings = PlanSettings(),  # noqa: B008  frozen
    self_contained: bool = False,
    progress: Progress = silent,
) -> PlanResult:
    """Plan cameras and write rig file, figures and page.

    Args:
        folder: of the results; it is made, and a plan that it holds is written anew.
        settings: what is asked for.
        self_contained: the page holds the drawing library.
        progress: hears how many of the places where a camera may stand are judged.

    Raises:
        KinemarkError: a setting cannot be used, no camera has a place, or the folder holds the cameras that are given.
    """
    folder = pathlib.Path(folder)
    file = folder / "plan.toml"
    if settings.given is not None and settings.given.resolve() == file.resolve():
        raise KinemarkError(
            f"{file} holds the cameras that stand already and would be overwritten. Name another folder."
        )
    room, sensor, planning = _room(settings), _sensor(settings), _planning(settings)
    given = None if settings.given is None else read_rig_toml(settings.given)
    with listening(Watch(progress).of("plan")):
        plan = plan_cameras(room, sensor, planning, given=given)
    figures = with_words(plan_figures(plan))
    folder.mkdir(parents=True, exist_ok=True)
    write_rig_toml(file, plan.rig)
    write_quality(folder / "plan.json", figures)
    assets = None if self_contained else assets_for(folder)
    write_plan_page(folder / "plan.html", figures=figures, plan=plan, assets=assets)
    return PlanResult(figures, folder)


def _room(asked: PlanSettings) -> Room:
    """Where cameras may stand.

    Raises:
        KinemarkError: a limit cannot be used.
    """
    volume = np.reshape(asked.volume_mm, (2, 3))
    if asked.walls_mm is None:
        return Room(volume, asked.height_mm, asked.distance_mm)
    return Room(volume, asked.height_mm, asked.distance_mm, np.reshape(asked.walls_mm, (2, 2)))


def _sensor(asked: PlanSettings) -> Sensor:
    """Of the cameras to be placed.

    Raises:
        KinemarkError: the focal length is given in two ways, or half.
    """
    by_lens = asked.focal_mm is not None and asked.pitch_um is not None
    if (asked.focal_mm is None) != (asked.pitch_um is None) or (by_lens and asked.focal_px is not None):
        raise KinemarkError("Give the focal length either as focal_px, or as focal_mm together with pitch_um.")
    focal = 1300.0 if asked.focal_px is None else asked.focal_px
    if asked.focal_mm is not None and asked.pitch_um is not None:
        if not (asked.focal_mm > 0 and asked.pitch_um > 0):
            raise KinemarkError(
                f"focal_mm is {asked.focal_mm:g} and pitch_um {asked.pitch_um:g}, wanted more than 0 of each."
            )
        focal = 1000 * asked.focal_mm / asked.pitch_um
    return Sensor(focal, asked.size_px, asked.least_image_px)


def _planning(asked: PlanSettings) -> Planning:
    """How many cameras, for what.

    Raises:
        KinemarkError: a number cannot be used.
    """
    return Planning(asked.cameras, asked.marker_mm, asked.centroid_px, asked.subject_mm, asked.markers)
