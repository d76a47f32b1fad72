"""Tracks against the truth of a scene.

A tracked point is a marker's that lies within NEAR of it, or within four of the standard deviations that the cameras
allow which see the sample; each marker has one point. Of several markers it is that of its images, else the nearest: a
vague point is near to many. Wanted are samples of which two cameras have an image of their own, where these leave no
more than OPEN open.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

NEAR, OPEN = 10.0, 50.0  # mm
OF_ITS, NOT_NEAR = 1e3, 1e6  # mm that images of a marker's are worth, and that a marker costs which is not near
SLACK = 5  # frames that a decision may lie beside the swap that it is about


class Tally(NamedTuple):
    """Counts: wanted and found samples that two cameras see, and that more see; ghosts, frames; swaps, and those that
    no decision lists; pieces, and markers that have any; squared errors in mm² of points, their number."""

    two: int
    two_found: int
    more: int
    more_found: int
    ghosts: int
    frames: int
    swaps: int
    unlisted: int
    pieces: int
    markers: int
    squared: float
    points: int

    def __add__(self, other):
        return Tally(*(a + b for a, b in zip(self, other, strict=True)))


def tally(made, tracks, decisions=()):
    """What tracks, and decisions that were close (or None), have of a scene."""
    owner, off = owners(made, tracks)
    near = owner >= 0
    found = np.zeros(made.own.shape, bool)
    found[owner[near], tracks.cloud.frame[near]] = True
    wanted = made.sd <= OPEN
    two, more = wanted & (made.own == 2), wanted & (made.own > 2)
    swaps = swapped(tracks, owner)
    pieces = np.unique(np.column_stack([owner[near], tracks.id[near]]), axis=0)
    return Tally(
        two=int(two.sum()),
        two_found=int((two & found).sum()),
        more=int(more.sum()),
        more_found=int((more & found).sum()),
        ghosts=int((~near & (tracks.id >= 0)).sum()),
        frames=made.own.shape[1],
        swaps=len(swaps),
        unlisted=sum(not listed(swap, decisions) for swap in swaps),
        pieces=len(pieces),
        markers=len(np.unique(pieces[:, 0])),
        squared=float((off[near] ** 2).sum()),
        points=int(near.sum()),
    )


def owners(made, tracks):
    """(P) the marker of each tracked point, −1 for none, and how far off it is in mm."""
    cloud = tracks.cloud
    owner, off = np.full(len(cloud), -1), np.full(len(cloud), np.nan)
    sd = np.where(np.isfinite(made.sd), made.sd, 0.0)
    reach = np.maximum(NEAR, 4 * np.minimum(sd, OPEN))
    for f in range(cloud.n_frames):
        rows = np.arange(len(cloud))[cloud.rows(f)]
        rows = rows[tracks.id[rows] >= 0]
        apart = np.linalg.norm(cloud.xyz[rows][:, None] - made.xyz[:, f], axis=-1)
        within, images = apart < reach[:, f], cloud.detection[rows]
        its = (images[:, None] == made.image[:, :, f].T) & (images >= 0)[:, None]
        share = its.sum(-1) / (images >= 0).sum(1)[:, None]
        i, j = linear_sum_assignment(np.where(within, apart - OF_ITS * share, NOT_NEAR))
        good = within[i, j]
        owner[rows[i[good]]], off[rows[i[good]]] = j[good], apart[i[good], j[good]]
    return owner, off


def swapped(tracks, owner):
    """(track, frame before, frame after) of each change of a track from one marker to another."""
    rows = np.flatnonzero(owner >= 0)
    rows = rows[np.lexsort([tracks.cloud.frame[rows], tracks.id[rows]])]
    a, b = rows[:-1], rows[1:]
    over = (tracks.id[a] == tracks.id[b]) & (owner[a] != owner[b])
    frame = tracks.cloud.frame
    return [(int(tracks.id[i]), int(frame[i]), int(frame[j])) for i, j in zip(a[over], b[over], strict=True)]


def listed(swap, decisions):
    """Whether a decision is about this swap."""
    track, before, after = swap
    return any(track in d.tracks and d.first - SLACK <= after and before <= d.last + SLACK for d in decisions)
