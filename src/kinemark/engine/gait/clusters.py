"""Which clusters carry segments of a subject's walks: those that were stated, and those that names tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...data.marker_sides import without_subject
from ...gait.clusters import Clusters, with_wands
from ...gait.usual_clusters import usual_clusters
from .settings import GaitSettings
from .walks import Recorded


def with_stated_clusters(static: Recorded, stated: Clusters) -> Recorded:
    """A standing trial with clusters whose markers are called as its file does, or as the gait model does.

    Args:
        static: whose markers of the model have the model's names. stated: markers by segment.
    """
    model = {without_subject(own): marker for marker, own in static.standard.known.items()}
    clusters = {
        segment: tuple(model.get(plain := without_subject(name), plain) for name in own)
        for segment, own in stated.items()
    }
    return replace(static, clusters=clusters)


def with_usual_clusters(static: Recorded, walks: Sequence[Recorded], settings: GaitSettings) -> Recorded:
    """A standing trial with the clusters that the walks want and whose names tell them, besides those it has.

    Args:
        static: with the clusters that were stated. walks: not completed. settings: say by which method; by Plug-in
            Gait's there are no clusters.
    """
    if settings.method == "plug_in_gait" or not walks:
        return static
    shared = set.intersection(*(set(_seen(walk)) for walk in walks))
    names = [name for name in _seen(walks[0]) if name in shared]
    stood = {name: xyz for name, xyz in static.points.items() if np.isfinite(xyz).any()}
    found = usual_clusters(names, with_wands(stood), static.clusters)
    return replace(static, clusters={**static.clusters, **found}, by_names=tuple(found)) if found else static


def _seen(walk: Recorded) -> list[str]:
    """Markers that are anywhere."""
    return [name for name, xyz in walk.points.items() if np.isfinite(xyz).any()]
