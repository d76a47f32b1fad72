"""Matching and tracking at once: from detections straight to tracks."""

from .doubts import Doubt, doubts, follow_with_doubts
from .former import FormerTwoCameras
from .method import Simultaneous
from .methods import FOLLOWERS, follow
from .noticed import noticed
from .others import noticed_of
from .simultaneous import Followed, followed

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
