"""Which tracks are the markers of an angle model: by the lengths of its segments, and by its directions.

The model's segments are laid upon pairs of tracks one after the other, each upon pairs that have its length; of all
ways to do so the one is taken whose directions the model has best at one phase and cadence (`signal.phase`), together
with its lengths.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from ...data import AngleModel
from ...data.array_types import Floats, Ints
from ...geometry.rigid_pairs import distances
from ...signal.learn_angle_model import template_of
from ...signal.phase import find_phase
from ...signal.segment_directions import directions

LENGTHS = 0.15
"""Share by which a segment of the trial may be longer or shorter than the model's: another day's markers; chosen."""
MOST = 200
"""Ways that are compared by their directions, of those found first; chosen: more cost time and are as like."""
STRANGE = 25.0
"""Mean squared deviation, in the spreads, above which the motion is another; as in filling; chosen."""


def tracks_of_model(model: AngleModel, paths: Floats, *, cycle: float, least_spread: float) -> Ints | None:
    """The track (M) of each marker of a model; None where no tracks fit it.

    Args:
        model: of the motion.
        paths: (T, F, 3) mm of T tracks, NaN where unseen; F two or more.
        cycle: frames.
        least_spread: of a direction, at least.
    """
    template, spread = template_of(model)
    spread = np.maximum(spread, least_spread)
    best, least = None, STRANGE
    for tracks in itertools.islice(_laid(model, distances(paths).mean), MOST):
        own = paths[tracks]
        y = directions(own, model.links).transpose(1, 0, 2).reshape(paths.shape[1], -1)
        if np.isnan(y).all():
            continue
        cost = find_phase(y, template, spread, cycle=cycle).cost + _length_cost(model, own)
        if cost < least:
            best, least = tracks, cost
    return best


def _length_cost(model: AngleModel, own: Floats) -> float:
    """Mean squared deviation of the lengths of paths (M, F, 3), in fifths of `LENGTHS`."""
    way = np.linalg.norm(own[model.links[:, 1]] - own[model.links[:, 0]], axis=-1)
    off = (np.nanmedian(way, axis=1) / model.length - 1) / (LENGTHS / 5)
    return float((off**2).mean())


def _laid(model: AngleModel, apart: Floats) -> Iterator[Ints]:
    """Tracks (M) of the markers by mean distances (T, T) mm of the tracks; markers without a segment have none."""
    track = np.full(len(model.names), -1)

    def lay(left: list[int]) -> Iterator[Ints]:
        if not left:
            yield track.copy()
            return
        s = next((s for s in left if (track[model.links[s]] >= 0).any()), left[0])
        a, b = model.links[s]
        rest = [other for other in left if other != s]
        fits = np.abs(apart - model.length[s]) <= LENGTHS * model.length[s]
        for i, j in np.argwhere(fits):
            if _free(track, a, i) and _free(track, b, j):
                before = track[[a, b]].copy()
                track[[a, b]] = i, j
                yield from lay(rest)
                track[[a, b]] = before

    return lay(list(range(len(model.links))))


def _free(track: Ints, marker: int, wanted: int) -> bool:
    """Whether a marker is that track already, or neither has another."""
    return bool(track[marker] == wanted or (track[marker] < 0 and wanted not in track))
