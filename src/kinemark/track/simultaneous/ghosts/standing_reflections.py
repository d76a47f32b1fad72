"""Reflections that stand still, of which those of two cameras meet by chance: in all frames, or in none.

A lamp, a window or a shoe's buckle on the floor is a *spot*, an image at one place of a camera from the beginning of a
recording to its end. Spots of two cameras lie on each other's epipolar lines by chance, and then do so in every frame:
as evidence all frames together are worth one. Whether some are markers is told by their number. Of any two spots of
two cameras, with e and s by (1) and (2) of `epipolar_noise` and a gate of g, let there be

    N with |e| < g s,   M with g s < |e| < (1 + ASIDE) g s                                       (1)

By chance N is M / ASIDE in the mean. So where it has a Poisson probability of CHANCE to be as large, or more, points of
two spots are given up, if MOST of their track are such and no SOUND cameras ever see it. Spots of points that SOUND
cameras see do not count. Nothing is judged where there are no such points, as then no third camera lacks these, nor
where MOST of their images stand too: then those of two cameras are rather markers as well.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
import scipy
from scipy.spatial import cKDTree

from ....data.array_types import Bools, Ints
from ....numerics.lasting_places import lasting_places
from ..detection_index import Images
from ..following.candidate_points import fundamentals
from .drifting_pairs import MOST, SOUND, residual

ASIDE = 29
"""Of (1), how many times as wide the part beside is; chosen: 9 finds too few of a few spots to tell N / M by."""

CHANCE = 0.01
"""The probability of (1); conventional."""


def of_reflections(id: Ints, detection: Ints, images: Images, gate: float) -> Bools:
    """(P) the points of tracks id (P), with detections (C, P), that are chance meetings of spots."""
    out = np.zeros(len(id), bool)
    number = (detection >= 0).sum(0)
    never = (np.bincount(id, number >= SOUND) == 0)[id]
    if never.all() or not never.any():
        return out
    free, tracked = np.ones(len(images.uv), bool), detection[:, number >= SOUND]
    free[tracked[tracked >= 0]] = False
    spots = [_spots(images, c, gate) for c in range(len(detection))]
    standing = [len(_at(images, rows[rows >= 0], spot, gate)) for rows, spot in zip(tracked, spots, strict=True)]
    spots = [spot[free[spot]] for spot in spots]
    if sum(standing) > MOST * (tracked >= 0).sum() or not _by_chance(spots, images, gate):
        return out
    at_spot = np.zeros(len(images.uv) + 1, bool)
    for c, spot in enumerate(spots):
        at_spot[_at(images, np.unique(detection[c, never & (detection[c] >= 0)]), spot, gate)] = True
    out = never & (at_spot[detection] | (detection < 0)).all(0)
    return out & (np.bincount(id, out) >= MOST * np.bincount(id))[id]


def _spots(images: Images, c: int, gate: float) -> Ints:
    """A row of `images` at each spot of camera c."""
    rows = np.flatnonzero(images.usable & (images.camera == c))
    if not len(rows):
        return rows
    return rows[lasting_places(images.uv[rows], images.frame[rows], images.n_frames, gate * _noise(images, rows))]


def _noise(images: Images, rows: Ints) -> float:
    """px, of the median of some images."""
    return float(np.sqrt(np.median(images.variance[rows])))


def _by_chance(spots: list[Ints], images: Images, gate: float) -> bool:
    """Whether no more spots of two cameras lie on each other's lines than do by chance (1)."""
    F, near, aside = fundamentals(images.P), 0, 0
    for a, b in combinations(range(len(spots)), 2):
        one, other = (rows.ravel() for rows in np.meshgrid(spots[a], spots[b], indexing="ij"))
        e, squared = residual(images, F[a, b], one, other)
        off = np.abs(e) / (gate * np.sqrt(squared))
        near, aside = near + int((off < 1).sum()), aside + int(((off >= 1) & (off < 1 + ASIDE)).sum())
    return near > 0 and scipy.stats.poisson.sf(near - 1, aside / ASIDE) > CHANCE


def _at(images: Images, rows: Ints, spots: Ints, gate: float) -> Ints:
    """Those of some rows that lie at a spot, of one camera."""
    if not len(spots) or not len(rows):
        return rows[:0]
    return rows[cKDTree(images.uv[spots]).query(images.uv[rows])[0] < gate * _noise(images, spots)]
