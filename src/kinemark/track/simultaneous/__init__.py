"""Matching and tracking at once: from detections straight to tracks."""

from ..two_cameras.former_two_cameras import FormerTwoCameras
from .diagnosis.ambiguous import AmbiguousDecision, ambiguous_decisions, track_with_decisions
from .diagnosis.diagnostics import diagnose
from .diagnosis.diagnostics_of_points import diagnose_points
from .diagnosis.diagnostics_of_tracks import diagnose_tracks
from .simultaneous_method import Simultaneous
from .simultaneous_tracking import track_simultaneously
from .track_detections import track_detections
from .tracker import TrackingResult

__all__ = [
    "AmbiguousDecision",
    "FormerTwoCameras",
    "Simultaneous",
    "TrackingResult",
    "ambiguous_decisions",
    "diagnose",
    "diagnose_points",
    "diagnose_tracks",
    "track_detections",
    "track_simultaneously",
    "track_with_decisions",
]
