"""`[calibration]` and the tables in it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from ...calibrate.reference_marker import REACH, TOLERANCE
from .tables import Strict

Unit = Literal["mm", "cm", "m", "in"]

WAYS = ("file", "control_points", "control_frame", "wand", "single_marker")
"""The ways to a calibration, of which a session has one."""

FREE = ("wand", "single_marker")
"""Those that know no laboratory: their world is the first camera's unless it is given."""

Positive = Annotated[float, Field(gt=0)]


def one_of(*keys: str) -> dict[str, Any]:
    """What a JSON schema says of a table that has exactly one of some keys."""
    return {"oneOf": [{"required": [key]} for key in keys]}


class TargetRecording(Strict):
    """What cameras saw of something: images, or detections made of them before. Exactly one of both."""

    model_config = ConfigDict(json_schema_extra=one_of("images", "detections"))

    images: str | None = Field(
        default=None, description="pattern of the images or videos, with {camera} for a camera's name"
    )
    detections: Path | None = Field(default=None, description="file of detections: HDF5, CSV or TDF")

    @model_validator(mode="after")
    def one_source(self) -> Self:
        """Exactly one source must be given."""
        if (self.images is None) == (self.detections is None):
            raise ValueError("wants either images or detections")
        return self


class DigitisedPoints(Strict):
    """Control points and their places in the images, in a CSV file; with images, a place snaps to the marker there."""

    points: Path = Field(description="CSV file with names, places in mm and images in px")
    images: str | None = Field(default=None, description="pattern of the images, one a camera")
    marker_diameter_mm: float | None = Field(
        default=None, gt=0, description="diameter of spheres, mm, whose images are then corrected for perspective"
    )


class ControlFrame(Strict):
    """Hanging rods of markers, recognised in one image a camera."""

    rods: Path = Field(description="TOML file of the rods and their markers")
    images: str = Field(description="pattern of the images, one a camera")


class WandRecording(TargetRecording):
    """A stick with markers in a row, waved through the volume."""

    lengths_mm: tuple[Positive, ...] = Field(
        min_length=1, max_length=4, description="gaps between neighbouring markers, mm, K − 1 of K markers"
    )
    marker_diameter_mm: float | None = Field(
        default=None, gt=0, description="diameter of spheres, mm, whose images are then corrected for perspective"
    )


class Distance(TargetRecording):
    """Two markers at a known distance, from centre to centre, that all cameras see."""

    mm: float = Field(gt=0, description="the distance, mm")


class SingleMarker(TargetRecording):
    """One marker, as an LED, moved through the volume; the scale is that of `distance`, or of the world frame."""

    distance: Distance | None = Field(default=None, description="two markers at a known distance, for the scale")


class LFrame(TargetRecording):
    """Three markers on the floor that make the world: a corner, a long arm along X and a short one along Y."""

    height_mm: float = Field(default=0.0, description="of the markers' centres above the floor, mm")
    arms_mm: tuple[Positive, Positive] = Field(
        description="from the corner to the marker on each arm, centre to centre, mm"
    )


class LinearisationGrid(Strict):
    """A plane grid seen from near by, one image a camera, or several by a pattern with *."""

    grid: tuple[Annotated[int, Field(ge=3)], Annotated[int, Field(ge=3)]] = Field(
        description="columns and rows, of dots or of inner corners"
    )
    pitch_mm: float = Field(gt=0, description="distance of neighbours, mm")
    images: str = Field(description="pattern of the images")
    pattern: Literal["dots", "chessboard"] = Field(default="dots", description="what the grid is made of")
    radial: int | None = Field(
        default=None,
        ge=0,
        le=3,
        description="how many of k1, k2, k3 are fitted; chosen by cross-validation where absent",
    )
    tangential: bool | None = Field(
        default=None, description="whether p1 and p2 are fitted; chosen by cross-validation where absent"
    )


Places = dict[str, tuple[tuple[float, float], ...]]


class CalibrationTable(Strict):
    """`[calibration]`: exactly one way; beside most of them the lenses, the world frame, and fixed marks."""

    model_config = ConfigDict(json_schema_extra=one_of(*WAYS))

    file: Path | None = Field(
        default=None, description="a ready-made calibration: rig TOML, DLT CSV, TDF or UM²AS's .cp1"
    )
    length_unit: Unit | None = Field(default=None, description="unit of length of a file that does not say it")
    control_points: DigitisedPoints | None = Field(default=None, description="markers at surveyed places")
    control_frame: ControlFrame | None = Field(default=None, description="hanging rods of markers at surveyed places")
    wand: WandRecording | None = Field(default=None, description="a wand waved through the volume")
    single_marker: SingleMarker | None = Field(default=None, description="one marker moved through the volume")
    linearisation: LinearisationGrid | None = Field(
        default=None, description="a plane grid that shows the lenses beforehand"
    )
    l_frame: LFrame | None = Field(
        default=None, description="the world of a wand or single marker: an L-frame on the floor"
    )
    world_points: DigitisedPoints | None = Field(
        default=None, description="the world of a wand or single marker: markers at surveyed places"
    )
    reference_marker: Places | None = Field(
        default=None,
        description="where each camera saw marks that never move when it was calibrated, px; their shift in a trial "
        "corrects its detections",
    )
    mark_reach_px: float = Field(default=REACH, gt=0, description="no image shifts further than this, px")
    mark_tolerance_px: float = Field(
        default=TOLERANCE,
        gt=0,
        description="how far marks of one camera may differ from a common shift, and move during a trial, px",
    )

    @property
    def way(self) -> str:
        """The name of the way."""
        return next(way for way in WAYS if getattr(self, way) is not None)

    @model_validator(mode="after")
    def one_way(self) -> CalibrationTable:
        """Exactly one way must be given, and beside it only what goes with it."""
        ways = [way for way in WAYS if getattr(self, way) is not None]
        if len(ways) != 1:
            found = " and ".join(ways) or "none"
            raise ValueError(f"wants exactly one of {', '.join(WAYS[:-1])} and {WAYS[-1]}, found {found}")
        goes_with = {"length_unit": ("file",), "linearisation": WAYS[1:], "l_frame": FREE, "world_points": FREE}
        for key, partners in goes_with.items():
            if getattr(self, key) is not None and ways[0] not in partners:
                raise ValueError(f"{key} goes with {' or '.join(partners)}, not with {ways[0]}")
        if self.l_frame and self.world_points:
            raise ValueError("wants one world frame, l_frame or world_points, found both")
        if self.single_marker and not (self.single_marker.distance or self.l_frame or self.world_points):
            raise ValueError("single_marker does not tell the scale: give distance in it, l_frame or world_points")
        return self
