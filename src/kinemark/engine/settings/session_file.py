"""The whole file: `[cameras]`, `[[trials]]`, `[masks]`, and a method for each stage."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, SkipValidation, field_validator, model_validator

from ...calibrate import ControlPoints
from ...calibrate.bundle import Bundle
from ...calibrate.control_points import Dlt
from ...calibrate.wand import Wand
from ...detect import Centroids, KissNearest, KissScanning
from ...digitise import SemiAutomatic
from ...fill import Filling
from ...match import EpipolarTriplets, KissTriplets, NearestEpipolar
from ...reconstruct import CameraPairs, LeastSquares
from ...track import DistanceOnly, ExtrapolationLadder, KissTracking, Swamidas
from ...track.simultaneous import DETECTION_TRACKERS, FormerTwoCameras, Simultaneous
from .calibration_table import CalibrationTable, Places
from .method_tables import METHODS, calibrate_method, filling_of, method_name, method_of, parameters_of
from .table import Strict

RESERVED = (".", "..", "rig.toml", "steps.json", "calibration.json", "calibration.html", "calibrations")
"""What a trial cannot be called, since results are kept by these names."""


class Cameras(Strict):
    """`[cameras]`: names in their order; interlaced: "top" or "bottom" (true means "top") where fields are frames.

    size_px: width and height of all images, where a calibration from detections cannot know them otherwise.
    """

    names: tuple[str, ...] = ()
    size_px: tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]] | None = None
    interlaced: bool | Literal["top", "bottom"] = False

    @field_validator("names")
    @classmethod
    def distinct(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        """Two cameras of one name could not be told apart."""
        if len(set(names)) != len(names):
            raise ValueError(f"names must differ, found {list(names)}")
        return names

    @property
    def first_field(self) -> Literal[False, "top", "bottom"]:
        """Which field of a frame was taken first; False where frames are whole."""
        return "top" if self.interlaced is True else self.interlaced


class MaskTable(Strict):
    """`[masks]`: parts of the images to leave out, drawn in a file, or learned from a recording of the empty volume."""

    file: Path | None = None
    empty: str | None = None
    grow_px: float | None = Field(None, ge=0)

    @model_validator(mode="after")
    def something(self) -> MaskTable:
        """An empty table would mask nothing."""
        if self.file is None and self.empty is None:
            raise ValueError("wants file, empty or both")
        return self


def is_da(path: Path) -> bool:
    """Whether a file is one of UM²AS's digitised centroids, `.da1`, `.da2`, …"""
    return path.suffix.lower().startswith(".da") and path.suffix[3:].isdecimal()


class TrialEntry(Strict):
    """`[[trials]]`: images or detections.

    reference_marker: where the fixed marks of `[calibration]` are now; found among the detections where absent.
    answers: a file of each camera with what an operator answers, who digitises the images by `[digitise]`.
    frames: first and last frame of the stretch to process, counted from 1; all frames where absent.
    """

    name: str
    images: str | None = None
    detections: Path | None = None
    reference_marker: Places | None = None
    answers: str | None = None
    frames: tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]] | None = None

    @field_validator("name")
    @classmethod
    def folder(cls, name: str) -> str:
        """Results go into a folder of this name."""
        if not name.isprintable() or Path(name).name != name or len(name) > 100 or name in RESERVED:
            raise ValueError(f"the name must be one that a folder can have, and not {', '.join(RESERVED)}")
        return name

    @model_validator(mode="after")
    def one_source(self) -> TrialEntry:
        """Exactly one source must be given."""
        if (self.images is None) == (self.detections is None):
            raise ValueError(f"trial {self.name!r} wants either images or detections")
        if self.frames is not None and self.frames[0] > self.frames[1]:
            raise ValueError(f"trial {self.name!r} has frames = {list(self.frames)}: give the first, then the last")
        if self.frames is not None and self.answers is not None:
            raise ValueError(f"trial {self.name!r} is digitised from its first frame on: leave out frames")
        if self.answers is not None and self.images is None:
            raise ValueError(f"trial {self.name!r} has answers, which are of images, and has none")
        return self

    @property
    def operated(self) -> bool:
        """Whether an operator says which marker is which: UM²AS's files, or images that he digitises."""
        return self.answers is not None or (self.detections is not None and is_da(self.detections))


class Settings(Strict):
    """The whole file."""

    name: str
    rate_hz: float | None = Field(None, gt=0, le=1e6)
    volume_mm: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    cameras: Cameras = Cameras()
    calibration: CalibrationTable
    trials: tuple[TrialEntry, ...] = Field(min_length=1)
    masks: MaskTable | None = None
    calibrate: ControlPoints | Dlt | Wand | Bundle = Field(None, validate_default=True)
    detect: Centroids | KissScanning | KissNearest = Centroids()
    match: EpipolarTriplets | KissTriplets | NearestEpipolar = EpipolarTriplets()
    reconstruct: LeastSquares | CameraPairs = LeastSquares()
    track: Simultaneous | FormerTwoCameras | ExtrapolationLadder | KissTracking | Swamidas | DistanceOnly = (
        Simultaneous()
    )
    digitise: SemiAutomatic | None = None
    fill: Annotated[Filling, SkipValidation] | None = None

    @field_validator("calibrate", "detect", "match", "reconstruct", "track", "fill", mode="before")
    @classmethod
    def chosen(cls, table: Any, info: Any) -> Any:
        """The method that a stage's table names, with its parameters."""
        if info.field_name == "fill":
            return filling_of(table) if isinstance(table, dict) else table
        if info.field_name == "calibrate" and "calibration" in info.data:
            return calibrate_method(info.data["calibration"].way, {} if table is None else table)
        return method_of(info.field_name, table) if isinstance(table, dict) else table

    @field_validator("digitise", mode="before")
    @classmethod
    def operator(cls, table: Any) -> Any:
        """How an operator digitises."""
        return parameters_of(SemiAutomatic, "digitise", table) if isinstance(table, dict) else table

    @model_validator(mode="after")
    def stages_used(self) -> Settings:
        """A tracker that takes images directly leaves the stages before it nothing to do."""
        if any(trial.answers for trial in self.trials) and not (self.digitise and isinstance(self.detect, Centroids)):
            raise ValueError(
                "a trial has answers: give [digitise] with the names of its markers, and [detect] the method centroids"
            )
        if all(trial.operated for trial in self.trials):
            return self  # nothing is matched or tracked, and all points are placed by [reconstruct]
        idle = {"match", "reconstruct"} & self.model_fields_set if type(self.track) in DETECTION_TRACKERS else set()
        if isinstance(self.track, Simultaneous) and isinstance(self.reconstruct, LeastSquares):
            idle -= {"reconstruct"}  # its points are placed so
        if idle:
            own = method_name("track", self.track)
            staged = ", ".join(name for name, kind in METHODS["track"].items() if kind not in DETECTION_TRACKERS)
            raise ValueError(
                f"track by {own!r} matches by itself, so [{'] and ['.join(sorted(idle))}] would do nothing: "
                f"leave it out, or give [track] one of the methods {staged}"
            )
        return self

    @field_validator("volume_mm")
    @classmethod
    def box(cls, volume: Any) -> Any:
        """The first corner is the lesser one."""
        if volume is not None and not all(a < b for a, b in zip(*volume, strict=True)):
            raise ValueError("wants the least corner first, then the greatest")
        return volume

    @field_validator("trials")
    @classmethod
    def distinct(cls, trials: tuple[TrialEntry, ...]) -> tuple[TrialEntry, ...]:
        """Results are kept by name, so names must differ."""
        names = [trial.name for trial in trials]
        if len(set(names)) != len(names):
            raise ValueError(f"trials must have different names, found {names}")
        return trials
