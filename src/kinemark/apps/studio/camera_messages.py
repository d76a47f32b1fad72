"""What the server and the page say of a session's cameras, their calibration, and control balls that are pointed at."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ...engine.first_session import Role
from ...findings.verdict import GradeShown
from .messages import CameraRow, Message, Vector
from .new_session_messages import Asked, Text


class TileRow(Message):
    """A key figure, what it is, and what else there is to say."""

    value: str
    name: str
    more: str


class TableRows(Message):
    """A table of words; `marked` tells which rows want a look."""

    title: str
    about: str
    head: list[str]
    rows: list[list[str]]
    marked: list[bool]


class FindingRow(Message):
    """What was found, how grave it is, and what to do about it."""

    severity: Literal["info", "amber", "red", "green"]
    words: str
    advice: str
    cameras: list[str]


class ErrorMap(Message):
    """Standard deviation per axis, mm, over the places of the volume, x slowest, z fastest; null where too few see it.

    `lost` are the same without each camera in the level where coordinate `axis` is `level_mm`, of the other two axes,
    the first of them slowest.
    """

    x: list[float]
    y: list[float]
    z: list[float]
    sd_mm: list[float | None]
    axis: int
    level_mm: float
    lost: dict[str, list[float | None]]


class CalibrationShown(Message):
    """A calibration with its judgement; `made` is local time; `current` whether a run would take it as it is."""

    made: str
    way: str
    current: bool
    grade: GradeShown
    headline: str
    sentences: list[str]
    findings: list[FindingRow]
    tiles: list[TileRow]
    cameras: list[CameraRow]
    residual_px: dict[str, float | None]
    volume: tuple[Vector, Vector]
    map: ErrorMap
    tables: list[TableRows]


class Earlier(Message):
    """A former calibration, and how the cameras of now differ from it."""

    made: str
    world_moved_mm: float | None
    table: TableRows


class StatedNumbers(Message):
    """Numbers of `[calibration]` that a person measured; none where nothing is stated."""

    key: str
    words: str
    least: int
    most: int
    values: list[float]
    optional: bool


class SessionCameras(Message):
    """A session's cameras: how they are calibrated, by which numbers, and what came of it."""

    id: str
    title: str
    way: str
    way_words: str
    names: list[str]
    numbers: list[StatedNumbers]
    control: bool
    calibration: CalibrationShown | None
    earlier: list[Earlier]
    trials: list[str]


class NumbersBody(Message):
    """Numbers that are stated anew, by their keys; an empty list takes optional ones away."""

    numbers: dict[str, Annotated[list[Annotated[float, Field(gt=0, lt=1e6)]], Field(max_length=4)]]


class BallPlace(Message):
    """Where an operator said that a camera sees a ball, px; `seen` is null where it was not asked yet."""

    point: str
    u: float | None = None
    v: float | None = None
    seen: bool | None = None


class ControlCamera(Message):
    """The image of a camera, how its white pixels are found, and what was said of the balls in it, in their order."""

    name: str
    width: int
    height: int
    threshold: float | None
    inverted: bool
    balls: list[BallPlace]
    reference: BallPlace


class ControlPoint(Message):
    """A control point at its measured place, mm."""

    name: str
    xyz: Vector


class Control(Message):
    """Control points in the images; `file` is where answers are kept, `reference_files` where marks may be read."""

    points: list[ControlPoint]
    cameras: list[ControlCamera]
    reference: str
    file: str
    reference_files: list[str]


class WhitePixels(Message):
    """The threshold of an image, a grey level of 8 bits, and the centroids that can be pointed at then, px."""

    threshold: float | None
    inverted: bool
    centroids: list[tuple[float, float]]


class BallBody(Message):
    """What is said of a ball, or of the reference marker: a click, `seen` false, a file, or that it is taken back."""

    point: Annotated[str, Field(max_length=100)]
    u: float | None = None
    v: float | None = None
    seen: bool = True
    forget: bool = False
    file: Annotated[str, Field(max_length=200)] | None = None
    threshold: Annotated[float, Field(ge=0, le=255)] | None = None
    inverted: bool | None = None


class ThresholdBody(Message):
    """The threshold that detection shall have from now on: of one camera, or of all where none is named."""

    camera: Annotated[str, Field(max_length=100)] | None = None
    threshold: Annotated[float, Field(ge=0, le=255)] | None = None
    inverted: bool = False


class WayRow(Message):
    """A recording that could calibrate the session, as what, why, and what is asked for it; `now` where it does."""

    path: str
    role: str
    words: str
    why: str
    now: bool
    questions: list[Asked]


class Ways(Message):
    """All of them."""

    ways: list[WayRow]


class WayBody(Message):
    """The recording that shall calibrate from now on, as what; answers as typed, by the keys of its questions."""

    path: Annotated[str, Field(max_length=500)]
    role: Role
    answers: dict[str, Text] = Field(default_factory=dict)


class Targets(Message):
    """What calibrates and has images, by the keys of `[calibration]`, each in words."""

    kinds: dict[str, str]


class TargetPoint(Message):
    """A marker of a target, px."""

    name: str
    u: float
    v: float


class FoundInImage(Message):
    """A target in an image: its markers, which are joined, all that is bright, and what is found or why not."""

    width: int
    height: int
    frames: int
    points: list[TargetPoint]
    lines: list[tuple[int, int]]
    spots: list[tuple[float, float]]
    words: str
