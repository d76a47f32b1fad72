"""Which points are the missing markers that the angle model has placed (Swamidas 1997, 4.2.3 and 4.2.5).

"The matched markers were checked against the motion model to determine the correctness of the match." Each placed
track may take a point in its region of acceptance, or none. All ways to do so are compared together, so that two
markers that come back at once are told apart though their regions overlap. A way costs

    Σ_s [ |u_s − d_s(φ)|² / σ_s² + (ℓ_s − L_s)² / σ_L² ] + (φ − φ⁻)² / v_φ + Σ_none 9                (1)

over the segments s that it makes known: directions u against the model's d, lengths ℓ against L; φ is the phase once
they are known and φ⁻, of variance v_φ, the one before. A marker that is left without a point costs as much as one
three standard deviations off, so that a false point in a region is not taken for lack of a better one. The cheapest
way is taken.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator

import numpy as np

from ...data.array_types import Bools, Floats, Ints

NONE = 9.0
"""Cost of a marker without a point, of (1), a pure number; chosen: that of one three standard deviations off."""
MOST = 500
"""Ways that are compared; with more, each track takes the nearest point in its region. Chosen: more cost time."""


def match_by_model(inside: Bools, distance: Floats, cost: Callable[[Ints], float]) -> Ints:
    """The point (T) of each of T tracks, −1 for none.

    Args:
        inside: (T, N) points in the tracks' regions.
        distance: (T, N) from their middles.
        cost: the first two sums of (1) for points (T) of the tracks, −1 for none.
    """
    choices = [[-1, *np.flatnonzero(row)] for row in inside]
    if math.prod(len(own) for own in choices) > MOST:
        nearest = np.where(inside, distance, np.inf)
        choices = [[-1, *own[np.argsort(near[own])][:1]] for own, near in _rows(inside, nearest)]
    best, least = np.full(len(inside), -1), np.inf
    for way in itertools.product(*choices):
        taken = np.array(way, np.int64)
        own = taken[taken >= 0]
        if len(set(own.tolist())) < len(own):
            continue
        total = cost(taken) + NONE * int((taken < 0).sum())
        if total < least:
            best, least = taken, total
    return best


def _rows(inside: Bools, distance: Floats) -> Iterator[tuple[Ints, Floats]]:
    """The candidates of each track, and all distances from it."""
    for row, near in zip(inside, distance, strict=True):
        yield np.flatnonzero(row), near
