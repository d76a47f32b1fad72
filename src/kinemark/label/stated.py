"""Names that a person stated of tracks: facts, whatever the distances say, by which others are found.

The search begins in frames with tracks of which a name was stated, and with these; they keep it in every sweep, and no
exchange of whole labels touches it. What is called so all through the trial is so, as one of its tracks is known.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..data import Trajectories
from ..data.array_types import Ints
from .labels import Labels, State
from .stretches import FREE, NO_MARKER

if TYPE_CHECKING:
    from .margin import Margins
    from .template import Template


def fixed_labels(tracks: Trajectories, template: Template, stated: Mapping[str, str | None]) -> Ints:
    """(T) as `Stretches.fixed`; a name that the template does not have is none of its markers."""
    number: dict[str | None, int] = {name: a for a, name in enumerate(template.names)}
    return np.array(
        [number.get(stated[name], NO_MARKER) if name in stated else FREE for name in tracks.names], np.int64
    )


def anchored(found: Margins, label: Ints, fixed: Ints) -> Margins:
    """Labels that were stated of a track are exchanged with no other."""
    known = np.isin(label, fixed[fixed >= 0])
    return found._replace(exchange=np.where(known, np.inf, found.exchange))


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
