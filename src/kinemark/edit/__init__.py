"""What a person said of a trial, applied to it: identities by witnesses, then values, then what the end shall be."""

from .connect import Connection, connection
from .replay import Edited, Reviewed, cropped, replay
from .witnesses import stretch_of

__all__ = ["Connection", "Edited", "Reviewed", "connection", "cropped", "replay", "stretch_of"]
