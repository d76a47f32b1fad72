"""What is said of the screens Detect and Digitise: images of one frame, what is found in them, and why.

Pixels are those of the image, (0, 0) the centre of the first; frames are numbers in the recording.
"""

from __future__ import annotations

from datetime import date
from typing import Annotated, Literal

from pydantic import Field

from .messages import EpipolarLine, Message

Pixel = tuple[float, float]
Value = float | bool | None
"""Of a parameter; null where it is left open."""
Name = Annotated[str, Field(max_length=100)]
Polygon = Annotated[list[Pixel], Field(min_length=3, max_length=200)]
Values = Annotated[dict[Name, Value], Field(max_length=40)]
MarkState = Literal["marker", "too small", "too large", "not round", "at edge", "masked"]
Phase = Literal["point", "reference", "review", "verify", "correct", "done"]
How = Literal["open", "not present", "automatic", "pointed", "placed", "proposed", "ambiguous"]


class DetectParameter(Message):
    """A parameter of `[detect]`: what kind it is, its range, its meaning, and what the session says."""

    name: str
    whole: bool
    flag: bool
    unit: str
    low: float | None
    high: float | None
    meaning: str
    stated: Value


class DetectCamera(Message):
    """A camera: its images, what `[detect.cameras.NAME]` says, masks; `tall` where lines are of a field."""

    name: str
    width: int
    height: int
    tall: bool
    own: dict[str, Value]
    masks: list[list[Pixel]]


class Detection(Message):
    """How markers are detected in a trial; `words` say what there is to know before it is changed.

    `learned`: what is left open is learned from each camera's recording, else it is the usual value. One frame of
    `every` of the recording is taken.
    """

    trial: str
    session: str
    method: str
    first: int
    last: int
    parameters: list[DetectParameter]
    cameras: list[DetectCamera]
    learned: bool
    every: int
    words: str = ""


class DetectDraft(Message):
    """What is tried: parameters for all cameras, for single ones, and masks; null leaves a parameter open."""

    every: Values = Field(default={})
    cameras: dict[Name, Values] = Field(default={}, max_length=200)
    masks: dict[Name, Annotated[list[Polygon], Field(max_length=200)]] = Field(default={}, max_length=200)


class DetectFrameBody(Message):
    """A frame, and what is tried in it; in all cameras where none is named."""

    frame: int
    cameras: list[Name] = Field(default_factory=list)
    draft: DetectDraft = DetectDraft()


class Mark(Message):
    """A detection: centre and rectangle, px; why it is none; `merged` where markers lie on each other."""

    u: float
    v: float
    width: float
    height: float
    state: MarkState
    merged: bool


class CameraFound(Message):
    """What is found in a camera's image; `limits` as they were used, `refused` why nothing could be.

    `histogram` counts pixels by 256 grey levels; threshold in these.
    """

    name: str
    threshold: float | None
    inverted: bool
    ground: bool
    limits: dict[str, float]
    marks: list[Mark]
    histogram: list[int]
    refused: str = ""


class DetectFrame(Message):
    """What is found in a frame, in every camera."""

    frame: int
    cameras: list[CameraFound]


class WhyBody(Message):
    """A place in an image, and what is tried."""

    frame: int
    camera: str
    u: float
    v: float
    draft: DetectDraft = DetectDraft()


class PlaceWhy(Message):
    """Why there is a marker or none; the parameter that decided, and with which value it would be one."""

    words: str
    parameter: str = ""
    value: float | None = None


class DigitisedCamera(Message):
    """How far a camera is digitised."""

    name: str
    width: int
    height: int
    tall: bool
    saved: int


class PlacedMarker(Message):
    """A marker of the frame, before it is saved; u and v are null where it is not present, or not known yet."""

    name: str
    u: float | None
    v: float | None
    how: How


class PlaceSaid(Message):
    """What other cameras say of a missing marker; the place is null where it is only known to be hidden."""

    at: Pixel | None
    seen: bool


class DigitiseQuestion(Message):
    """What is asked: `at` is where the marker is or is expected, `search` the side of the square that was searched, px.

    `lines` are where the other cameras see it; `spots` what can be pointed at, nearest to `at` first.
    """

    phase: Phase
    frame: int
    marker: str
    words: str
    at: Pixel | None
    search: float
    ambiguous: bool
    said: PlaceSaid | None
    lines: list[EpipolarLine]
    spots: list[Pixel]


class DigitisingNow(Message):
    """Where an operator is: `kept` counts the answers of this camera, and must be said with the next one.

    One frame of `every` of the recording is taken; `frames` and all numbers are of those.
    """

    trial: str
    session: str
    cameras: list[DigitisedCamera]
    frames: int
    every: int
    camera: str
    kept: int
    markers: list[str]
    reference: str | None
    question: DigitiseQuestion
    draft: list[PlacedMarker]
    can_undo: bool
    finished: bool


class PointSaid(Message):
    """A pixel of the marker; where a place is corrected, the very place."""

    kind: Literal["point"]
    u: float
    v: float


class FrameSaid(Message):
    """Look again at a saved frame."""

    kind: Literal["frame"]
    frame: int


class PlainSaid(Message):
    """All other answers."""

    kind: Literal["absent", "yes", "no", "save", "verify", "hand", "undo"]


class AnswerBody(Message):
    """An answer, of whoever sees so many answers kept of this camera."""

    camera: str
    kept: int
    said: Annotated[PointSaid | FrameSaid | PlainSaid, Field(discriminator="kind")]


class SetupBody(Message):
    """The start of digitising: the markers in the order in which they are asked for, and the one that does not move.

    `reference_files` names UM²AS's files of its place; null: the first frame says it. One frame of `every` is taken;
    `last_frame`, counted among those, is null for all; `recorded`, the day of the recording, where nobody says it.
    """

    markers: list[Annotated[str, Field(min_length=1, max_length=100)]] = Field(max_length=30)
    reference: str | None = None
    confirm_reference: bool = True
    take_proposals: bool = False
    history: int = 2
    every: int = Field(default=1, ge=1, le=1000)
    last_frame: int | None = None
    reference_files: str | None = Field(default=None, max_length=200)
    recorded: date | None = None


class StartUp(Message):
    """What may be chosen before the first answer, and what is: of so many frames of the recording, which sets of files.

    `operated`: whether the trial is one that an operator digitises.
    """

    frames: int
    reference_files: list[str]
    now: SetupBody
    operated: bool
