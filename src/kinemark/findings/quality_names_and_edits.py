"""What quality.json holds of names and edits."""

from __future__ import annotations

from typing import Literal, NotRequired

from typing_extensions import TypedDict

from .quality_types import Count, Number, Share, documented


@documented
class NamedMarkerData(TypedDict):
    """The name of a marker: "sure", "unsure", "missing", or "stated" by the recording."""

    name: str
    samples: Count
    probability: Share
    """Mean over its samples."""
    state: str
    runner_up: str | None
    """Of its least certain piece."""
    pieces: Count


@documented
class UnsureData(TypedDict):
    """A track whose name is not sure, so that it has none; frames from 0."""

    name: str
    probability: Share
    runner_up: str | None
    first_frame: int
    last_frame: int
    samples: Count


@documented
class DisplacedData(TypedDict):
    """A named marker that sits beside its place in the template: put on anew, or another one."""

    name: str
    off_mm: Number


@documented
class SwitchData(TypedDict):
    """A track that went over from one marker to another; the first frame of the second, from 0."""

    frame: Count
    before: str
    after: str


@documented
class LabelsData(TypedDict):
    """How the markers were named."""

    sources: list[str]
    """Files and trials that the template was learnt from."""
    fit: Number
    """Score as a share of what the template scores on its own data."""
    placed_share: Share
    sure_share: Share
    refused: bool
    markers: list[NamedMarkerData]
    unsure: list[UnsureData]
    displaced: NotRequired[list[DisplacedData]]
    ghosts_removed: NotRequired[Count]
    second_pass: NotRequired[dict[str, Count]]
    """Points that the named body found, renamed, joined and put_aside, and ghosts, tracks that it dropped."""
    stated: NotRequired[Count]
    """Tracks whose name a person stated."""
    claimed: NotRequired[Count]
    """Those of them that were claimed in the journal of edits."""
    switches: NotRequired[list[SwitchData]]
    """Where tracks were cut, as they went over from one marker to another."""
    subjects: NotRequired[list[str]]
    """Several, whose names stand before those of their markers, as in `A:LKNE`; those of whom something is known."""
    undecided: NotRequired[list[list[str]]]
    """Pairs of subjects that cannot be told apart, so that none of their names is sure."""


@documented
class EditData(TypedDict):
    """One edit of a journal, and what became of it."""

    entry: int
    """Number of its entry in the journal."""
    edit: str
    """Its kind."""
    markers: list[str]
    frames: list[int]
    """First and last that it is about, numbers in the recording; 0, 0 where it is about none."""
    outcome: Literal["held", "thin", "moot", "overruled", "orphan"]
    """It stands; it stands on few of its witnesses; nothing was left to do; a later one says otherwise; it no longer
    finds its place."""
    share: Share
    """Of its witnesses that were found."""
    samples: Count
    reason: str
    """Why it does not stand; else empty."""
