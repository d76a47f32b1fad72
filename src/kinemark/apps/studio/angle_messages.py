"""What the server and the page say of joint angles. Columns are base64 of float32, little-endian, NaN where missing."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from .camera_messages import FindingRow, TableRows
from .messages import Message

Smoothing = Literal["none", "butterworth", "woltring"]


class AngleChoice(Message):
    """How angles are taken; what is null is as the session says, or as fits."""

    model: Annotated[str, Field(max_length=200)] | None = None
    side: Literal["right", "left"] | None = None
    inverse_cosines: bool | None = None
    smoothing: Smoothing | None = None
    cutoff_hz: Annotated[float, Field(gt=0, le=1e5)] | None = None
    marker_sd_mm: Annotated[float, Field(gt=0, le=1e3)] | None = None
    cycle_event: Annotated[str, Field(max_length=100)] | None = None
    cycle_side: Annotated[str, Field(max_length=100)] | None = None


class ModelRow(Message):
    """A model, and whether the trial has its markers; `wants` are those that it lacks."""

    name: str
    fits: bool
    wants: list[str]


class CycleCurve(Message):
    """An angle over cycles of 0 to 100 % in 101 points, deg: mean, standard deviation, and each cycle [n, 101]."""

    mean: str
    spread: str
    each: str
    n: int


class AngleCurve(Message):
    """One angle of a joint, deg, frame by frame: value and standard deviation; `normal` is the range of its joint."""

    turn: int
    name: str
    positive: str
    negative: str
    normal: tuple[float, float] | None
    deg: str
    sd: str
    cycles: CycleCurve | None


class JointShown(Message):
    """A joint with its angles; `locked` are frames in gimbal lock, first and last."""

    index: int
    name: str
    about: str
    locked: list[tuple[int, int]]
    curves: list[AngleCurve]


class LimbPoint(Message):
    """A point of the limb, xyz [frames, 3] mm."""

    name: str
    xyz: str


class EventKind(Message):
    """Events from one of which to the next a cycle may go."""

    label: str
    side: str
    times: int


class AnglesShown(Message):
    """The joint angles of a trial; `words` say why there are none, where there are none.

    `errors_stated`: the file itself states the errors of all markers, so that none can be stated for them.
    """

    models: list[ModelRow]
    chosen: AngleChoice
    words: str
    headline: str = ""
    sentences: list[str] = Field(default_factory=list)
    findings: list[FindingRow] = Field(default_factory=list)
    tables: list[TableRows] = Field(default_factory=list)
    joints: list[JointShown] = Field(default_factory=list)
    limb: list[LimbPoint] = Field(default_factory=list)
    links: list[tuple[int, int]] = Field(default_factory=list)
    events: list[EventKind] = Field(default_factory=list)
    first_frame: int
    n_frames: int
    rate: float
    euler: bool = False
    errors_stated: bool = True
    head: str


class SpikeBody(AngleChoice):
    """A click on a curve: the angle, and the frame."""

    joint: Annotated[int, Field(ge=0)]
    turn: Annotated[int, Field(ge=0, le=2)]
    frame: int


class Spike(Message):
    """What made an angle leap: the frame, the marker, and the camera whose image is farthest off, in words too."""

    frame: int
    marker: str
    change_deg: float
    camera: str | None
    residual_px: float | None
    words: str


class EulerFiles(Message):
    """The names of the files that were written."""

    names: list[str]
