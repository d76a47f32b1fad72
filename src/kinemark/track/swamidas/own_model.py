"""A component angle model made of the very trial that is tracked (Swamidas 1997, 3.5.1).

The trial is tracked by the predictor alone first. Of its tracks the pairs that keep their distance best are segments
(the tree of `geometry.rigid_pairs`), judged by medians, since some identities may still be wrong; where a segment has
not its median length one of its ends is another marker, and both are left out there. What is left is learned from.
"""

from __future__ import annotations

import numpy as np

from ...data import AngleModel, KinemarkError, Tracks
from ...data.array_types import Floats, Ints
from ...geometry.rigid_pairs import spanning_links
from ...numerics.robust import SD_PER_MEDIAN
from ...signal.learn_angle_model import learn_model
from ...signal.segment_directions import LinkedSegments

FEWEST = 10
"""Frames that must have both ends of a segment; as in filling; chosen."""
STRAY = 0.05
"""Share of its median length by which a segment may differ before an end is taken for another marker; chosen."""


def own_model(tracks: Tracks, links: tuple[tuple[int, int], ...] = ()) -> AngleModel:
    """The model of a trial by a first tracking of it; its markers are called by the numbers of their tracks.

    Args:
        tracks: of the trial.
        links: pairs of tracks that are segments; empty: found.

    Raises:
        KinemarkError: too little of the motion is left to learn from, or it has no cycle.
    """
    paths = _paths(tracks)
    length, spread = _lengths(paths)
    if links:
        link = np.array([pair for pair in links if max(pair) < len(paths)], np.int64).reshape(-1, 2)
    else:
        link = spanning_links(spread / length, most=STRAY)
    link = link[np.isfinite(length[link[:, 0], link[:, 1]])]
    a, b = link.T
    segments = LinkedSegments(link, np.arange(len(link)), length[a, b], spread[a, b])
    try:
        names = [str(m) for m in range(len(paths))]
        return learn_model(
            _without_strays(paths, segments), rate=tracks.cloud.rate, names=names, segments=segments
        ).model
    except KinemarkError as error:
        raise KinemarkError(
            f"No angle model can be made of the trial itself. {error} Name another trial of the same motion, or a file "
            "of a model, in angle_model."
        ) from error


def _paths(tracks: Tracks) -> Floats:
    """(M, F, 3) mm of the tracks, NaN where missing."""
    cloud, own = tracks.cloud, tracks.id >= 0
    paths = np.full((int(tracks.id.max(initial=-1)) + 1, cloud.n_frames, 3), np.nan)
    paths[tracks.id[own], cloud.frame[own]] = cloud.xyz[own]
    return paths


def _lengths(paths: Floats) -> tuple[Floats, Floats]:
    """Median distance (M, M) mm of each pair, and its spread by the median deviation; NaN where too few frames tell."""
    n = len(paths)
    length, spread = np.full((2, n, n), np.nan)
    for i in range(n):
        for j in range(i + 1, n):
            apart = np.linalg.norm(paths[i] - paths[j], axis=1)
            apart = apart[np.isfinite(apart)]
            if len(apart) >= FEWEST:
                middle = float(np.median(apart))
                length[i, j] = length[j, i] = middle
                spread[i, j] = spread[j, i] = SD_PER_MEDIAN * float(np.median(np.abs(apart - middle)))
    return length, spread


def _without_strays(paths: Floats, segments: LinkedSegments) -> Floats:
    """The paths without what is no right segment's end."""
    kept = paths.copy()
    for (a, b), length in zip(segments.link, segments.length, strict=True):
        apart = np.linalg.norm(paths[a] - paths[b], axis=1)
        stray: Ints = np.flatnonzero(np.abs(apart - length) > STRAY * length)
        kept[a, stray], kept[b, stray] = np.nan, np.nan
    return kept
