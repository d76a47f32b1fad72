"""`[gait]`: one gait report of a session's walks."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator

from ...data import KinemarkError
from ...data.subject_measures import SubjectMeasures
from ...gait.clusters import SEGMENTS, segment_name
from ...gait.standard_trial import Up
from ...io.measures_toml import measures_of_table
from ..gait.exports import exports_of
from ..gait.settings import GaitSettings
from .table import Strict

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
