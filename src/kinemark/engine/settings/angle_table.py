"""`[angles]`: joint angles of every trial of a session."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...data import KinemarkError
from ..angles.settings import AngleSettings
from .table import Strict

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
