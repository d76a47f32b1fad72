"""Probable errors of a trial's paths, each with its probability: changes of identity, spikes, ghosts, loose pieces,
samples that nobody measured, and what happened to all paths at once."""

from .at_once import Moment
from .breaks import Break, BreakKind, breaks
from .changes import Change, Evidence, changes
from .fillings import Filling, fillings
from .ghosts import Ghost, ghosts
from .leaps import Leap, leaps
from .paths import Paths
from .pieces import Piece, pieces
from .places import Partner, Place, Told, places
from .probability import in_trial, name_probability
from .spikes import Spike, spikes
from .unbroken import unbroken

__all__ = [
    "Break",
    "BreakKind",
    "Change",
    "Evidence",
    "Filling",
    "Ghost",
    "Leap",
    "Moment",
    "Partner",
    "Paths",
    "Piece",
    "Place",
    "Spike",
    "Told",
    "breaks",
    "changes",
    "fillings",
    "ghosts",
    "in_trial",
    "leaps",
    "name_probability",
    "pieces",
    "places",
    "spikes",
    "unbroken",
]
