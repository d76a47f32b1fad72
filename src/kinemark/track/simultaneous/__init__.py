"""Matching and tracking at once: from detections straight to tracks."""

from ..two_cameras.former_two_cameras import FormerTwoCameras
from .ambiguous import Doubt, doubts, follow_with_doubts
from .diagnostics import noticed
from .diagnostics_of_tracks import noticed_of
from .methods import FOLLOWERS, follow
from .simultaneous_method import Simultaneous
from .tracker import Followed, followed

__all__ = [
    "FOLLOWERS",
    "Doubt",
    "Followed",
    "FormerTwoCameras",
    "Simultaneous",
    "doubts",
    "follow",
    "follow_with_doubts",
    "followed",
    "noticed",
    "noticed_of",
]
