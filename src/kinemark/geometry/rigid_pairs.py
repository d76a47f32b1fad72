"""Which markers keep their distance: links between pairs, the tree that joins all, and banks of several on one body.

Of every pair of markers the mean distance and its spread are taken over the frames that have both (1). The spread as a
share of the mean says how rigid the pair is; skin, and marks that lie across a joint, have more. Two markers that are
both far from a joint can share little motion and still be of two bodies, so that nearness of rigidity is relative: the
*tree* joins all markers with the least spread in all (2); a *bank* is a group of which every pair is rigid (3).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ..data.array_types import Floats, Ints

MOST_FRAMES = 1000
"""Frames, spread over the trial, that (1) looks at; chosen."""
LOOSE = 9.0
"""Share that stands for no known share, in (3); chosen."""


class Distances(NamedTuple):
    """Of M markers: mean (M, M) mm and spread (M, M) mm, a standard deviation, of the distances, both NaN on the
    diagonal and where no frame has both, and frames (M, M) the number of those that have.

    Of one marker from all, (M) each.
    """

    mean: Floats
    spread: Floats
    frames: Ints

    @property
    def share(self) -> Floats:
        """(M, M) spread over mean; NaN where unknown, or where two markers are one."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(self.mean > 0, self.spread / self.mean, np.nan)


def distances(xyz: Floats, *, most_frames: int = MOST_FRAMES) -> Distances:
    """(1) for paths (M, F, 3) mm, NaN where missing."""
    n, n_frames, _ = xyz.shape
    step = max(-(-n_frames // max(most_frames, 1)), 1)
    axes = np.ascontiguousarray(np.moveaxis(xyz[:, ::step], -1, 0))  # (3, M, F)
    mean, spread = np.full((2, n, n), np.nan)
    count = np.zeros((n, n), np.int64)
    for i in range(n):
        m, s, k = _from_one(axes[:, i:], axes[:, i])
        mean[i, i:], spread[i, i:], count[i, i:] = m, s, k
        mean[i:, i], spread[i:, i], count[i:, i] = m, s, k
    np.fill_diagonal(mean, np.nan)
    np.fill_diagonal(spread, np.nan)
    return Distances(mean, spread, count)


def distances_from(xyz: Floats, marker: int) -> Distances:
    """(1) of one marker from all, itself too, of paths (M, F, 3) mm, NaN where missing."""
    axes = np.moveaxis(xyz, -1, 0)
    return Distances(*_from_one(axes, axes[:, marker]))


def _from_one(axes: Floats, one: Floats) -> tuple[Floats, Floats, Ints]:
    """Mean, spread and frames (M) of the distances of paths (3, M, F) from one (3, F)."""
    apart = axes - one[:, None]
    apart *= apart
    d = apart[0]
    d += apart[1]
    d += apart[2]
    np.sqrt(d, out=d)
    there = d == d  # NaN is not itself
    count = np.count_nonzero(there, axis=1)
    if (count == d.shape[1]).all():
        mean = d.mean(1)
        d -= mean[:, None]
        return mean, np.sqrt(np.einsum("mf,mf->m", d, d) / d.shape[1]), count
    both, gone = np.where(count > 0, count, np.nan), ~there
    d[gone] = 0.0
    mean = d.sum(1) / both
    d -= mean[:, None]
    d[gone] = 0.0
    return mean, np.sqrt(np.einsum("mf,mf->m", d, d) / both), count


def spanning_links(share: Floats, *, most: float) -> Ints:
    """(S, 2) the tree of (2), or trees where pairs with a share above `most` would be needed to join them."""
    cost = np.where(share <= most, 1 + share, 0.0)  # 0, and nearly 0, is no edge of a graph
    return np.argwhere(scipy.sparse.csgraph.minimum_spanning_tree(cost).toarray() > 0)


def rigid_groups(share: Floats, *, most: float) -> Ints:
    """(M) number of the bank of each marker by (3): no pair of a bank has a share above `most`."""
    n = len(share)
    if n < 2:
        return np.zeros(n, np.int64)
    loose = np.nan_to_num((share + share.T) / 2, nan=LOOSE, posinf=LOOSE)
    np.fill_diagonal(loose, 0.0)
    return (
        np.asarray(
            scipy.cluster.hierarchy.fcluster(
                scipy.cluster.hierarchy.linkage(scipy.spatial.distance.squareform(loose, checks=False), "complete"),
                most,
                "distance",
            ),
            np.int64,
        )
        - 1
    )
