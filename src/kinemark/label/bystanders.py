"""Markers that nobody named, worn in the static trial as well: they tell which of two neighbours bears a name.

By the set alone a marker 60 mm beside the thigh's could be the thigh's: the set's distances from the knee and the
pelvis change in a walk by as much. Where the static trial has both, one with a name and one without, only one of the
two ways round has the pair as it was there. So a trial that was labelled by the set is labelled once more by the set
and these, its surest names being facts: with facts a search among twice as many labels, many of them in pairs of left
and right that no name tells apart, cannot turn a body about. All other names are those of the second labelling, as sure
as the surer of both where they agree; what it calls a marker that nobody named has no name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from ..data import Trajectories
from ..data.array_types import Bools
from .displaced import markers_beside
from .label import label
from .labels import Labels, State
from .template import Template

T = TypeVar("T")
FACT = 0.999
"""Probability from which on a name is a fact for the second labelling; chosen by three of 21 simulated trials: all ten
names that were sure and wrong beside many nameless markers had less, and were right then."""
FEWEST = 8
"""Facts without which no second labelling is tried; chosen: a limb alone can lie on another."""


def among_bystanders(
    tracks: Trajectories,
    labels: Labels,
    template: Template,
    wider: Template,
    *,
    method: Any = None,
    stated: Mapping[str, str | None] = MappingProxyType({}),
) -> Labels:
    """Labels of tracks, those that were not surest by what stands beside them.

    Args:
        tracks: that were labelled. labels: of them, by the template.
        template: of the markers of the set. wider: of these and of others, as `from_set.static_bystanders` has it.
        method: of `label.LABEL`. stated: names that a person stated of tracks.
    """
    sure = labels.probability >= FACT
    known = {path.name: name for path, name, yes in zip(tracks, labels.names, sure, strict=True) if yes}
    missing = set(template.names) - {name for name in known.values() if name is not None}
    settled = not missing and "unsure" not in labels.state
    if labels.refused is not None or labels.undecided is not None or settled or len(known) < FEWEST:
        return labels
    found = label(tracks, wider, method=method, stated={**known, **stated})
    if found.refused is not None or found.undecided is not None:
        return labels
    new = [name if name in template.names else None for name in found.names]
    none = np.array([name is None for name in new], bool)
    agreed = np.array([name is not None and name == was for name, was in zip(new, labels.names, strict=True)], bool)
    kept = sure | agreed & (labels.probability >= found.probability)
    state: tuple[State, ...] = tuple("unknown" if no else word for no, word in zip(none, found.state, strict=True))
    runner_up = [name if name in template.names else None for name in found.runner_up]
    merged = replace(
        labels,
        names=_where(kept, labels.names, new),
        probability=np.where(kept, labels.probability, np.where(none, 0.0, found.probability)),
        state=_where(kept, labels.state, state),
        runner_up=_where(kept, labels.runner_up, runner_up),
        margin=np.where(kept, labels.margin, np.where(none, np.nan, found.margin)),
        against=_where(kept, labels.against, found.against),
    )
    return replace(merged, displaced=markers_beside(tracks, merged, template, stated))


def _where(kept: Bools, old: Sequence[T], new: Sequence[T]) -> tuple[T, ...]:
    """The old of what is kept, else the new."""
    return tuple(a if yes else b for yes, a, b in zip(kept, old, new, strict=True))
