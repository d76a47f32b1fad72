"""Lone images: those that a camera has of a track in one frame alone, and that others do not check.

Where two cameras side by side see a marker, how far it is from them is hardly known, and one wrong image of a third
camera, a flicker or another marker's, anywhere along the ray settles it. A marker that a third camera begins to see it
mostly sees for a while; a wrong image is there for one frame. So an image is given up where its camera has no other of
the track within AROUND frames, and the point without it alone is WIDER times as uncertain: lone images that several
cameras have at once check each other. The motion that the filter learned from it then says nothing for LOOK frames on
either side.
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from .candidate_points import intersect
from .detection_index import Images
from .neighbouring_points import LOOK
from .passes import Associations

AROUND = 2
"""Frames; chosen: a camera of half the rate has an image in every second one."""

WIDER = 4.0
"""A ratio of standard deviations; chosen: others do not check an image that makes so much of a difference."""

NOTHING = 1e6
"""mm², a variance that says nothing; chosen."""


def without_lone(seen: Associations, images: Images) -> Associations:
    """The same without lone images."""
    lone = np.stack([_alone(seen, row >= 0) for row in seen.detection])
    camera, row = np.nonzero(lone & ((seen.detection >= 0).sum(0) > 2))
    left = seen.detection[:, row]
    left[camera, np.arange(len(row))] = -1
    settled = _sd(images, left) > WIDER * _sd(images, seen.detection[:, row])
    which, each = np.unique(row[settled], return_index=True)
    if not len(which):
        return seen
    detection, cov = seen.detection.copy(), seen.cov.copy()
    detection[:, which] = left[:, settled][:, each]
    cov[..., _near(seen, which)] += NOTHING * np.eye(3)[..., None]
    return seen._replace(detection=detection, cov=cov)


def _alone(seen: Associations, has: Bools) -> Bools:
    """(S) which of those that have an image of a camera have no other within AROUND frames."""
    rows = np.flatnonzero(has)
    rows = rows[np.lexsort([seen.frame[rows], seen.id[rows]])]
    apart = (np.diff(seen.id[rows]) != 0) | (np.diff(seen.frame[rows]) > AROUND)
    out = np.zeros(len(has), bool)
    out[rows] = np.append(True, apart) & np.append(apart, True) if len(rows) else False
    return out


def _sd(images: Images, detection: Ints) -> Floats:
    """(n) mm, of points of detections (C, n)."""
    return np.asarray(np.sqrt(np.trace(intersect(images, detection).cov)))


def _near(seen: Associations, which: Ints) -> Bools:
    """(S) those of the same tracks at most LOOK frames from some."""
    F = int(seen.frame.max()) + 2 * LOOK + 1
    place = np.unique((seen.id[which] * F + seen.frame[which])[:, None] + np.arange(-LOOK, LOOK + 1))
    return np.isin(seen.id * F + seen.frame, place)
