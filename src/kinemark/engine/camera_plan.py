"""Where cameras should stand: the command `kinemark plan` as a function.

FOLDER/plan.toml     the cameras, as a rig file
FOLDER/plan.json     every figure
FOLDER/plan.html     the same as a page
"""

from __future__ import annotations

import pathlib
from dataclasses import dataclass
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
from .progress import Progress, Watch, silent

Box = tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class PlanSettings:
    """What a plan is asked for.

    Attributes:
        volume_mm: least and greatest corner of the control volume, x y z x y z; its bottom is the floor.
        cameras: how many there shall be, those given among them.
        given: rig file of cameras that stand already and stay where they are.
        height_mm: least and greatest height of a camera above the floor.
        distance_mm: least and greatest level distance of a camera from the volume's outline.
        walls_mm: least and greatest x and y of the room, x y x y.
        focal_mm: focal length of the lens; with pitch_um.
        pitch_um: width of a pixel of the sensor.
        focal_px: focal length in pixels, in place of these two; 1300 where none is given.
        size_px: width and height of the images.
        marker_mm: diameter of the markers.
        least_image_px: diameter of the smallest image of a marker that is detected.
        centroid_px: standard deviation of a centroid.
        subject_mm: height of the person who walks through; 0 for none, as for objects.
        markers: of that person: 15 of the lower limbs, or as many on the whole body.
    """

    volume_mm: Box = (0.0, 0.0, 0.0, 2400.0, 1400.0, 2000.0)
    cameras: int = 6
    given: pathlib.Path | None = None
    height_mm: tuple[float, float] = (1000.0, 2600.0)
    distance_mm: tuple[float, float] = (1500.0, 4000.0)
    walls_mm: tuple[float, float, float, float] | None = None
    focal_mm: float | None = None
    pitch_um: float | None = None
    focal_px: float | None = None
    size_px: tuple[int, int] = (1280, 1024)
    marker_mm: float = 14.0
    least_image_px: float = 2.5
    centroid_px: float = 0.1
    subject_mm: float = 1730.0
    markers: int = 15


class PlanResult(NamedTuple):
    """Figures of a plan, and where its files are."""

    figures: dict[str, Any]
    folder: pathlib.Path


def camera_plan(
    folder: pathlib.Path | str,
    *,
    settings: PlanSettings = PlanSettings(),
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
