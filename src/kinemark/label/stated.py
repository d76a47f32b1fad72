"""Names that a person stated of tracks: facts, whatever the distances say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..data import Trajectories
from .labels import Labels, State


def with_stated(labels: Labels, tracks: Trajectories, stated: Mapping[str, str | None]) -> Labels:
    """The labels with what was stated; another track that has the same name at the same time loses it.

    Args:
        labels: of the tracks. tracks: in the same order.
        stated: track → marker; None where it is no marker.
    """
    names, state = list(labels.names), list(labels.state)
    p, margin = labels.probability.copy(), labels.margin.copy()
    seen = np.isfinite(tracks.xyz[..., 0])
    at = {track: tracks.names.index(track) for track in stated if track in tracks.names}
    for track, t in at.items():
        for other in range(len(names)):
            taken = other not in at.values() and names[other] is not None and names[other] == stated[track]
            if taken and (seen[other] & seen[t]).any():
                names[other], state[other], p[other], margin[other] = None, "unknown", 0.0, np.nan
    for track, t in at.items():
        name = stated[track]
        said: State = "unknown" if name is None else "sure"
        names[t], state[t], p[t], margin[t] = name, said, float(name is not None), np.nan if name is None else np.inf
    return replace(labels, names=tuple(names), state=tuple(state), probability=p, margin=margin)
