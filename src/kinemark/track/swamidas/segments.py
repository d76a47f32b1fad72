"""Which markers are ends of one rigid segment, and how long it is (Swamidas 1997, 3.33 and 3.5).

The document has the matrix CONNECT, whose rows name two markers of one segment, and the segments' lengths, for its
model of gait. Here they may also refuse a match: a point y can be the marker i only if for every segment (i, j) of
length L whose other end was seen in the last three frames it is no point that can be the marker j, and

    | |y − z| − L | ≤ tolerance · L                                      (1)

for one of the points z that can, if there are any: those nearer than L / 2 to the position x̂_j that is predicted for
j.

Without CONNECT the first frames tell: of all pairs of markers the spread of their distance about its mean is taken, and
the tree that joins all markers with the least spread holds the segments (2), save those with more than half the
tolerance.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...data.array_types import Bools, Floats
from ...geometry.rigid_pairs import distances, spanning_links


class LearnedSegments(NamedTuple):
    """S segments: link (S, 2) tracks, length (S) mm."""

    link: NDArray[np.int64]
    length: Floats


def no_segments() -> LearnedSegments:
    """None at all."""
    return LearnedSegments(np.zeros((0, 2), np.int64), np.zeros(0))


def learn_segments(paths: Floats, *, tolerance: float, links: tuple[tuple[int, int], ...] = ()) -> LearnedSegments:
    """Segments of markers (M, F, 3) mm, NaN where unseen, by their distances in F frames.

    Args:
        paths: of the first frames; markers not seen in all of them belong to no segment.
        tolerance: as in (1).
        links: pairs that are segments; only their lengths are learned then.
    """
    found = distances(paths, most_frames=paths.shape[1])
    length = np.where(found.frames == paths.shape[1], found.mean, np.nan)
    if links:
        link = np.array([pair for pair in links if max(pair) < len(paths)], np.int64).reshape(-1, 2)
    else:
        link = spanning_links(np.where(np.isnan(length), np.nan, found.share), most=tolerance / 2)  # (2)
    link = link[np.isfinite(length[link[:, 0], link[:, 1]])]
    return LearnedSegments(link, length[link[:, 0], link[:, 1]])


def allowed_points(
    points: Floats, predicted: Floats, sure: Bools, segments: LearnedSegments, tolerance: float
) -> Bools:
    """(T, N) whether point n may be track t by (1).

    Args:
        points: (N, 3) mm.
        predicted: (T, 3) mm.
        sure: (T) tracks that were seen in the last three frames.
        segments: their links name the T tracks by place; −1 for one that is not there.
        tolerance: share of the length.
    """
    allowed = np.ones((len(predicted), len(points)), bool)
    apart = np.linalg.norm(points[:, None] - points, axis=-1)
    for link, length in zip(segments.link, segments.length, strict=True):
        for one, other in (link, link[::-1]):
            if min(one, other) >= 0 and sure[other]:
                near = np.linalg.norm(points - predicted[other], axis=1) < length / 2
                fits = np.abs(apart[:, near] - length) <= tolerance * length
                allowed[one] &= ~near & (fits.any(1) | (not near.any()))  # (1)
    return allowed
