"""What a person said of a trial: edits, each a value, kept in a journal and applied again whenever the trial is.

All editing of identity is one operation, a claim: "this stretch of a path is the marker LKNE", or "is no marker".

    label, relabel, join          one claim; a span that ends is a cut
    exchange A and B from f on    two claims
    delete a ghost                one claim of no marker

A claim is anchored by what does not change when a trial is processed again, never by the number of a track: by
`FEWEST_WITNESSES` to `MOST_WITNESSES` moments of the path, each with its frame, its place and the images behind it. The
other edits name a marker and frames; most are anchored by some samples there as well (`where`), so that they are not
applied to what is called so, or numbered so, by now.

Frames are numbers in the recording, counted from 1 as `Trajectories.first_frame` counts them, so that they hold for a
trial that was cropped; first and last are both included. Pixels and mm are as everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, get_args

UNNAMED = "*"
"""What the names of tracks without a marker's name begin with."""

FEWEST_WITNESSES, MOST_WITNESSES, WITNESS_EVERY = 16, 64, 20
"""Of a stretch, from the first to the second number, one for so many of its samples: a path of minutes that another
tracker breaks into pieces has a witness on most of these. Chosen by studies/edits.py: with 16 in all 1200 frames of the
infrared footage 4 to 34 % of the samples got no name, with 64 1 to 21 %."""

SmoothingFunction = Literal["butterworth", "woltring", "moving_average"]
SMOOTHING: tuple[SmoothingFunction, ...] = get_args(SmoothingFunction)
"""Functions that smooth a stretch; the first is what journals mean that do not say one."""

BEST, OPEN = "best", "open"
"""Choices for a gap besides the name of a method: the least expected error, and nothing."""


class Witness(NamedTuple):
    """One moment of a path, as it was when somebody spoke of it.

    Attributes:
        frame: number in the recording.
        xyz: mm, in the world that the stretch names.
        images: camera, u, v, px; none where a file came without its images.
    """

    frame: int
    xyz: tuple[float, float, float]
    images: tuple[tuple[str, float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Stretch:
    """A piece of one marker's path in space and time.

    Attributes:
        first, last: frames that are spoken of; None where it follows the path as far as that goes.
        witnesses: of it, in the order of their frames.
        world: key of the cameras whose world the places are in; empty where there are none. In another world places
            say nothing, and images do.
    """

    first: int | None
    last: int | None
    witnesses: tuple[Witness, ...]
    world: str = ""

    def __post_init__(self) -> None:
        _check_span(self.first, self.last)
        if not self.witnesses:
            raise ValueError("a stretch has no witness, wanted at least one")
        frames = [witness.frame for witness in self.witnesses]
        if frames != sorted(set(frames)):
            raise ValueError("witnesses are not in the order of their frames, each once")
        for witness in self.witnesses:
            _check_numbers(witness.xyz, [n for _, *uv in witness.images for n in uv])

    def __hash__(self) -> int:
        """By one witness: an act looks up all stretches of a journal, and all of theirs would take most of its time."""
        return hash((self.first, self.last, self.witnesses[0], len(self.witnesses), self.world))


@dataclass(frozen=True, slots=True)
class Claim:
    """This stretch of path is the marker of this name, or no marker where it is None."""

    where: Stretch
    name: str | None
    kind: Literal["claim"] = "claim"

    def __post_init__(self) -> None:
        if self.name is not None:
            _check_marker(self.name)


@dataclass(frozen=True, slots=True)
class Erase:
    """Samples of a marker that are wrong: they become missing.

    Attributes:
        where: of them. whose: of the marker's other frames; None in older journals.
    """

    marker: str
    first: int
    last: int
    kind: Literal["erase"] = "erase"
    where: Stretch | None = None
    whose: Stretch | None = None

    def __post_init__(self) -> None:
        _check_marker(self.marker)
        _check_span(self.first, self.last)


@dataclass(frozen=True, slots=True)
class Put:
    """A marker's place in one frame, by hand, with the standard deviation of each axis, mm.

    Attributes:
        images: camera, u, v, px: where the place is in the images. In another world than `world` the place is worked
            out from them.
        where: samples of the marker beside the frame. whose: of all its frames; None in older journals.
    """

    marker: str
    frame: int
    xyz: tuple[float, float, float]
    sd_mm: float
    images: tuple[tuple[str, float, float], ...] = ()
    world: str = ""
    kind: Literal["put"] = "put"
    where: Stretch | None = None
    whose: Stretch | None = None

    def __post_init__(self) -> None:
        _check_marker(self.marker)
        _check_numbers(self.xyz, [n for _, *uv in self.images for n in uv])
        if not 0 < self.sd_mm < math.inf:
            raise ValueError(f"sd_mm is {self.sd_mm}, wanted above 0")


@dataclass(frozen=True, slots=True)
class GapChoice:
    """How a marker's gaps that lie in these frames, or reach into them, are filled.

    Attributes:
        method: the name of a method of filling; "best" for the least expected error; "open" for not at all. A gap that
            somebody chose a method for is filled whatever error is expected.
        where: samples of the marker beside these frames. whose: of all its frames; None in older journals.
    """

    marker: str
    first: int
    last: int
    method: str
    kind: Literal["gap"] = "gap"
    where: Stretch | None = None
    whose: Stretch | None = None

    def __post_init__(self) -> None:
        _check_marker(self.marker)
        _check_span(self.first, self.last)


@dataclass(frozen=True, slots=True)
class Smooth:
    """A stretch of a marker is low-pass filtered by a function, without lag; cutoff_hz: where 1/√2 is left.

    Attributes:
        where: samples of the stretch. whose: of the marker's other frames; None in older journals.
    """

    marker: str
    first: int
    last: int
    cutoff_hz: float
    kind: Literal["smooth"] = "smooth"
    function: SmoothingFunction = "butterworth"
    where: Stretch | None = None
    whose: Stretch | None = None

    def __post_init__(self) -> None:
        _check_marker(self.marker)
        _check_span(self.first, self.last)
        if self.function not in SMOOTHING:
            raise ValueError(f"function is {self.function!r}, wanted one of {', '.join(SMOOTHING)}")
        if not 0 < self.cutoff_hz < math.inf:
            raise ValueError(f"cutoff_hz is {self.cutoff_hz}, wanted above 0")


@dataclass(frozen=True, slots=True)
class ImagePoint:
    """Where a marker is in one image; or, where `marker` is None, that the image there is no marker's.

    Attributes:
        where: samples of the marker beside the frame. whose: of all its frames; None in older journals, and of no
            marker's image, which is its own witness.
    """

    camera: str
    frame: int
    u: float
    v: float
    marker: str | None
    kind: Literal["image"] = "image"
    where: Stretch | None = None
    whose: Stretch | None = None

    def __post_init__(self) -> None:
        if self.marker is not None:
            _check_marker(self.marker)
        _check_numbers([self.u, self.v])


@dataclass(frozen=True, slots=True)
class Verdict:
    """What somebody found of an ambiguous decision, who is not asked again.

    Attributes:
        decision: its kind, such as "swap". where: the stretches that it is about. right: whether it was right.
    """

    decision: str
    where: tuple[Stretch, ...]
    right: bool
    kind: Literal["verdict"] = "verdict"


@dataclass(frozen=True, slots=True)
class Trim:
    """All markers begin at one frame and end at one; where: samples at both ends, None in older journals."""

    first: int
    last: int
    kind: Literal["trim"] = "trim"
    where: Stretch | None = None

    def __post_init__(self) -> None:
        _check_span(self.first, self.last)


@dataclass(frozen=True, slots=True)
class DropUnnamed:
    """What has no marker's name is left out."""

    kind: Literal["drop_unnamed"] = "drop_unnamed"


@dataclass(frozen=True, slots=True)
class TrackAgain:
    """The tracks are made again, with all that was said before this, and stands, as facts for the tracker.

    Attributes:
        names: of markers that was spoken of and that nobody had claimed: whole paths, as they were called then.
    """

    names: tuple[Claim, ...] = ()
    kind: Literal["track_again"] = "track_again"


@dataclass(frozen=True, slots=True)
class AddEvent:
    """An event: what, which side, when, s from frame 1 of the recording.

    Attributes:
        where: samples then. rate: Hz, of their frames; None in older journals.
    """

    label: str
    side: str
    time_s: float
    kind: Literal["event"] = "event"
    where: Stretch | None = None
    rate: float | None = None

    def __post_init__(self) -> None:
        _check_numbers([self.time_s])
        if self.rate is not None and not 0 < self.rate < math.inf:
            raise ValueError(f"rate is {self.rate}, wanted above 0")


@dataclass(frozen=True, slots=True)
class Undo:
    """An earlier entry counts no longer; an undone undo counts no longer either, which is redo."""

    of: int
    kind: Literal["undo"] = "undo"


@dataclass(frozen=True, slots=True)
class Signed:
    """Somebody stands for the trial as it is with all entries up to the one whose line has this hash."""

    head: str
    kind: Literal["signed"] = "signed"


Edit = (
    Claim
    | Erase
    | Put
    | GapChoice
    | Smooth
    | ImagePoint
    | Verdict
    | Trim
    | DropUnnamed
    | TrackAgain
    | AddEvent
    | Undo
    | Signed
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Entry:
    """One act, a line of a journal: done, and undone, as a whole.

    Attributes:
        id: its number, which no other entry of the journal has.
        at: when, in UTC, ISO 8601. by: who. why: in their words; may be empty.
        version: of Kinemark.
        before: hash of the line before it; of nothing for the first.
        edits: what was said; an exchange is two claims.
    """

    id: int
    at: str
    by: str
    why: str
    version: str
    before: str
    edits: tuple[Edit, ...]


def counting(entries: Sequence[Entry]) -> tuple[Entry, ...]:
    """The entries that were not undone, in order; undoing ones are among them."""
    undone = set[int]()
    for entry in reversed(entries):
        if entry.id not in undone:
            undone.update(_undone_by(entry))
    return tuple([entry for entry in entries if entry.id not in undone])


def live(entries: Sequence[Entry]) -> tuple[Entry, ...]:
    """The entries that are applied, in order: neither undone nor undoing."""
    return tuple([entry for entry in counting(entries) if not _undone_by(entry)])


def _undone_by(entry: Entry) -> list[int]:
    """The entries that it takes back."""
    return [edit.of for edit in entry.edits if isinstance(edit, Undo)]


def facts_of(entries: Sequence[Entry]) -> tuple[Entry, ...]:
    """The entries that are facts for the tracker: that count, up to the last that says to track again; else none."""
    said = live(entries)
    last = [k for k, entry in enumerate(said) if any(isinstance(edit, TrackAgain) for edit in entry.edits)]
    return said[: last[-1] + 1] if last else ()


def is_named(name: str) -> bool:
    """Whether a trajectory has a marker's name."""
    return not name.startswith(UNNAMED)


def _check_marker(name: str) -> None:
    if not name or not is_named(name) or name != name.strip():
        raise ValueError(
            f"{name!r} is no name of a marker: it must not be empty, begin with * (the number of a track, which is "
            "another in the next run) or begin or end with a space. Claim a name for the track first"
        )


def _check_span(first: int | None, last: int | None) -> None:
    if first is not None and last is not None and first > last:
        raise ValueError(f"frames {first} to {last} are no stretch, wanted the first, then the last")


def _check_numbers(*values: Any) -> None:
    if not all(math.isfinite(n) for row in values for n in row):
        raise ValueError("a place or time is not finite")
