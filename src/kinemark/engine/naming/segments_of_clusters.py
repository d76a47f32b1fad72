"""A marker set from what `[gait.clusters]` says: which markers sit on one segment.

A static trial alone does not tell which distances keep. A session that has clusters has said it: each cluster keeps its
shape, and so do, to skin, the landmarks of its segment, which the walks may lack.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...data import MarkerSet
from ...gait.clusters import SEGMENTS, landmarks_of

RIGIDITY = 0.03
"""Standard deviation of the distances on a segment, as a share of each; chosen: thigh's and shank's of the shipped
sets."""


def set_of_clusters(
    clusters: Mapping[str, Sequence[str]], shown: Sequence[str], *, markers: Mapping[str, str] | None = None
) -> MarkerSet | None:
    """All markers of a static trial, those of a segment together; None where the trial shows no cluster.

    Args:
        clusters: markers by segment, one of `gait.clusters.SEGMENTS`. shown: names in the static trial.
        markers: the recording's names by the gait model's, where they differ.
    """
    named = [name for name in shown if not name.startswith("*")]
    own = {} if markers is None else markers
    segments = {}
    for segment in SEGMENTS:
        wanted = [*clusters.get(segment, ()), *(own.get(name, name) for name in landmarks_of(segment))]
        if len(there := [name for name in dict.fromkeys(wanted) if name in named]) > 1:
            segments[segment] = tuple(there)
    if not any(set(cluster) <= set(named) for cluster in clusters.values()):
        return None
    return MarkerSet(
        tuple(named), segments, name="of the session's clusters", rigidity=dict.fromkeys(segments, RIGIDITY)
    )
