"""What the server and the page of the studio say of editing: problems, acts, gaps, names, history.

Units and frames are those of `messages`.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ...data.problems import Action, ProblemKind
from .acts_messages import Act
from .messages import Message, TrialHeader, Vector

OutcomeWord = Literal["held", "thin", "moot", "overruled", "orphan"]


class Alternative(Message):
    """One way to settle a problem; `act` is null where nothing is to be said.

    `probability` that it is the right one; `cost` expected, mm times samples, where it is taken; `jump_mm` how far
    paths are from where their motion leads; `images` that a marker there explains.
    """

    key: str
    action: Action
    words: str
    consequence: str = ""
    probability: float | None = None
    cost: float | None = None
    jump_mm: float | None = None
    images: int | None = None
    act: Act | None = None


class Problem(Message):
    """A probable error: `wrong` its probability, `at_stake` samples that are then wrong, by `cost_mm` each.

    `cost` is expected, mm times samples; `frame` the one to look at; `images` the cameras that see most of it.
    """

    id: str
    kind: ProblemKind
    words: str
    tracks: list[str]
    first: int
    last: int
    frame: int
    wrong: float | None = None
    at_stake: int = 0
    cost_mm: float | None = None
    cost: float = 0.0
    alternatives: list[Alternative] = Field(default=[])
    images: list[str] = Field(default=[])


class Problems(Message):
    """Problems, the one whose looking at saves most first.

    The first `worth_looking` are worth a look (the stop rule); `errors` are expected now, `errors_left` when these are
    put right.
    """

    problems: list[Problem]
    errors: float
    errors_left: float
    worth_looking: int
    head: str


class Outcome(Message):
    """What became of an edit."""

    kind: str
    words: str
    outcome: OutcomeWord
    share: float
    samples: int
    reason: str = ""


class ActBody(Message):
    """An act on what the page has seen, whose head it names."""

    head: str
    act: Act
    why: Annotated[str, Field(max_length=2000)] = ""


class PathsPart(Message):
    """Some trajectories in some frames: base64 of the columns as `/paths` has them."""

    names: list[str]
    first_frame: int
    n_frames: int
    xyz: str
    sd: str
    origin: str


class ChangedPaths(PathsPart):
    """Trajectories that an act changed, in the frames in which they differ from `bases`.

    A base is the name of a trajectory as it was before the act; where that is empty, it has no sample in other frames.
    """

    bases: list[str]


class ActDone(Message):
    """An act that stands in the journal: what changed since the head that the page had seen.

    `paths` are those that changed, with chosen fills; null where they are many or still computed: ask for them.
    """

    entry: int
    outcomes: list[Outcome]
    head: str
    changed: list[str] = Field(description="Trajectories that are new or have other samples.")
    removed: list[str]
    paths: ChangedPaths | None = None
    header: TrialHeader


class PreviewBody(Message):
    """An act that is only looked at."""

    act: Act


class Join(Message):
    """How well two pieces go together: frames both have, frames between, mm apart, mm/s of the jump."""

    overlap: int
    gap: int
    off_mm: float
    sd_mm: float
    deviations: float
    speed_mm_s: float
    connectable: bool


class Preview(Message):
    """What an act would give."""

    outcomes: list[Outcome]
    changed: list[str]
    removed: list[str]
    paths: PathsPart
    join: Join | None = None


class MethodError(Message):
    """The mean error expected of a method; null where it has no prediction."""

    method: str
    expected_mm: float | None


class GapRow(Message):
    """A gap: the best method known and its expected error, null until it was judged; `choice` is what a person chose.

    `cameras_alone` saw the marker in it while no other camera did.
    """

    marker: str
    first: int
    last: int
    frames: int
    method: str | None = None
    expected_mm: float | None = None
    others: list[MethodError] = Field(default=[])
    cameras_alone: list[str] = Field(default=[])
    state: Literal["not judged", "fillable", "above limit", "open", "chosen", "no way"]
    choice: str | None = None
    words: str = ""


class Gaps(Message):
    """All gaps of named markers; `pending` while some are judged: ask again."""

    gaps: list[GapRow]
    limit_mm: float
    pending: bool
    head: str


class Candidate(Message):
    """A way to fill a gap: places (n, 3) mm, and the standard deviation of each axis, null where unknown."""

    method: str
    expected_mm: float | None
    xyz: list[Vector]
    sd: list[Vector] | None


class GapCandidates(Message):
    """All ways to fill one gap, best first; `best` is the method that filling itself would take, null until known.

    `pending` while better ones are computed: ask again.
    """

    marker: str
    first: int
    last: int
    candidates: list[Candidate]
    best: str | None = None
    pending: bool = False
    head: str


class Proposal(Message):
    """What automatic labelling says of a track."""

    track: str
    name: str | None
    probability: float
    runner_up: str | None
    state: Literal["sure", "unsure", "unknown"]


LinkState = Literal["steady", "stretched", "bends", "unknown"]


class LinkFound(Message):
    """A link as it is in the trial, mm.

    `state`: `stretched` where it varies more than its segment does, `bends` over a joint, `unknown` in too few frames.
    """

    a: str
    b: str
    mean_mm: float | None
    sd_mm: float | None
    stated_mm: float | None
    state: LinkState


class MarkerSetChoice(Message):
    """A marker set that may be chosen; `there` of its markers are in the trial by name, `worn`: it is chosen."""

    name: str
    markers: int
    there: int
    description: str
    worn: bool


class MarkerSetSaid(Message):
    """The marker set that the subject wears; null for none."""

    name: Annotated[str, Field(max_length=255)] | None


class Labels(Message):
    """Names of tracks; `sides` says where left and right cannot be told, `words` why nothing is proposed.

    `can_ask` says that names are proposed when they are asked for; `by` is the file by which they then are, and `known`
    are all markers of that file.
    """

    proposals: list[Proposal]
    links: list[LinkFound]
    sides: str = ""
    words: str = ""
    can_ask: bool = False
    by: str = ""
    known: list[str]
    head: str


class HistoryRow(Message):
    """An entry of the journal; `hash` is the head when it was the last, `short` are its words where it says much."""

    id: int
    at: str
    by: str
    why: str
    version: str
    hash: str
    kinds: list[str]
    words: str
    short: str
    undone: bool
    signed: bool
    outcome: OutcomeWord | None
    outcomes: list[Outcome]


class Fault(Message):
    """A line of the journal that is damaged."""

    line: int
    words: str


class History(Message):
    """All that was said of a trial, first to last."""

    entries: list[HistoryRow]
    faults: list[Fault]
    head: str


class IdentityChange(Message):
    """Samples that have another name in the later version."""

    before: str
    after: str
    first: int
    last: int
    samples: int


class SampleChange(Message):
    """Samples of a marker that were added, erased or moved, by at most so much."""

    marker: str
    what: Literal["added", "erased", "moved"]
    first: int
    last: int
    samples: int
    max_mm: float | None


class FillChange(Message):
    """A gap that is filled otherwise: by these ways, null where nobody has said how."""

    marker: str
    first: int
    last: int
    before: str | None
    after: str | None


class Difference(Message):
    """Two versions of a trial, by the entry that each goes up to; 0 is before all edits."""

    of: int
    other: int
    identities: list[IdentityChange]
    samples: list[SampleChange]
    fills: list[FillChange]
