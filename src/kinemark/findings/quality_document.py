"""What quality.json holds, declared as types: the JSON schema that is shipped, and the reference, follow from these.

Keys carry their units: `_px`, `_mm`, `_s`, `_hz`, `_frames`; a `_share` is from 0 to 1. What is not known is null.
Lengths without an axis in their name are `[x, y, z]`, images `[u, v]`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, NotRequired

from pydantic import Field
from typing_extensions import TypedDict

from ..data.finding import FindingStage, Grade, Severity
from ..track.simultaneous.diagnosis.ambiguous import DecisionKind, DecisionReason
from .quality_gaps import GapData
from .quality_names_and_edits import EditData, LabelsData
from .quality_types import Box, Count, Number, Pair, Point, Share, documented


@documented
class FindingData(TypedDict):
    """What was found, as values; `text` and `advice` are words for people and nothing reads them."""

    kind: str
    """Of the kinds in the reference; each has its own values."""
    severity: Severity
    stage: FindingStage
    """Where it arises."""
    cameras: list[str]
    markers: list[str]
    frames: list[Annotated[list[int], Field(min_length=2, max_length=2)]]
    """First and last frame, both included, of each stretch: numbers in the recording, as the words have them."""
    values: dict[str, Any]
    """Numbers by name; their units are declared with the kind."""
    text: NotRequired[str]
    advice: NotRequired[str]


@documented
class VerdictData(TypedDict):
    """The grade, the kinds of the findings that made it, and statements, the headline first."""

    grade: Grade
    findings: list[str]
    statements: list[FindingData]
    headline: NotRequired[str]
    """The first statement in words."""
    sentences: NotRequired[list[str]]
    """The other statements in words."""


@documented
class DecisionData(TypedDict):
    """A decision of the tracking that was close; frames from 0, and time from there."""

    kind: DecisionKind
    first_frame: int
    last_frame: int
    time_s: float
    trajectories: list[str]
    reason: DecisionReason
    values: dict[str, Number]
    text: NotRequired[str]


@documented
class RecordingData(TypedDict):
    """What was recorded."""

    first_frame: int
    """Its number in the recording: 1, or as `frames` of the session says; what counts from 0 is 0 there."""
    frames: Count
    rate_hz: float
    duration_s: Number


@documented
class RoomData(TypedDict):
    """How well the room is known that an L-frame gave: an error that all positions have in common.

    It is in no covariance of a position, and changes no distance and no angle between markers.
    """

    sd_median_mm: Number
    """Per axis, as all deviations here; over the calibration's volume."""
    sd_95_mm: Number
    sd_at_subject_mm: Number
    """Over the positions of this trial."""
    turn_sd_deg: Number
    centre_sd_mm: Number
    centre_mm: Point
    """Where the points lie that gave the room."""
    spread_mm: float
    covariance: list[list[float]]
    """Of a turn, rad, a shift, mm, and a growth, mm over `spread_mm`, all about `centre_mm`."""


@documented
class CalibrationData(TypedDict):
    """The calibration, and how it was judged where it was."""

    method: str
    cameras_not_used: list[str]
    verdict: NotRequired[VerdictData]
    findings: NotRequired[list[FindingData]]
    precision: NotRequired[dict[str, float | bool | None]]
    room: NotRequired[RoomData | None]


@documented
class VolumeData(TypedDict):
    """The control volume as given, and the box that the markers spanned."""

    given_mm: Box | None
    spanned_mm: Box | None
    samples_outside_given_share: Share


@documented
class DetectionsPerFrame(TypedDict):
    """Of one camera."""

    mean: Number
    min: Count | None
    max: Count | None


@documented
class CameraData(TypedDict):
    """One camera: what it is, what it saw, and how well it agrees with the others."""

    name: str
    size_px: Annotated[list[int], Field(min_length=2, max_length=2)] | None
    position_mm: Point
    focal_px: Pair
    calibration_residual_px: Number
    detections: Count
    detections_per_frame: DetectionsPerFrame
    frames_without_detection_share: Share
    used_share: Share
    """Distinct detections that a point refers to, over all."""
    used_of_valid_share: Share
    """The same over the valid ones."""
    standing_spots: Count
    """Places at which valid detections of no point stay while tracks move."""
    standing_at: list[Pair]
    """The mean of the detections at each of these places, px."""
    standing_share: Share
    """These detections over the valid ones."""
    fleeting_share: Share
    """Valid detections of no point near which the frames before and after show none, over the valid ones."""
    invalid: dict[str, Count]
    """Detections by the reason why they are not valid."""
    invalid_share: dict[str, Share]
    separated: Count
    """Detections that were separated from others they touched."""
    residual_median_px: Number
    residual_rms_px: Number
    residual_95_px: Number
    residual_quantiles_px: list[Number]
    """5, 25, 50, 75 and 95 %."""
    offset_px: Pair
    """Median of detection less reprojection."""
    residual_as_calibrated_px: Number
    """Median of what the same images have by the camera as it was calibrated, and as they were taken; null where the
    trial was reconstructed with that."""
    pixel_at_subject_mm: Number
    """What one pixel spans at the median depth of the camera's points."""


@documented
class PointsData(TypedDict):
    """Reconstructed points."""

    count: Count
    per_frame_mean: Number
    cameras_per_point: dict[str, Count]
    fewer_than_3_cameras_share: Share
    in_a_track_share: Share
    residual_median_px: Number
    residual_rms_px: Number
    residual_95_px: Number


@documented
class TracksData(TypedDict):
    """Tracks."""

    count: Count
    length_mean_frames: Number
    length_median_frames: Number
    off_course_share: Share
    """Points that leave the course of their track, in a frame, by more than half of the distance to another."""
    lengths_frames: list[Count]


@documented
class MarkerData(TypedDict):
    """One marker."""

    name: str
    samples: Count
    missing_samples: Count
    filled_samples: Count
    edited_samples: Count
    completeness_share: Share
    completeness_in_view_share: Share
    first_seen_s: Number
    last_seen_s: Number
    gaps: Count
    longest_gap_frames: Count
    longest_gap_s: float
    longest_fill_frames: Count
    sd_per_axis_mean_mm: Number
    sd_per_axis_95_mm: Number
    jitter_mm: Number
    """White noise of one axis that the path itself shows, whatever it moves."""
    travel_mm: Number
    """How far it goes: between the farthest of the medians of ten parts of its path."""
    residual_mean_mm: Number
    cameras_mean: Number


@documented
class TrajectoriesData(TypedDict):
    """All markers together, and each."""

    count: Count
    unlabelled: bool
    """Whether most are tracks without a marker's name."""
    markers_worn: Count
    markers_shown: Count
    """As many at least as the images of a frame show, of tracks without names: those of the camera with the fewest; 0
    where nothing is told."""
    samples: Count
    missing_samples: Count
    filled_samples: Count
    edited_samples: Count
    completeness_share: Share
    first_frame: int
    """Number in the recording of the frame from which `in_view_frames` counts: another one where edits trimmed."""
    in_view_frames: Annotated[list[int], Field(min_length=2, max_length=2)]
    """First frame in which the subject is in view, and the one after the last; from 0."""
    in_view_runs: list[Annotated[list[int], Field(min_length=2, max_length=2)]]
    """The same of each stretch, where it was away in between."""
    completeness_in_view_share: Share
    """Null also where so many images belong to no point that markers may be missing altogether."""
    completeness_of_found_share: Share
    """The same of the markers that were found, whatever is left over."""
    gaps: Count
    longest_gap_frames: Count
    longest_gap_s: float
    sd_per_axis_mean_mm: Number
    jitter_median_mm: Number
    """The white noise of one axis, of the middle marker."""
    steady_sd_mm: Number
    """What of `sd_per_axis_mean_mm` is not `jitter_median_mm`: errors that stay, as those of the calibration."""
    markers: list[MarkerData]


@documented
class StageTime(TypedDict):
    """Time of one stage."""

    stage: str
    time_s: float
    frames_per_s: Number


@documented
class TimingData(TypedDict):
    """Time of computing, in all without the calibration, which the session's trials share."""

    total_s: float
    frames_per_s: Number
    stages: list[StageTime]


@documented
class StepData(TypedDict):
    """How one stage was made."""

    stage: str
    method: str
    parameters: dict[str, Any]
    version: str
    input: str
    time_s: float


@documented
class FillingData(TypedDict):
    """What became of the gaps."""

    kinemark: str
    schema_version: int
    source: str
    method: str
    limit_mm: Number
    rate_hz: float
    frames: Count
    markers: Count
    gaps: Count
    filled: Count
    open: Count
    missing_samples: Count
    missing_after: Count
    beyond: Count
    """Samples before a marker's first and after its last."""
    replaced: Count
    suspicious: Count
    """Measured samples beside gaps that stand out from the marker's own motion and were kept."""
    expected_median_mm: Number
    expected_max_mm: Number
    unknown: Count
    """Filled gaps without an expected error."""
    by_method: dict[str, Count]
    never_seen: list[str]
    much_filled: list[str]
    far_away: Count
    """Samples farther than a kilometre from the others."""
    nameless_tracks: Count
    """Without a name beside markers with one: ghosts and left-over pieces, whose gaps are not filled."""
    nameless_gaps: Count
    computed_points: Count
    """With missing samples, that a program computed of markers; they stay as they are."""
    list: list[GapData]
    findings: list[FindingData]
    verdict: VerdictData


@documented
class DigitisingData(TypedDict):
    """What an operator was asked and answered."""

    questions: Count
    cameras: dict[str, dict[str, Any]]


@documented
class IdentityData(TypedDict):
    """Whose recording it is, and of which day; empty where nobody says it."""

    subject: str
    date: str
    """YYYY-MM-DD."""
    file_date: str
    """When the recording's files were last changed, YYYY-MM-DD, which copying may alter."""


@documented
class Quality(TypedDict):
    """How good a trial is: every figure of its report, in values and words."""

    kinemark: str
    """The version that wrote the file."""
    schema_version: Literal[1]
    session: str
    trial: str
    identity: IdentityData
    recording: RecordingData
    calibration: CalibrationData
    volume: VolumeData
    cameras: list[CameraData]
    points: PointsData
    tracks: TracksData
    trajectories: TrajectoriesData
    timing: TimingData
    steps: list[StepData]
    ambiguous_decisions: list[DecisionData]
    filling: FillingData | None
    """None where no gaps were to be filled."""
    labels: NotRequired[LabelsData]
    """Of sessions that name markers."""
    edits: NotRequired[list[EditData]]
    """What people said of the trial, in the order in which it was said."""
    digitising: NotRequired[DigitisingData]
    """Of trials that an operator digitised."""
    findings: list[FindingData]
    """What needs attention, the most severe first."""
    verdict: VerdictData
