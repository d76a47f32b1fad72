"""The whole file: `[cameras]`, `[[trials]]`, `[masks]`, and a method for each stage."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, InstanceOf, WithJsonSchema, field_validator, model_validator
from pydantic.json_schema import SkipJsonSchema

from ...data.method import Method
from ...detect import DETECT, Centroids
from ...digitise import SemiAutomatic
from ...fill import Filling
from ...label import Labelling
from ...label.subjects import MOST as MOST_SUBJECTS
from ...match import MATCH
from ...reconstruct import RECONSTRUCT, LeastSquares
from ...track import TRACK, matches_itself
from ...track.simultaneous import Simultaneous
from ...track.stage import CLOUD
from .calibration_table import CalibrationTable, Places, one_of
from .method_tables import (
    COMMON,
    calibrate_method,
    check_camera_names,
    method_name,
    method_of,
    methods_of_cameras,
    whole_of,
)
from .tables import AngleTable, GaitTable, Strict, SubjectTable, check_subject_of, check_subjects

A_METHOD = WithJsonSchema({"type": "object"})
"""Stands in the model's schema for what `schema.method_schema` says of a stage."""

RESERVED = (
    ".",
    "..",
    "rig.toml",
    "steps.json",
    "calibration.json",
    "calibration.html",
    "calibrations",
    "assets",
    "index.html",
    "gait",
)
"""What a trial cannot be called, since results are kept by these names."""
TEMPLATE_ENDING = ".template.h5"
"""Of what a session keeps of each subject, so that no trial can be called so either."""


Size = tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]]
"""Width and height, px."""


class Cameras(Strict):
    """`[cameras]`: what all recordings of the session have in common."""

    names: tuple[str, ...] = Field(
        default=(), description="the cameras' names in their order; as the calibration has them where empty"
    )
    size_px: Size | dict[str, Size] | None = Field(
        default=None,
        description="width and height of all images, or of those of each camera by its name, px, where a calibration "
        "from detections does not know them",
    )
    interlaced: bool | Literal["top", "bottom"] = Field(
        default=False,
        description="which field of an interlaced image was taken first, where fields are frames; true means top",
    )
    delays_ms: dict[str, Annotated[float, Field(allow_inf_nan=False)]] = Field(
        default={},
        description="by how much each camera named takes its images later than the others, ms; below 0 where earlier",
    )
    rates_hz: dict[str, Annotated[float, Field(gt=0, allow_inf_nan=False)]] = Field(
        default={},
        description="images a second of each camera named that has another rate than the frames, Hz",
    )

    aspect_ratio: float | None = Field(
        default=None,
        gt=0.1,
        lt=10,
        description="what v is multiplied by in UM²AS's files, to make pixels square; Kinemark's own calibrations "
        "find it by themselves",
    )

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

    model_config = ConfigDict(json_schema_extra={"anyOf": [{"required": ["file"]}, {"required": ["empty"]}]})

    file: Path | None = Field(default=None, description="TOML file of polygons")
    empty: str | None = Field(
        default=None, description="pattern of images of the empty volume, from which masks are learned"
    )
    grow_px: float | None = Field(
        default=None, ge=0, description="how far learned masks reach beyond what was seen, px"
    )

    @model_validator(mode="after")
    def not_empty(self) -> MaskTable:
        """An empty table would mask nothing."""
        if self.file is None and self.empty is None:
            raise ValueError("wants file, empty or both")
        return self


def is_da(path: Path) -> bool:
    """Whether a file is one of UM²AS's digitised centroids, `.da1`, `.da2`, …"""
    return path.suffix.lower().startswith(".da") and path.suffix[3:].isdecimal()


class TrialEntry(Strict):
    """`[[trials]]`: images or detections."""

    model_config = ConfigDict(json_schema_extra=one_of("images", "detections"))

    name: str = Field(max_length=100, description="of the trial, and of the folder of its results")
    images: str | None = Field(
        default=None, description="pattern of the images or videos, with {camera} for a camera's name"
    )
    detections: Path | None = Field(
        default=None,
        description="file of detections: HDF5, CSV, TDF or UM²AS's .da1; with {camera} in it, a CSV of each camera",
    )
    reference_marker: Places | None = Field(
        default=None,
        description="where the fixed marks of [calibration] are now, px; found among the detections where absent",
    )
    answers: str | None = Field(
        default=None,
        description="pattern of a file of each camera with what an operator answers, who digitises the images by "
        "[digitise]",
    )
    kind: Literal["motion", "static", "range_of_motion"] = Field(
        default="motion",
        description="static: the subject stands still; range_of_motion: all joints move. Both are labelled first, and "
        "the others by them",
    )
    subject: str | None = Field(default=None, description="who was recorded; as the session says where absent")
    date: datetime.date | None = Field(default=None, description="of the recording; as the session says where absent")
    analog: Path | None = Field(
        default=None,
        description="file of force plates, EMG and events that began with the cameras: C3D or TDF; as the detections' "
        "file holds them where absent",
    )
    frames: tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]] | None = Field(
        default=None, description="first and last frame of the stretch to process, counted from 1; all where absent"
    )
    every: int = Field(
        default=1,
        ge=1,
        le=1000,
        description="one frame, or field, of so many is taken of the images; all numbers of frames are then of those, "
        "and the rate is so many times lower",
    )

    @field_validator("name")
    @classmethod
    def folder(cls, name: str) -> str:
        """Results go into a folder of this name."""
        reserved = name in RESERVED or name.endswith(TEMPLATE_ENDING)
        if not (name.strip() and name.isprintable()) or Path(name).name != name or len(name) > 100 or reserved:
            raise ValueError(
                f"the name must be one that a folder can have, and not {', '.join((*RESERVED, f'*{TEMPLATE_ENDING}'))}"
            )
        return name

    @model_validator(mode="after")
    def one_source(self) -> TrialEntry:
        """Exactly one source must be given."""
        if (self.images is None) == (self.detections is None):
            raise ValueError(f"trial {self.name!r} wants either images or detections")
        if self.frames is not None and self.frames[0] > self.frames[1]:
            raise ValueError(f"trial {self.name!r} has frames = {list(self.frames)}: give the first, then the last")
        if self.frames is not None and self.answers is not None and self.frames[0] != 1:
            raise ValueError(
                f"trial {self.name!r} is digitised from its first frame on: say frames = [1, {self.frames[1]}]"
            )
        if self.answers is not None and self.images is None:
            raise ValueError(f"trial {self.name!r} has answers, which are of images, and has none")
        if self.every > 1 and self.images is None:
            raise ValueError(f"trial {self.name!r} has every = {self.every}, which is of images, and has none")
        return self

    @property
    def operated(self) -> bool:
        """Whether an operator says which marker is which: UM²AS's files, or images that they digitise."""
        return self.answers is not None or (self.detections is not None and is_da(self.detections))


class ReportTable(Strict):
    """`[report]`: how pages are written."""

    self_contained: bool = Field(
        default=False,
        description="each page holds the drawing library, 5 MB, so that it can be mailed alone; otherwise pages share "
        "one file in results/assets",
    )


def _taken_out(table: Any, of: str, part: str, key: str, whose: str) -> tuple[dict[str, Any], Any] | None:
    """The table `of` without its `part`, and the part, which is kept under a key of its own; None where it has none.

    Raises:
        ValueError: the session states that key itself.
    """
    if not isinstance(table, dict):
        return None
    if key in table:
        raise ValueError(f"{key}: there is no such key; {whose} go in [{of}.{part}.NAME]")
    whole = table.get(of)
    if not isinstance(whole, dict) or part not in whole:
        return None
    return {name: value for name, value in whole.items() if name != part}, whole[part]


class Settings(Strict):
    """The whole file."""

    name: str = Field(description="of the session")
    subject: str | None = Field(default=None, description="who was recorded, by name or code; stands on every page")
    date: datetime.date | None = Field(default=None, description="of the recording; stands on every page")
    rate_hz: float | None = Field(
        default=None,
        gt=0,
        le=1e6,
        allow_inf_nan=False,
        description="frames a second, Hz (fields where interlaced); as the recordings say where absent",
    )
    volume_mm: tuple[tuple[float, float, float], tuple[float, float, float]] | None = Field(
        default=None,
        description="least and greatest corner of the control volume, mm; that of the calibration where absent",
    )
    cameras: Cameras = Field(default=Cameras(), description="what all recordings have in common")
    calibration: CalibrationTable = Field(description="what the cameras are calibrated with")
    trials: tuple[TrialEntry, ...] = Field(min_length=1, description="the recordings")
    masks: MaskTable | None = Field(default=None, description="parts of the images to leave out")
    report: ReportTable = Field(default=ReportTable(), description="how pages are written")
    calibrate: Annotated[InstanceOf[Method], A_METHOD] = Field(default=None, validate_default=True)
    detect: Annotated[InstanceOf[Method], A_METHOD] = Field(default_factory=DETECT.make)
    detect_cameras: SkipJsonSchema[dict[str, Any]] = Field(default_factory=dict)
    match: Annotated[InstanceOf[Method], A_METHOD] = Field(default_factory=MATCH.make)
    reconstruct: Annotated[InstanceOf[Method], A_METHOD] = Field(default_factory=RECONSTRUCT.make)
    track: Annotated[InstanceOf[Method], A_METHOD] = Field(default_factory=TRACK.make)
    digitise: Annotated[InstanceOf[SemiAutomatic], A_METHOD] | None = None
    marker_set: str | None = Field(
        default=None, description="the markers that the subject wears: name of a shipped set, or a TOML file"
    )
    label: Annotated[InstanceOf[Labelling], A_METHOD] | None = None
    label_subjects: SkipJsonSchema[dict[str, SubjectTable]] = Field(default_factory=dict)
    fill: Annotated[InstanceOf[Filling], A_METHOD] | None = None
    angles: AngleTable | None = Field(default=None, description="joint angles of each trial, computed last")
    gait: GaitTable | None = Field(default=None, description="one gait report of the walks, computed after the trials")

    @model_validator(mode="before")
    @classmethod
    def cameras_apart(cls, table: Any) -> Any:
        """`[detect.cameras.NAME]`, beside `[detect]` for all, becomes a method of that camera in `detect_cameras`."""
        found = _taken_out(table, "detect", "cameras", "detect_cameras", "parameters of a camera")
        if found is None:
            return table
        rest, cameras = found
        return table | {"detect": rest, "detect_cameras": methods_of_cameras(rest, cameras)}

    @model_validator(mode="before")
    @classmethod
    def subjects_apart(cls, table: Any) -> Any:
        """`[label.subjects.NAME]`, beside `[label]` for all, becomes a subject in `label_subjects`."""
        found = _taken_out(table, "label", "subjects", "label_subjects", "parameters of a subject")
        if found is None:
            return table
        rest, subjects = found
        return table | {"label": rest, "label_subjects": subjects}

    @model_validator(mode="after")
    def subjects_known(self) -> Settings:
        """What is of one subject goes with no several, and a trial is of those that there are."""
        if self.label is None or not self.label_subjects:
            return self
        check_subjects(self.label_subjects, self.label, MOST_SUBJECTS)
        if self.subject is not None:
            raise ValueError("subject is one, and [label.subjects] says who was recorded: leave it out")
        if self.angles is not None or self.gait is not None:
            raise ValueError(
                "[angles] and [gait] are of one subject, and there are [label.subjects]: leave them out, and give the "
                "trials' C3D files to kinemark angles and kinemark gait"
            )
        for trial in self.trials:
            check_subject_of(trial.name, trial.subject, self.label_subjects)
        return self

    def subjects_of(self, entry: TrialEntry | None = None) -> tuple[str, ...]:
        """Of several subjects, those of a trial, or of the session; none where there is one."""
        return (entry.subject,) if entry and entry.subject and self.label_subjects else tuple(self.label_subjects)

    def of_subject(self, name: str) -> Settings:
        """The settings as they would be for one of several subjects alone."""
        own = self.label_subjects[name]
        assert self.label is not None  # else there are no subjects
        alone = {"label": own.labelling(self.label), "label_subjects": {}, "subject": name}
        return self.model_copy(update=alone | {"marker_set": own.marker_set or self.marker_set})

    @model_validator(mode="after")
    def cameras_known(self) -> Settings:
        """Parameters of a camera that is not there would do nothing."""
        if self.cameras.names:
            check_camera_names(self.detect_cameras, self.cameras.names)
        if self.detect_cameras and any(trial.answers for trial in self.trials):
            raise ValueError("a trial has answers, which are digitised by [detect] alone: leave out [detect.cameras]")
        return self

    @field_validator("calibrate", "detect", "match", "reconstruct", "track", "label", "fill", "digitise", mode="before")
    @classmethod
    def chosen(cls, table: Any, info: Any) -> Any:
        """The method that a stage's table names, with its parameters."""
        if info.field_name in COMMON:
            return whole_of(info.field_name, table) if isinstance(table, dict) else table
        if info.field_name == "calibrate" and "calibration" in info.data:
            return calibrate_method(info.data["calibration"].way, {} if table is None else table)
        return method_of(info.field_name, table) if isinstance(table, dict) else table

    @model_validator(mode="after")
    def stages_used(self) -> Settings:
        """A tracker that takes images directly leaves the stages before it nothing to do."""
        if any(trial.answers for trial in self.trials) and not (self.digitise and isinstance(self.detect, Centroids)):
            raise ValueError(
                "a trial has answers: give [digitise] with the names of its markers, and [detect] the method centroids"
            )
        if all(trial.operated for trial in self.trials):
            return self  # nothing is matched or tracked, and all points are placed by [reconstruct]
        idle = {"match", "reconstruct"} & self.model_fields_set if matches_itself(self.track) else set()
        if isinstance(self.track, Simultaneous) and isinstance(self.reconstruct, LeastSquares):
            idle -= {"reconstruct"}  # its points are placed so
        if idle:
            own = method_name("track", self.track)
            staged = ", ".join(name for name, declared in TRACK.items() if declared.takes == CLOUD)
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

    @model_validator(mode="after")
    def walks_known(self) -> Settings:
        """A walk that is no trial would be left out without a word."""
        names = {trial.name for trial in self.trials}
        if self.gait is not None and (unknown := [name for name in self.gait.trials if name not in names]):
            raise ValueError(f"gait.trials names {unknown[0]!r}, which is none of the trials {sorted(names)}")
        return self

    @field_validator("trials")
    @classmethod
    def distinct(cls, trials: tuple[TrialEntry, ...]) -> tuple[TrialEntry, ...]:
        """Results are kept by name, so names must differ."""
        names = [trial.name for trial in trials]
        if len(set(names)) != len(names):
            raise ValueError(f"trials must have different names, found {names}")
        return trials
