"""`[calibration]` and the tables in it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from ...calibrate.reference_marker import REACH, TOLERANCE
from .table import Strict

Unit = Literal["mm", "cm", "m", "in"]

WAYS = ("file", "control_points", "control_frame", "wand", "single_marker")
"""The ways to a calibration, of which a session has one."""

FREE = ("wand", "single_marker")
"""Those that know no laboratory: their world is the first camera's unless it is given."""


class TargetRecording(Strict):
    """What cameras saw of something: images, or detections made of them before. Exactly one of both."""

    images: str | None = None
    detections: Path | None = None

    @model_validator(mode="after")
    def one_source(self) -> Self:
        """Exactly one source must be given."""
        if (self.images is None) == (self.detections is None):
            raise ValueError("wants either images or detections")
        return self


class DigitisedPoints(Strict):
    """Control points and their places in the images, in a CSV file; with images, a place snaps to the marker there.

    marker_diameter_mm: of spheres, whose images are then corrected for perspective.
    """

    points: Path
    images: str | None = None
    marker_diameter_mm: float | None = Field(None, gt=0)


class ControlFrame(Strict):
    """Hanging rods of markers, recognised in one image a camera."""

    rods: Path
    images: str


class WandRecording(TargetRecording):
    """A stick with markers in a row, waved through the volume.

    lengths_mm: gaps between neighbouring markers, K − 1 of K markers; marker_diameter_mm: of spheres.
    """

    lengths_mm: tuple[Annotated[float, Field(gt=0)], ...] = Field(min_length=1, max_length=3)
    marker_diameter_mm: float | None = Field(None, gt=0)


class Distance(TargetRecording):
    """Two markers at a known distance, from centre to centre, that all cameras see."""

    mm: float = Field(gt=0)


class SingleMarker(TargetRecording):
    """One marker, as an LED, moved through the volume; the scale is that of `distance`, or of the world frame."""

    distance: Distance | None = None


class LFrame(TargetRecording):
    """Three markers on the floor that make the world: a corner, a long arm along X and a short one along Y.

    arms_mm: from the corner to the marker on each arm, centre to centre; height_mm: of the centres above the floor.
    """

    height_mm: float = 0.0
    arms_mm: tuple[Annotated[float, Field(gt=0)], Annotated[float, Field(gt=0)]]


class LinearisationGrid(Strict):
    """A plane grid seen from near by, one image a camera, or several by a pattern with *.

    grid: columns and rows, of dots or of inner corners; pitch_mm: between neighbours; radial, tangential: which lens
    terms are fitted; chosen by cross-validation where absent.
    """

    grid: tuple[Annotated[int, Field(ge=3)], Annotated[int, Field(ge=3)]]
    pitch_mm: float = Field(gt=0)
    images: str
    pattern: Literal["dots", "chessboard"] = "dots"
    radial: int | None = Field(None, ge=0, le=3)
    tangential: bool | None = None


Places = dict[str, tuple[tuple[float, float], ...]]


class CalibrationTable(Strict):
    """`[calibration]`: exactly one way; beside most of them the lenses, the world frame, and fixed marks.

    reference_marker: where each camera saw marks that never move when it was calibrated, px; their shift in a trial
    corrects its detections. mark_reach_px: no image shifts further; mark_tolerance_px: how far marks of one camera may
    differ from a common shift, and move during a trial.
    """

    file: Path | None = None
    length_unit: Unit | None = None
    control_points: DigitisedPoints | None = None
    control_frame: ControlFrame | None = None
    wand: WandRecording | None = None
    single_marker: SingleMarker | None = None
    linearisation: LinearisationGrid | None = None
    l_frame: LFrame | None = None
    world_points: DigitisedPoints | None = None
    reference_marker: Places | None = None
    mark_reach_px: float = Field(REACH, gt=0)
    mark_tolerance_px: float = Field(TOLERANCE, gt=0)

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
