"""What `kinemark plan` is asked for."""

from __future__ import annotations

import pathlib
from dataclasses import dataclass

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
