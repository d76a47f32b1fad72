"""Probable errors of a trial's paths, each with its probability: changes of identity, spikes, ghosts, loose pieces."""

from .changes import Change, changes
from .ghosts import Ghost, ghosts
from .paths import Paths
from .pieces import Piece, pieces
from .places import Place, places
from .spikes import Spike, spikes

__all__ = ["Change", "Ghost", "Paths", "Piece", "Place", "Spike", "changes", "ghosts", "pieces", "places", "spikes"]
