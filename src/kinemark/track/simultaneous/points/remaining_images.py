"""Tracks of images that no track has.

Tracks begin every 0.05 s at most, are dropped where they have few points, and where two cameras alone see them whose
images disagree by more than FAIR of `likelihood` allows: most of these are chance meetings. Some are markers, which two
cameras see for a moment, or where a calibration is off. Whether images are one marker's or two markers' shows in their
residuals (`drifting_pairs`), once the tracks that were confirmed have told what is usual. So the images that no point
has are tracked once more, with new tracks in every frame, and of these points those that

    have images of their own, without those of other markers that drift past the others,
    and are in every block of frames rather one marker's than two markers'               (1)

are given, if FEWEST of their track are, and MOST of it is. For its images are followed from frame to frame: where most
of them are two markers', the rest are too, though these hardly drift there. Where nothing tells what is usual, nothing
is tracked. Of more than FEW cameras most markers have a point, and what lies so near to the place of one without an
image there that both would merge, in files that do not say so, is mostly that marker's own (2).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....data import Cloud
from ....data.array_types import Bools, Ints
from ..detection_index import Images
from ..following.candidate_points import intersect
from ..following.passes import Associations, run
from ..ghosts.drifting_pairs import MOST, UsualResiduals, of_one_marker, without_strangers
from ..simultaneous_method import Simultaneous

FEWEST = 4
"""Points of a track, a number; chosen, as of the shortest confirmed ones: with three, 13 scenes (seeds 2003 to 2024 and
5 to 38 of benchmarks/tracking_scenes.py) have 33 samples more, but two swaps and three ghosts."""

FEW = 4
"""Cameras, a number; chosen: of eight scenes of more (seeds 0 to 43 and 2014, 2035) (2) takes 38 of 213 ghosts for 10
samples, of three of four cameras (2009, 12, 29) 3 of 165 for 29."""


def tracks_of_remaining(
    cloud: Cloud, ids: Ints, images: Images, usual: UsualResiduals, resolution: float, method: Simultaneous
) -> tuple[Associations, bool]:
    """Associations by frame of new tracks (1), of images that no point of a cloud has, whose tracks are ids (P); and
    whether an image of another marker was taken from them, so that images are left that may make a track again.

    Args:
        resolution: px, below which images merge in a file that does not mark them; 0 where it does.
    """
    free = np.ones(len(images.uv), bool)
    free[cloud.detection[cloud.detection >= 0]] = False
    if resolution and len(images.P) > FEW:
        free[_merged_there(cloud, images, resolution)] = False  # (2)
    every = run(images.only(free), cloud.rate, replace(method, initiation_interval=1 / cloud.rate))
    has = every.detection >= 0
    own = has & ~every.shared & ~images.merged[every.detection]
    every = every.take(_many(every.id, (has.sum(0) >= 2) & (own == has).all(0)))
    detection = without_strangers(every.frame, every.id, every.detection, images, usual, method.gate)
    strange = bool((detection != every.detection).any())
    every = every._replace(detection=detection, xyz=intersect(images, detection).xyz)
    return every.take(of_markers(every, cloud, ids, images, usual, method.gate)), strange


def _merged_there(cloud: Cloud, images: Images, resolution: float) -> Ints:
    """Images within `resolution` px of the place of a point that has none in their camera, with which it may merge."""
    C, there = len(images.P), []
    for c, P in enumerate(images.P):
        lacking = np.flatnonzero(cloud.detection[:, c] < 0)
        h = cloud.xyz[lacking] @ P[:, :3].T + P[:, 3]
        uv = h[:, :2] / h[:, 2:]
        own, rows = images.near(cloud.frame[lacking] * C + c, uv[:, 0], np.full(len(uv), resolution))
        there.append(rows[np.linalg.norm(images.uv[rows] - uv[own], axis=1) < resolution])
    return np.concatenate(there)


def of_markers(
    every: Associations, cloud: Cloud, ids: Ints, images: Images, usual: UsualResiduals, gate: float
) -> Ints:
    """Rows of associations of new tracks that are a marker's by (1), by frame.

    Args:
        cloud: the points that are given so far, of tracks ids (P).
    """
    other = int(ids.max(initial=-1)) + 1
    frame, id = np.concatenate([cloud.frame, every.frame]), np.concatenate([ids, every.id + other])
    detection = np.concatenate([cloud.detection.T, every.detection], 1)
    new = np.arange(len(frame)) >= len(cloud)
    which = new | ((detection >= 0).sum(0) == 2)  # the given ones tell what the calibration leaves where two see
    one = of_one_marker(frame, id, detection, which, images, usual, gate)[new]
    rows = _many(every.id, one & (np.bincount(every.id, one) >= MOST * np.bincount(every.id))[every.id])
    return rows[np.lexsort([every.id[rows], every.frame[rows]])]


def _many(id: Ints, which: Bools) -> Ints:
    """Those of tracks id (n), of which FEWEST are in the same track."""
    return np.flatnonzero(which & (np.bincount(id, which, minlength=1)[id] >= FEWEST))
