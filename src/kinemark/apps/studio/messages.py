"""What the server and the page of the studio say to each other: the one truth of both.

Frames are numbers in the recording, both ends included. mm, px, s, Hz. What is not known is null, never NaN.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from ...data.problems import Action, ProblemKind
from .acts_messages import Act

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]
TrialState = Literal["not run", "tracked", "filled", "done", "signed", "failed", "stale"]
View = Literal["edited", "before", "filled"]
Column = Literal["xyz", "sd", "origin", "cov", "residual", "cameras"]
OutcomeWord = Literal["held", "thin", "moot", "overruled", "orphan"]


class Message(BaseModel):
    """A record of the contract; nothing besides its fields is understood."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Refusal(Message):
    """Why something was not done; `head` where the journal has gone on since."""

    words: str
    head: str | None = None


class Last(Message):
    """Who spoke last of a trial, and when: UTC, ISO 8601."""

    by: str
    at: str


class TrialCard(Message):
    """A trial on Home. `markers` counts trajectories, `named` those with a marker's name; `words` say why it failed."""

    id: str
    name: str
    frames: int | None = None
    rate: float | None = None
    markers: int | None = None
    named: int | None = None
    state: TrialState
    verdict: str = ""
    problems: int | None = None
    edits: int = 0
    last: Last | None = None
    words: str = ""


class SessionCard(Message):
    """A session on Home; `words` where it cannot be read."""

    id: str
    title: str
    folder: str
    trials: list[TrialCard]
    words: str = ""


class Home(Message):
    """All that may be opened."""

    sessions: list[SessionCard]
    files: list[TrialCard]
    version: str
    by: str


class Dropped(Message):
    """A file that was kept: its id, and what was odd in it."""

    id: str
    words: list[str] = []


class TrackRow(Message):
    """A trajectory: its frames with samples, and how sure automatic labelling was of its name."""

    name: str
    named: bool
    first: int | None
    last: int | None
    samples: int
    probability: float | None = None
    runner_up: str | None = None


class CameraRow(Message):
    """A camera: x_cam = R X + t; K and distortion (k1 k2 p1 p2 k3) lead to px; (0, 0) is the first pixel's centre."""

    name: str
    width: int
    height: int
    centre: Vector
    R: Matrix
    t: Vector
    K: Matrix
    distortion: tuple[float, float, float, float, float]


class Tile(Message):
    """Where a camera's image is in the mosaic, px; image px u is at x + (u + ½) · width / camera width."""

    camera: str
    x: int
    y: int
    width: int
    height: int


class Mosaic(Message):
    """The layout of the mosaics of a trial."""

    width: int
    height: int
    tiles: list[Tile]


class Link(Message):
    """Two markers of one segment, their distance and its standard deviation as the marker set states them, mm."""

    a: str
    b: str
    length_mm: float | None = None
    spread_mm: float | None = None


class MarkerSetRow(Message):
    """A marker set; places are forward, left, up in shares of height; faces are the views of the figure."""

    name: str
    names: list[str]
    places: dict[str, Vector]
    faces: dict[str, Literal["front", "back", "both"]]
    meaning: dict[str, str]
    links: list[Link]
    pairs: list[tuple[str, str]]


class EventRow(Message):
    """An event, s from frame 1 of the recording."""

    label: str
    side: str
    time_s: float


class TrialHeader(Message):
    """All of a trial but its samples.

    `trim` and `named_only` say what is left in the end; `undo` and `redo` the entries that these would take back;
    `why_asked` that every act wants a reason; `session` is null for a file.
    """

    id: str
    name: str
    session: str | None
    rate: float
    first_frame: int
    n_frames: int
    tracks: list[TrackRow]
    cameras: list[CameraRow]
    volume: tuple[Vector, Vector] | None
    marker_set: MarkerSetRow | None
    events: list[EventRow]
    trim: tuple[int, int]
    named_only: bool
    head: str
    edits: int
    undo: int | None
    redo: int | None
    version: str
    by: str
    has_images: bool
    has_detections: bool
    mosaic: Mosaic | None
    methods: list[str]
    last: Last | None = None
    stale: str = ""
    """Why what is shown is not what a run would give now; empty where it is."""


class PathsHeader(Message):
    """What the body of `/paths` holds, one column after the other, little-endian: in header `X-Kinemark-Paths`.

    xyz float32 [m, n, 3] mm; sd float32 [m, n] mm, of the largest axis; origin uint8 [m, n] (0 missing, 1 measured,
    2 filled, 3 edited); cov float32 [m, n, 6] mm² (xx xy xz yy yz zz); residual float32 [m, n] mm; cameras uint8
    [m, n], how many saw it. `pending`: chosen fills are still computed; ask again.
    """

    view: View
    names: list[str]
    first_frame: int
    n_frames: int
    columns: list[Column]
    head: str
    pending: bool = False


class DetectionsHeader(Message):
    """What the body of `/detections` holds: in header `X-Kinemark-Detections`.

    counts uint32 [c, n]; uv float32 [d, 2] px, sorted by camera, then frame; track int32 [d], row in `tracks` of the
    trial's header, −1 for none; validity uint8 [d], 0 where it went on to matching.
    """

    cameras: list[str]
    first: int
    last: int
    detections: int
    head: str


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
    alternatives: list[Alternative] = []
    images: list[str] = []


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


class ActDone(Message):
    """An act that stands in the journal: what changed since the head that the page had seen."""

    entry: int
    outcomes: list[Outcome]
    head: str
    changed: list[str] = Field(description="Trajectories that are new or have other samples; to be fetched again.")
    removed: list[str]
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


class PathsPart(Message):
    """Some trajectories in some frames: base64 of the columns as `/paths` has them."""

    names: list[str]
    first_frame: int
    n_frames: int
    xyz: str
    sd: str
    origin: str


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
    others: list[MethodError] = []
    cameras_alone: list[str] = []
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


class LinkFound(Message):
    """A link as it is in the trial, mm; `stretched` where it varies more than a segment does."""

    a: str
    b: str
    mean_mm: float | None
    sd_mm: float | None
    stated_mm: float | None
    stretched: bool


class Labels(Message):
    """Names of tracks; `sides` says where left and right cannot be told, `words` why nothing is proposed."""

    proposals: list[Proposal]
    links: list[LinkFound]
    sides: str = ""
    words: str = ""
    head: str


class HistoryRow(Message):
    """An entry of the journal; `hash` is the head when it was the last."""

    id: int
    at: str
    by: str
    why: str
    version: str
    hash: str
    kinds: list[str]
    words: str
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


class Difference(Message):
    """Two versions of a trial, by the entry that each goes up to; 0 is before all edits."""

    of: int
    other: int
    identities: list[IdentityChange]
    samples: list[SampleChange]


class EpipolarLine(Message):
    """Where another camera may see what one sees: points (u, v) px."""

    camera: str
    points: list[tuple[float, float]]


class RunBody(Message):
    """How far to run a trial."""

    to: str = "write"


class Job(Message):
    """A run of a trial; progress is of the stage, from 0 to 1."""

    kind: Literal["job"] = "job"
    id: str
    trial: str
    state: Literal["running", "done", "failed", "cancelled"]
    stage: str = ""
    progress: float | None = None
    seconds_left: float | None = None
    words: str = ""


class TrialMoved(Message):
    """The journal of a trial has gone on, or it was run."""

    kind: Literal["trial"] = "trial"
    trial: str
    head: str


class Live(Message):
    """What comes over `/api/live`, one a message."""

    said: Annotated[Job | TrialMoved, Field(discriminator="kind")]


class ExportBody(Message):
    """The format that a trial is written in, by its ending."""

    ending: Annotated[str, Field(max_length=8)] = ".c3d"


class Exported(Message):
    """The name of the file that was written, and what it cannot hold."""

    name: str
    words: list[str] = []
