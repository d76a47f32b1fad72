"""A marker set from what `[gait.clusters]` says: which markers sit on one segment.

A static trial alone does not tell which distances keep. A session that has clusters has said it: each cluster keeps its
shape, and so do, to skin, the landmarks of its segment, which the walks may lack.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...data import MarkerSet
from ...data.marker_sides import without_subject
from ...data.model_markers import model_names
from ...gait.clusters import SEGMENTS, landmarks_of

RIGIDITY = 0.03
"""Standard deviation of the distances on a segment, as a share of each; chosen: thigh's and shank's of the shipped
sets."""


def set_of_clusters(
    clusters: Mapping[str, Sequence[str]], shown: Sequence[str], *, markers: Mapping[str, str] | None = None
) -> MarkerSet | None:
    """All markers of a static trial, those of a segment together; None where the trial shows no cluster.

    Args:
        clusters: markers by segment, one of `gait.clusters.SEGMENTS`, with the subject's name or without it.
        shown: names in the static trial.
        markers: the recording's names by the gait model's, of those that `model_names` does not know.
    """
    named = [name for name in shown if not name.startswith("*")]
    full = {without_subject(name): name for name in reversed(named)} | {name: name for name in named}
    if not any(full.keys() >= set(cluster) for cluster in clusters.values()):
        return None
    own = {**model_names(named), **(markers or {})}
    segments = {}
    for segment in SEGMENTS:
        wanted = [*clusters.get(segment, ()), *(own[name] for name in landmarks_of(segment) if name in own)]
        if len(there := dict.fromkeys(full[name] for name in wanted if name in full)) > 1:
            segments[segment] = tuple(there)
    return MarkerSet(tuple(named), segments, name="of clusters", rigidity=dict.fromkeys(segments, RIGIDITY))
