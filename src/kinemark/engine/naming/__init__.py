"""Names of a session's markers: by whose trials, in which order, and what is told of them."""

from .earlier import ABSENT, Earlier, before
from .named_tracks import FILES, NamedTracks, load_named, save_named

__all__ = ["ABSENT", "FILES", "Earlier", "NamedTracks", "before", "load_named", "save_named"]
