"""Probable errors of a trial's paths, each with its probability: changes of identity, spikes, ghosts, loose pieces."""

from .changes import Change, changes
from .ghosts import Ghost, ghosts
from .leaps import Leap, leaps
from .paths import Paths
from .pieces import Piece, pieces
from .places import Partner, Place, places
from .probability import name_probability
from .spikes import Spike, spikes

__all__ = [
    "Change",
    "Ghost",
    "Leap",
    "Partner",
    "Paths",
    "Piece",
    "Place",
    "Spike",
    "changes",
    "ghosts",
    "leaps",
    "name_probability",
    "pieces",
    "places",
    "spikes",
]
