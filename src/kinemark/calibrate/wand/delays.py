"""By how many images cameras took a wand's film later than others, from pairs of cameras, before there is a rig.

Camera c takes its image k at k + d_c, in images. Of two cameras a and b, the markers that b shows at the times of a's
images are, with g = f − rint(d), s = rint(d) − d and the wand of neighbouring images in the order that moves it less,

    u_b(f) = u(g) + s (u(g+1) − u(g−1)) / 2 + s² (u(g+1) − 2 u(g) + u(g−1)) / 2           (1)

and where d = d_b − d_a, a fundamental matrix fits them to those of a, either end first, by the mean square

    S(d) = mean over the better share of the frames of Sampson's distances², px²           (2)

that is left of lenses and noise; elsewhere the wand's motion comes on top. Whole d are tried, then three about the
least, on the parabola through which S is least (3), in steps that become smaller. A pair tells something where S is
`CLEAR` times less there than far from there, and parts of an image where S is `PARTS` times less than at the whole
one: lenses, too, are fitted a little better at a wrong time. Cameras are chained by the pairs that share most frames (a
spanning tree), those that fit as they are before others, and delays are given less their (lower) median, as most
cameras are thought to be in time.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from ...data import KinemarkError
from ...data.array_types import Floats
from ...numerics.evenly import evenly
from ...numerics.later_frames import in_later_frames
from .ends import FEWEST, LEAST_SPREAD, SAMPLES, epipolar_costs

WITHIN = (6, 25, 100)
"""Images that cameras are looked for apart, one after the other, and a quarter of the recording at most; chosen for
time, the last as for trials."""
QUICK = 8
"""Samples of a fundamental matrix, where only whole images are asked for; chosen for time: six are right (`ends`)."""
LOOKED_AT = 200
"""Frames of a pair, spread evenly; chosen for speed."""
BETTER = 0.8
"""Share of the frames in (2); chosen: strays and mistaken rows are fewer than the rest."""
CLEAR = 4.0
"""Of S far from the least S by that; chosen: right ones of simulated wands had more than 30, chance less than 2."""
STEPS = (0.5, 0.25)
"""Images to both sides of the least in (3); chosen: S is a parabola as long as the wand's motion is even."""
PARTS = 2.0
"""Of S at the nearest whole image by the least S; chosen: with less, noise and lenses hide what is left."""
LATER = 0.8
"""Of S at the next image by S at this one, below which cameras seem late; chosen: chance changes S by some percent."""
UNLIKE = 30.0
"""Of S of two pairs of cameras, above which some seem late; chosen: noise and lenses differ by less."""
LEAST = 0.02
"""Images; delays below are none; chosen: the wand moves some px an image, and centroids are a tenth px off."""


def delays_between(uv: Floats) -> Floats | None:
    """The delays (C) in images of cameras that see a wand's markers (C, F, K, 2) px; None where none is late.

    Args:
        uv: NaN where not seen; markers in either order, in each image its own.
    """
    pairs, delay = _pairs(uv), dict[int, float]()
    as_they_are = _costs(uv, pairs, 0.0)
    good = UNLIKE * max(float(np.fmin.reduce(as_they_are)), LEAST_SPREAD**2)
    for old, new in _chain([pairs[i] for i in np.argsort(~(as_they_are <= good), kind="stable")]):
        delay[new] = delay.setdefault(old, 0.0) + (pair_delay(uv[old], uv[new], good) or 0.0)
    found = np.array([delay[c] for c in range(len(uv))])
    found -= np.sort(found)[(len(found) - 1) // 2]
    found[np.abs(found) < LEAST] = 0.0
    return found if found.any() else None


def seem_late(uv: Floats) -> bool:
    """Whether a camera of (C, F, K, 2) px fits another much worse than others do, or better by its next image."""
    chain = _chain(_pairs(uv))
    at, *beside = (_costs(uv, chain, d) for d in (0.0, -1.0, 1.0))
    if not np.isfinite(at).any():
        return False
    return bool(np.nanmax(at) > UNLIKE * max(np.nanmin(at), LEAST_SPREAD**2) or (np.fmin(*beside) < LATER * at).any())


def _pairs(uv: Floats) -> list[tuple[int, int]]:
    """All pairs of cameras, those that share most frames of (C, F, K, 2) first."""
    seen = np.isfinite(uv).all((2, 3))
    shared = np.einsum("if,jf->ij", seen, seen, dtype=np.int64)
    return sorted(combinations(range(len(uv)), 2), key=lambda pair: -shared[pair])


def _chain(pairs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """C − 1 of all pairs of cameras, of which the first is known from the pairs before, the first in order."""
    known, chain = {pairs[0][0]}, list[tuple[int, int]]()
    while new := next((pair for pair in pairs if (pair[0] in known) != (pair[1] in known)), None):
        chain.append(new if new[0] in known else new[::-1])
        known |= set(new)
    return chain


def pair_delay(a: Floats, b: Floats, good: float = np.inf) -> float | None:
    """By how many images b (F, K, 2) was taken later than a, by (2) and (3); None where the wand does not tell.

    S must be `good`, px², there, or, if it is so nowhere, `UNLIKE` times less than as they are: a wand may look much
    the same at another time, and another's images look a little like it at some.
    """
    found = [(np.inf, 0.0)]
    for most in WITHIN:
        found.append(_delay_within(a, b, min(most, len(a) // 4)) or found[0])
        if found[-1][0] <= good:
            break
    least, delay = min(found)
    return delay if least <= max(good, _cost(a, b, 0.0, QUICK) / UNLIKE) else None


def _delay_within(a: Floats, b: Floats, most: int) -> tuple[float, float] | None:
    """S, px², and the delay at which it is least, of so many images at most; None where the wand does not tell."""
    if (whole := _whole_delay(a, b, most)) is None:
        return None
    best, at_whole = whole, _cost(a, b, whole)
    for step in STEPS:
        before, at, after = (_cost(a, b, best + s) for s in (-step, 0.0, step))
        bend = before - 2 * at + after
        if not bend > 0:  # nan where the recording ends there
            break
        best += float(np.clip(step * (before - after) / (2 * bend), -step, step))  # (3)
    least = _cost(a, b, best)
    return (least, best) if least * PARTS < at_whole else (at_whole, whole)


def _whole_delay(a: Floats, b: Floats, most: int) -> float | None:
    """The delay in whole images at which S is least; None where it is not clear, or may be beyond."""
    shifts = np.arange(-most, most + 1)
    costs = np.array([_cost(a, b, float(d), QUICK) for d in shifts])
    if not np.isfinite(costs).any():
        return None
    best = int(np.nanargmin(costs))
    clear = 0 < best < 2 * most and costs[best] * CLEAR < np.nanmedian(costs)
    return float(shifts[best]) if clear else None


def _costs(uv: Floats, chain: list[tuple[int, int]], delay: float) -> Floats:
    """S of the pairs of a chain (C − 1), from few samples."""
    return np.array([_cost(uv[a], uv[b], delay, QUICK) for a, b in chain])


def _cost(a: Floats, b: Floats, delay: float, samples: int = SAMPLES) -> float:
    """S by (2), of a matrix from so many samples; NaN where cameras share too little at this delay."""
    b = at_times(b, delay)
    both = np.flatnonzero(np.isfinite(a).all((1, 2)) & np.isfinite(b).all((1, 2)))
    if len(both) < FEWEST:
        return np.nan
    both = both[evenly(len(both), LOOKED_AT)]
    try:
        cost = np.sort(np.minimum(*epipolar_costs(a[both], b[both], samples)))
    except KinemarkError:  # the cameras are in one place
        return np.nan
    return float(cost[: max(int(BETTER * len(cost)), 1)].mean())


def at_times(uv: Floats, delay: float) -> Floats:
    """Markers (F, K, 2) of a camera that is late by so many images at the times of the frames, by (1)."""
    whole = round(delay)
    s = whole - delay
    at = in_later_frames(uv, whole)
    if s == 0:
        return at
    before, after = (_alike(in_later_frames(uv, whole + k), at) for k in (1, -1))
    return at + s * (after - before) / 2 + s**2 * (after - 2 * at + before) / 2


def _alike(uv: Floats, near: Floats) -> Floats:
    """Markers (F, K, 2) in the order in which they are nearer to those of another image."""
    turned = uv[:, ::-1]
    other = ((turned - near) ** 2).sum((1, 2)) < ((uv - near) ** 2).sum((1, 2))
    return np.where(other[:, None, None], turned, uv)
