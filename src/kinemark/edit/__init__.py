"""What a person said of a trial, applied to it: identities by witnesses, then values, then what the end shall be."""

from .replay import Edited, Reviewed, cropped, replay
from .witnesses import stretch_of

__all__ = ["Edited", "Reviewed", "cropped", "replay", "stretch_of"]
