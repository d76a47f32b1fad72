"""What a person can do on the screen: a union that is told apart by `kind`.

Frames are numbers in the recording, both ends included; null follows a path as far as that goes.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from ...data.edits import SmoothingFunction

Name = Annotated[str, Field(min_length=1, max_length=256)]
Frame = Annotated[int, Field(ge=-(10**9), le=10**9)]
Number = Annotated[float, Field(allow_inf_nan=False, ge=-1e12, le=1e12)]
Place = tuple[Number, Number, Number]


class Said(BaseModel):
    """An act; nothing besides its fields is understood."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class ClaimAct(Said):
    """A stretch of a trajectory is this marker; or no marker, where `name` is null. `at`: the frame pointed at."""

    kind: Literal["claim"]
    track: Name
    name: Name | None
    first: Frame | None = None
    last: Frame | None = None
    at: Frame | None = None


class ExchangeAct(Said):
    """Two named trajectories have each other's names from a frame on, or in a stretch."""

    kind: Literal["exchange"]
    a: Name
    b: Name
    first: Frame | None = None
    last: Frame | None = None


class SidesAct(Said):
    """Left and right of every pair of markers are exchanged, from a frame on, or in a stretch."""

    kind: Literal["sides"]
    first: Frame | None = None
    last: Frame | None = None


class EraseAct(Said):
    """Samples are wrong."""

    kind: Literal["erase"]
    marker: Name
    first: Frame
    last: Frame


class Click(Said):
    """A place in an image, px."""

    camera: Name
    u: Number
    v: Number


class PutAct(Said):
    """A marker is here: a place, mm, or clicks in two images or more. `sd` mm per axis."""

    kind: Literal["put"]
    marker: Name
    frame: Frame
    xyz: Place | None = None
    clicks: Annotated[list[Click], Field(max_length=64)] = []
    sd: Annotated[float, Field(gt=0, le=1e6)] | None = None


class GapAct(Said):
    """How gaps in these frames are filled: a method, "best" or "open"."""

    kind: Literal["gap"]
    marker: Name
    first: Frame
    last: Frame
    method: Name


class SmoothAct(Said):
    """A stretch is low-pass filtered, by a Butterworth filter where no function is said."""

    kind: Literal["smooth"]
    marker: Name
    first: Frame
    last: Frame
    cutoff_hz: Annotated[float, Field(gt=0, le=1e6)]
    function: SmoothingFunction = "butterworth"


class ImageAct(Said):
    """Where a marker is in one image; or that the image there is no marker's, where `marker` is null."""

    kind: Literal["image"]
    camera: Name
    frame: Frame
    u: Number
    v: Number
    marker: Name | None


class ReviewAct(Said):
    """A verdict on a problem: it is right as it is, or was wrong. Nobody is asked again."""

    kind: Literal["review"]
    problem: Name
    right: bool


class AlternativeAct(Said):
    """An alternative of a problem, by its key."""

    kind: Literal["alternative"]
    problem: Name
    key: Name


class TrimAct(Said):
    """All markers begin and end at these frames."""

    kind: Literal["trim"]
    first: Frame
    last: Frame


class FinishAct(Said):
    """What is unnamed is dropped and the rest is trimmed to common frames: those given, or those of all markers."""

    kind: Literal["finish"]
    first: Frame | None = None
    last: Frame | None = None


class TrackAgainAct(Said):
    """Tracks are made again with all that was said as facts."""

    kind: Literal["track_again"]


class EventAct(Said):
    """An event, s from frame 1 of the recording."""

    kind: Literal["event"]
    label: Name
    side: Annotated[str, Field(max_length=64)]
    time_s: Number


class UndoAct(Said):
    """An entry counts no longer; the last that counts, where null."""

    kind: Literal["undo"]
    of: int | None = None


class RedoAct(Said):
    """The last undo is taken back."""

    kind: Literal["redo"]


class SignAct(Said):
    """Somebody stands for the trial as it is."""

    kind: Literal["sign"]


OneEdit = Annotated[
    ClaimAct | ExchangeAct | SidesAct | EraseAct | PutAct | GapAct | SmoothAct | ImageAct | ReviewAct | AlternativeAct
    | TrimAct | EventAct,
    Field(discriminator="kind"),
]  # fmt: skip


class SeveralAct(Said):
    """Several edits in one entry, undone together; each is of the trial as it is before all of them."""

    kind: Literal["several"]
    acts: Annotated[list[OneEdit], Field(min_length=1, max_length=500)]


Act = Annotated[
    ClaimAct | ExchangeAct | SidesAct | EraseAct | PutAct | GapAct | SmoothAct | ImageAct | ReviewAct | AlternativeAct
    | TrimAct | FinishAct | TrackAgainAct | EventAct | UndoAct | RedoAct | SignAct | SeveralAct,
    Field(discriminator="kind"),
]  # fmt: skip
