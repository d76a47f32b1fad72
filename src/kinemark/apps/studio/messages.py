"""What the server and the page of the studio say to each other: the one truth of both.

Frames are numbers in the recording, both ends included. mm, px, s, Hz. What is not known is null, never NaN.
What is said of editing is in `edit_messages`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]
TrialState = Literal["not run", "tracked", "filled", "done", "signed", "failed", "stale"]
View = Literal["edited", "before", "filled"]
Column = Literal["xyz", "sd", "origin", "cov", "residual", "cameras"]


class Message(BaseModel):
    """A record of the contract; nothing besides its fields is understood."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @classmethod
    def like(cls, record: object, **other: Any) -> Self:
        """What a record has by the names of the fields, and other fields as they are given."""
        own = {name: getattr(record, name) for name in cls.model_fields if name not in other and hasattr(record, name)}
        return cls(**own, **other)


class Refusal(Message):
    """Why something was not done; `head` where the journal has gone on since."""

    words: str
    head: str | None = None


class Last(Message):
    """Who spoke last of a trial, and when: UTC, ISO 8601."""

    by: str
    at: str


class TrialCard(Message):
    """A trial on Home. `markers` counts trajectories, `named` those with a marker's name; `words` say why it failed.

    `problems`: those that are worth a look, as Tracks lists them; None until they were looked for.
    """

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


class Standing(Message):
    """Whether a trial can be shown, and in words why not; `runs`: whether it can be run, as files cannot."""

    ready: bool
    words: str = ""
    runs: bool = True


class SessionCard(Message):
    """A session on Home; `words` where it cannot be read; `gait` whether its gait report is there, or may be made."""

    id: str
    title: str
    folder: str
    trials: list[TrialCard]
    words: str = ""
    gait: Literal["", "possible", "there"] = ""


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
    """A trajectory: its frames with samples, and how sure automatic labelling was of its name.

    `computed`: a point of a file that is no marker, but worked out of markers, as a joint's centre.
    """

    name: str
    named: bool
    first: int | None
    last: int | None
    samples: int
    probability: float | None = None
    runner_up: str | None = None
    computed: bool = False


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
    """The layout of the mosaics of a trial; `images` changes where a frame's number means other images."""

    width: int
    height: int
    tiles: list[Tile]
    images: str


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


class EventRow(Message):
    """An event, s from frame 1 of the recording."""

    label: str
    side: str
    time_s: float


class TrialHeader(Message):
    """All of a trial but its samples.

    `trim` and `named_only` say what is left in the end; `undo` and `redo` the entries that these would take back;
    `pairs` are left and right markers that are there; `session` and its id are null for a file.
    """

    id: str
    name: str
    session: str | None
    session_id: str | None
    rate: float
    first_frame: int
    n_frames: int
    tracks: list[TrackRow]
    cameras: list[CameraRow]
    volume: tuple[Vector, Vector] | None
    up: Vector
    """The axis of the world that goes up: of many files that is y."""
    marker_set: MarkerSetRow | None
    pairs: list[tuple[str, str]]
    one_sided: list[str]
    """Markers of which the other side is not there: they keep their names where left and right are exchanged."""
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


class EpipolarLine(Message):
    """Where another camera may see what one sees: points (u, v) px."""

    camera: str
    points: list[tuple[float, float]]


class RunBody(Message):
    """How far to run a trial."""

    to: str = "write"


class Job(Message):
    """A run of a trial, or the calibration of a session, whose id `trial` then is; progress is of the stage, 0 to 1."""

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
