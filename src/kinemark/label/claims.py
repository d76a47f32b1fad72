"""Markers without a name that could bear another's: an extra one, or the right one where all moved up one place.

An exchange of two labels says nothing of a marker that has none. Where such a marker u is seen for long, together with
the one that is a, and its evidence e(u, a) is a good part of that one's, a would lose by going over to u

    e(t, a) − e(u, a) − max( e(t, b), 0 )   over labels b that no marker has                                       (1)

and half of it counts, as one displacement of a marker changes many of its distances alike.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats, Ints
from .arrange import markers_of
from .stretches import Stretches

SEEN = 0.3
"""Share of the frames in which a label is seen, below which it counts as absent; chosen, as `arrange.LONG`."""
CLAIMS = 0.3
"""Least of e(u, a) as a share of e(t, a); chosen: markers that had been robbed of their names had 0.44 to 1."""
COUNTED = 0.5
"""Share of (1) that counts; chosen: names that were wrong by it lost 0.9 to 29 nats."""


def lost_to_claims(stretches: Stretches, label: Ints, nats: Floats) -> Floats:
    """(L) nats a frame that each label loses, at the least, to a marker without name; infinite where none claims it.

    Args:
        label: (T) −1 for none. nats: (T, L) evidence of `sweeps` (1).
    """
    L = nats.shape[1]
    out = np.full(L, np.inf)
    if not (label >= 0).any():
        return out
    markers = markers_of(stretches, label, L)
    rivals = np.flatnonzero(markers.label < 0)
    if not len(rivals):
        return out
    n = stretches.seen.sum(1).astype(float)
    count = np.maximum(np.bincount(markers.of[markers.of >= 0], n[markers.of >= 0], len(markers.label)), 1.0)
    mean = np.zeros((len(markers.label), L))
    part = np.flatnonzero(markers.of >= 0)
    np.add.at(mean, markers.of[part], n[part, None] * nats[part])
    mean /= count[:, None]
    free = np.setdiff1d(np.arange(L), label)
    seen = np.isfinite(markers.xyz[..., 0])
    for m in np.flatnonzero(markers.label >= 0).tolist():
        a = int(markers.label[m])
        claims = rivals[(mean[rivals, a] > CLAIMS * mean[m, a]) & (seen[:, rivals] & seen[:, [m]]).any(0)]
        if len(claims) and mean[m, a] > 0:
            other = mean[m, free].max(initial=0.0)
            out[a] = COUNTED * (mean[m, a] - mean[claims, a].max() - other)
    return out


def left_over(stretches: Stretches, label: Ints, L: int) -> tuple[int, int]:
    """How many labels no marker has, and how many markers that are seen for long have no name.

    Names that moved up one place end at a label that is absent, and begin at a marker that is none of the template's.
    """
    seen = np.array([stretches.seen[label == a].any(0).mean() for a in range(L)])
    return int((seen < SEEN).sum()), int((markers_of(stretches, label, L).label < 0).sum())
