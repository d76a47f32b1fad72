"""Two tracks that may have been exchanged where no image tells that each goes on as itself.

A track goes on from one sound point, of two images of its own, to the next. Where these lie in successive frames and a
camera has an image of its own in both, that image tells that they are one marker's. All other links are *loose*: frames
are missing, or other cameras see the track from one frame to the next. Wrong images were given up there, or images of
several markers were left out, and it may go on as another marker. Motion alone tells. Of two loose links, from b to c
and from b' to c', that have a time in common, with the score s of a stitch by motion ((1) of `stitch`),

    M = s(b, c) + s(b', c') − s(b, c') − s(b', c)                                         (1)

says how much likelier they are than exchanged.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data import Tracks
from ....data.array_types import Bools, Floats, Ints
from ....native.image_index import ranges
from ..points.neighbouring_points import TrackPoints
from ..simultaneous_method import Simultaneous
from .stitch import CLEAR_MARGIN, Ends, ends_of, reachable, scores_by_motion


class PossibleExchanges(NamedTuple):
    """N pairs of loose links: the tracks (N, 2), the first and last frames (N) that both links have in common, and the
    margin (N) by (1)."""

    tracks: Ints
    first: Ints
    last: Ints
    margin: Floats


def possible_exchanges(tracks: Tracks, own: Bools, method: Simultaneous) -> PossibleExchanges:
    """Pairs of loose links, each no longer than `max_gap`, that are not a hundred times likelier than exchanged (1).

    Of each link the likeliest exchange is given, and others where they are the likeliest of the other link.

    Args:
        tracks: P points. own: (P, C) where a camera has an image of the point alone.
    """
    T = 1 / tracks.cloud.rate
    points, track, loose = _pieces(tracks, own, method.max_gap)
    if len(loose) < 2:
        none = np.zeros(0, np.int64)
        return PossibleExchanges(none.reshape(0, 2), none, none, np.zeros(0))
    ends = ends_of(points, T, method)
    pair = _pairs(ends, loose, T, method)
    before = pair[[0, 1, 0, 1]]
    score = scores_by_motion(points, ends, before.ravel(), (pair[[0, 1, 1, 0]] + 1).ravel(), T, method)[0]
    margin = np.array([1.0, 1.0, -1.0, -1.0]) @ score.reshape(before.shape)  # (1)
    order = np.argsort(margin, kind="stable")[: np.count_nonzero(margin < CLEAR_MARGIN)]
    likeliest = np.unique(np.unique(pair.T[order], return_index=True)[1] // 2)
    pair, margin = pair[:, order[likeliest]], margin[order[likeliest]]
    return PossibleExchanges(track[pair].T, ends.last[pair].max(0), ends.first[pair + 1].min(0), margin)


def _pieces(tracks: Tracks, own: Bools, longest: float) -> tuple[TrackPoints, Ints, Ints]:
    """The sound points, numbered by the pieces of their tracks between loose links; the track (N) of each piece; and
    those after which a loose link follows, of at most `longest` s, to the piece of the next number."""
    sound = np.flatnonzero(own.sum(1) >= 2)
    row = sound[np.lexsort([tracks.cloud.frame[sound], tracks.id[sound]])]
    goes_on, step = np.diff(tracks.id[row]) == 0, np.diff(tracks.cloud.frame[row])
    loose = (step > 1) | ~(own[row[:-1]] & own[row[1:]]).any(1)
    new = np.append(np.ones(min(len(row), 1), bool), ~goes_on | loose)
    piece = np.cumsum(new) - 1
    short = goes_on & loose & (step <= longest * tracks.cloud.rate)
    points = TrackPoints.of(tracks.cloud, tracks.id).take(row)._replace(id=piece)
    return points, tracks.id[row[new]], piece[:-1][short]


def _pairs(ends: Ends, loose: Ints, T: float, method: Simultaneous) -> Ints:
    """(2, N) pieces before two loose links that have a time in common, where a marker could have gone either way."""
    loose = loose[np.argsort(ends.last[loose], kind="stable")]
    count = np.searchsorted(ends.last[loose], ends.first[loose + 1]) - np.arange(len(loose)) - 1
    pair = loose[np.stack([np.repeat(np.arange(len(loose)), count), ranges(np.arange(len(loose)) + 1, count)])]
    return pair[:, reachable(ends, pair, pair[::-1] + 1, T, method).all(0)]
