"""What the figures of a trial are made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..data import Detections, Rig, Tracks, Trajectories
from ..track.simultaneous import AmbiguousDecision
from .cameras import AsGiven


@dataclass(frozen=True, slots=True)
class AboutTrial:
    """Which recording it is.

    Attributes:
        session: its name. trial: its name.
        first_frame: number in the recording of the first frame of the detections; that of the trajectories where None.
        identity: the plain data of an `Identity`; None where nobody says whose recording it is.
    """

    session: str
    trial: str
    first_frame: int | None = None
    identity: Mapping[str, str] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class TrialRecords:
    """What was measured in a trial.

    Attributes:
        rig: the cameras that the trial was reconstructed with; it must know those of `detections`.
        detections: what the cameras saw, at the times of the frames; rows of `tracks.cloud.detection` count in it.
        tracks: all reconstructed points.
        trajectories: the markers as they leave the last stage.
        ambiguous_decisions: decisions of the tracker that were close.
        track_names: what the tracks of these became, empty for no marker; `*1`, `*2`, … where None.
        given: the cameras as they were calibrated and the detections as they were taken; None where `rig` is that.
    """

    rig: Rig
    detections: Detections
    tracks: Tracks
    trajectories: Trajectories
    ambiguous_decisions: Sequence[AmbiguousDecision] = ()
    track_names: Sequence[str] | None = None
    given: AsGiven | None = None
