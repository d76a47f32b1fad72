"""Dropped tracks that are a marker's all the same.

A track of few points is dropped, and so is one that two cameras alone see whose images disagree by more than FAIR of
`likelihood` allows, as most of these are chance meetings. Some are markers, which two cameras see for a moment, or
where a calibration is off. Whether images are one marker's or two markers' shows in their residuals (`drifting_pairs`),
once the tracks that were confirmed have told what is usual. Points that

    have images of their own, which no confirmed track has,
    and are in every block of frames rather one marker's than two markers',
    in the whole of their track ten times likelier so                                      (1)

are given back, if FEWEST of their track are. Where nothing tells what is usual, nothing is given back.
"""

from __future__ import annotations

import numpy as np

from ...data import Cloud
from ...data.array_types import Bools, Ints
from .detection_index import Images
from .drifting_pairs import UsualResiduals, of_one_marker
from .passes import Associations

FEWEST = 4
"""Points of a track, a number; chosen, as of the shortest confirmed ones."""


def given_back(
    every: Associations, confirmed: Ints, cloud: Cloud, ids: Ints, images: Images, usual: UsualResiduals, gate: float
) -> Ints:
    """Rows of associations that are given back (1), by frame, of tracks that are not among the confirmed ones.

    Args:
        cloud: the points that are given so far, of tracks ids (P).
    """
    held = np.zeros(len(images.uv), bool)
    held[cloud.detection[cloud.detection >= 0]] = True
    has = every.detection >= 0
    own = has & ~every.shared & ~images.merged[every.detection]
    free = (has.sum(0) >= 2) & (own.sum(0) == has.sum(0)) & ~(held[every.detection] & has).any(0)
    rows = np.flatnonzero(free & ~np.isin(every.id, confirmed))
    rows = rows[_many(every.id[rows])]
    if not len(rows):
        return rows
    frame, id = np.concatenate([cloud.frame, every.frame[rows]]), np.concatenate([ids, every.id[rows]])
    detection = np.concatenate([cloud.detection.T, every.detection[:, rows]], 1)
    new = np.arange(len(frame)) >= len(cloud)
    which = new | ((detection >= 0).sum(0) == 2)  # the given ones tell what the calibration leaves where two see
    rows = rows[of_one_marker(frame, id, detection, which, images, usual, gate)[new]]
    rows = rows[_many(every.id[rows])]
    return rows[np.lexsort([every.id[rows], every.frame[rows]])]


def _many(id: Ints) -> Bools:
    """(n) whether FEWEST are of the same track."""
    return np.bincount(id, minlength=1)[id] >= FEWEST
