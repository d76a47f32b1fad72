"""Tables of `session.toml`: `[angles]`, `[gait]` and `[label.subjects.NAME]`, and what all tables have in common."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from ...data import KinemarkError
from ...data.nearest_word import are, guess
from ...data.subject_measures import SubjectMeasures
from ...gait.clusters import SEGMENTS, segment_name
from ...gait.standard_trial import Up
from ...io.measures_toml import measures_of_table
from ...label import Labelling
from ..angles.settings import AngleSettings
from ..gait.exports import exports_of
from ..gait.settings import GaitSettings


class Strict(BaseModel):
    """A table of the file; a key that it does not know is an error, not a silence."""

    model_config = ConfigDict(extra="forbid", frozen=True)


Height = Annotated[float, Field(gt=0, allow_inf_nan=False)]

APART = ("template", "static", "markers", "height_mm", "template_height_mm")
"""What `[label]` says of one subject, and each of several says for itself."""


class SubjectTable(Strict):
    """A subject, called by the table's name, which stands before its markers, as in `A:LKNE`."""

    marker_set: str | None = Field(
        default=None, description="that this subject wears: a shipped set or a TOML file; the session's where absent"
    )
    template: tuple[str, ...] = Field(
        default=(),
        description="labelled trials that move, or a .template.h5; of a file of several subjects the markers with this "
        "one's name before theirs",
    )
    static: tuple[str, ...] = Field(default=(), description="labelled static trials, likewise")
    markers: tuple[str, ...] = Field(default=(), description="names to learn, without the subject's")
    height_mm: Height | None = Field(default=None, description="height of the subject, mm, as [label] has it")
    template_height_mm: Height | None = Field(default=None, description="height of the one whom the files are of, mm")

    @model_validator(mode="after")
    def together(self) -> SubjectTable:
        """The height of another subject says nothing without that of this one."""
        self.labelling(Labelling())
        return self

    def labelling(self, common: Labelling) -> Labelling:
        """What `[label]` would say of this subject alone."""
        return replace(common, **{key: getattr(self, key) for key in APART})


def check_subjects(subjects: Iterable[str], common: Labelling, most: int) -> None:
    """Refuse names that cannot stand before a marker's or in a file's, too many, and what is each subject's own.

    Raises:
        ValueError: there is such a thing.
    """
    names = list(subjects)
    if wrong := [name for name in names if not name.replace("-", "").replace("_", "").isalnum()]:
        raise ValueError(f"label.subjects: {wrong[0]!r} is no name of a subject; letters, digits, - and _ are")
    if len(names) > most:
        raise ValueError(f"label.subjects: there are {len(names)} subjects, and at most {most} are told apart")
    if common_to := [key for key in APART if getattr(common, key)]:
        raise ValueError(f"label.{common_to[0]}: is of one subject; give it in [label.subjects.{names[0]}]")


def check_subject_of(trial: str, subject: str | None, subjects: Iterable[str]) -> None:
    """Refuse a trial of one who is none of the subjects.

    Raises:
        ValueError: it is.
    """
    known = list(subjects)
    if subject is not None and subject not in known:
        raise ValueError(
            f"trial {trial!r} is of {subject!r}, who is none of label.subjects{guess(subject, known)}; "
            f"there {are(known)}"
        )


Number = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class AngleTable(Strict):
    """What `kinemark angles` is told otherwise; the session's static trial shows what clusters carry."""

    model: str = Field(description="name of a model, or its TOML file beside session.toml")
    side: Literal["right", "left"] | None = Field(
        default=None, description="of the limb; as the model or the markers' names say where absent"
    )
    inverse_cosines: bool = Field(default=False, description="angles as the thesis UM²AS takes them")
    lock_deg: Annotated[float, Field(ge=0, lt=90)] = Field(
        default=10.0, description="how near to gimbal lock a frame is flagged, deg"
    )
    smoothing: str = Field(default="none", description="of the markers before: none, butterworth or woltring")
    cutoff_hz: Number | None = Field(default=None, description="of the smoothing, Hz; by the data where absent")
    marker_sd_mm: Number | None = Field(
        default=None, description="standard deviation of markers whose own is not known, mm"
    )
    cycle: tuple[str, ...] = Field(default=(), description='beginning and end of each cycle, s, as "0-2.5"')
    cycle_event: str | None = Field(default=None, description="events from one of which to the next a cycle goes")
    cycle_side: str | None = Field(default=None, description="of these events")

    @model_validator(mode="after")
    def together(self) -> AngleTable:
        """What does not go together is refused when the file is read."""
        try:
            self.settings()
        except KinemarkError as error:
            raise ValueError(str(error)) from None
        return self

    def settings(self) -> AngleSettings:
        """The same as `kinemark angles` takes it."""
        said = {name: getattr(self, name) for name in type(self).model_fields if name != "model"}
        return AngleSettings(**said)


Millimetres = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class GaitTable(Strict):
    """What `kinemark gait` is told otherwise; the session's static trial shows the feet."""

    trials: tuple[str, ...] = Field(default=(), description="names of the walks; all trials of motion where absent")
    functional: str | None = Field(
        default=None, description="name of the trial whose motion shows the hip centres; by regression where absent"
    )
    measures: Path | dict[str, Any] | None = Field(
        default=None,
        description="of the subject: a TOML file, or [gait.measures]; as recordings state them, else estimated, where "
        "absent",
    )
    markers: dict[str, str] = Field(
        default={}, description="the recording's names of markers by the gait model's, where they are not usual ones"
    )
    clusters: dict[str, tuple[str, ...]] = Field(
        default={},
        description="three or more markers that carry a segment, calibrated in the static trial, by pelvis, "
        "left_thigh, left_shank, left_foot, right_thigh, …; the gait model's markers alone where absent",
    )
    reference: Path | None = Field(default=None, description="band of controls: drawn grey, and scored against")
    exports: str = Field(default="", description='files for other programs, as "trc,mot,sto,gcd"')
    method: Literal["physical", "plug_in_gait"] = Field(
        default="physical", description="plug_in_gait gives that program's numbers"
    )
    hip_centre: Literal["davis", "harrington", "hara"] = Field(default="davis", description="regression of the hip")
    inertia: Literal["winter", "de_leva_male", "de_leva_female", "plug_in_gait"] = Field(
        default="winter", description="of the segments"
    )
    smoothing: Literal["none", "butterworth", "woltring"] = Field(
        default="butterworth", description="of the markers before"
    )
    cutoff_hz: Annotated[float, Field(gt=0, allow_inf_nan=False)] | None = Field(
        default=None, description="of the smoothing, Hz; by the data where absent"
    )
    force_cutoff_hz: Annotated[float, Field(gt=0, allow_inf_nan=False)] | None = Field(
        default=None, description="of a low-pass filter of force plates, Hz; none where absent"
    )
    flat_foot: bool = Field(default=True, description="in the static trial heel and toe are at one height")
    axes: bool = Field(
        default=True, description="devices and markers inside of knees and ankles in the static trial show their axes"
    )
    placement_mm: Millimetres = Field(default=5.0, description="standard uncertainty of a marker on its landmark, mm")
    hip_mm: Millimetres = Field(default=10.0, description="of the hip joint centre, along each axis, mm")
    tissue_mm: Millimetres = Field(default=5.0, description="of thigh's and shank's markers by moving skin, mm")
    plate_mm: Millimetres = Field(default=3.0, description="of where plates lie among the markers, mm")
    uncertainty: bool = Field(default=True, description="whether to compute the error bars")
    emg_to: Literal["trial", "strides"] = Field(
        default="trial",
        description="100 % of EMG: the greatest of a trial, or the mean of the strides' greatest",
    )
    mvc: str | None = Field(default=None, description="name of the trial whose greatest EMG is 100 %")
    up: Up = Field(default="auto", description="the axis that goes up; as the markers show where absent")
    subject: str = Field(default="", description="whose gait it is, where the session has several subjects")

    @field_validator("measures")
    @classmethod
    def of_a_person(cls, value: Any) -> Any:
        """Measures that no person has are refused when the file is read."""
        if isinstance(value, dict):
            try:
                measures_of_table(value)
            except KinemarkError as error:
                raise ValueError(str(error)) from None
        return value

    @field_validator("clusters")
    @classmethod
    def of_a_body(cls, value: dict[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
        """So are clusters on segments that there are not."""
        named = {segment_name(name): markers for name, markers in value.items()}
        if unknown := sorted(set(named) - set(SEGMENTS)):
            there = ", ".join(name.replace(" ", "_") for name in SEGMENTS)
            raise ValueError(f"{unknown[0]} is no segment that a cluster is on; there are {there}")
        return named

    @field_validator("exports")
    @classmethod
    def known(cls, value: str) -> str:
        """So are exports that there are not."""
        try:
            exports_of(value)
        except KinemarkError as error:
            raise ValueError(str(error)) from None
        return value

    def settings(self) -> GaitSettings:
        """The same as `kinemark gait` takes it."""
        return GaitSettings(**{field.name: getattr(self, field.name) for field in fields(GaitSettings)})

    def stated_measures(self, root: Path) -> Path | SubjectMeasures | None:
        """What the table says of the subject; files are beside the session's."""
        if isinstance(self.measures, dict):
            return measures_of_table(self.measures)
        return None if self.measures is None else root / self.measures
