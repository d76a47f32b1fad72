"""What a person said of a trial, applied to it: identities by witnesses, then values, then what the end shall be."""

from .anchors import anchored
from .connect import Connection, connection
from .difference import Changed, Difference, Renamed, difference
from .replay import Edited, Reviewed, cropped, replay
from .witnesses import stretch_of

__all__ = [
    "Changed",
    "Connection",
    "Difference",
    "Edited",
    "Renamed",
    "Reviewed",
    "anchored",
    "connection",
    "cropped",
    "difference",
    "replay",
    "stretch_of",
]
