"""Names of a session's markers: by whose trials, in which order, and what is told of them."""

from .earlier import Earlier, before, template_files_key
from .named_tracks import FILES, NamedTracks, load_named, save_named
from .naming import name_tracks, session_template

__all__ = [
    "FILES",
    "Earlier",
    "NamedTracks",
    "before",
    "load_named",
    "name_tracks",
    "save_named",
    "session_template",
    "template_files_key",
]
