"""What the server and the page say of the menu of UM²AS: its entries, how far each is, and its files."""

from __future__ import annotations

from datetime import date
from typing import Annotated, Literal

from pydantic import Field

from .messages import Message

Name = Annotated[str, Field(max_length=200)]
Cameras = Annotated[list[Name], Field(max_length=64)]


class MenuRow(Message):
    """An entry of the menu in the level `above`, where it is done, and how far it is; `files` by their names."""

    key: str
    above: str
    title: str
    about: str
    figure: str
    place: Literal["menu", "here", "cameras", "detect", "digitise", "angles"]
    state: Literal["", "done", "open", "again", "waits"]
    words: str
    files: list[str]


class MenuTrial(Message):
    """A trial that the menu may be of."""

    id: str
    name: str


class Um2asMenu(Message):
    """The menu over a session and a trial; `tdc` is what angles are taken of, `tdcs` what there is to choose from."""

    session: str
    title: str
    trial: str
    trials: list[MenuTrial]
    cameras: list[str]
    chosen: list[str]
    tdc: str
    tdcs: list[str]
    folder: str
    entries: list[MenuRow]


class ParametersBody(Message):
    """The date for camera 1's file."""

    made: date


class CoordinatesBody(Message):
    """The cameras that places are calculated by; all where none are named."""

    trial: Name
    cameras: Cameras = Field(default_factory=list)


class EulerBody(Message):
    """The file of places, and whether angles are taken by inverse cosines, as UM²AS does."""

    trial: Name
    tdc: Name
    inverse_cosines: bool = False


class Written(Message):
    """Files that were written, and what else there is to say."""

    names: list[str]
    words: str


class FilePage(Message):
    """A frame of a file of UM²AS, or all of one that has no frames; 999 stands as null. Frames count from 1."""

    name: str
    head: list[str]
    rows: list[list[float | None]]
    frame: int
    frames: int


class Bars(Message):
    """Recordings that may show the bar, as patterns; and what V is multiplied by now, null for nothing."""

    images: list[str]
    factor: float | None


class BarBody(Message):
    """A recording of the bar, and the threshold; each image's own where it is null."""

    images: Name
    threshold: Annotated[float, Field(ge=0, le=255)] | None = None
    inverted: bool = False


class BarRow(Message):
    """What the bar says of a camera's pixels; `factor` is null where it says nothing, and `words` then why."""

    camera: str
    factor: float | None
    sd: float | None
    words: str


class BarMeasured(Message):
    """Of all cameras, and their mean."""

    cameras: list[BarRow]
    factor: float | None


class FactorBody(Message):
    """What V is multiplied by from now on; null for nothing."""

    factor: Annotated[float, Field(gt=0.1, lt=10)] | None
