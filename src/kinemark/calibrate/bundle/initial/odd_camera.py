"""Which camera keeps all from fitting each other: late, mirrored, another one's, or moved.

Cameras are left out in turn, the most suspect first: those whose pairs fit a fundamental matrix worst (late, another
one's), and each alone give the stick the most different lengths, or no place before both cameras (mirrored),

    (median of the pairs' residuals) · (median of their spreads of ln(length))        (1)

The first is named without which the others, guessed anew (`growth`), fit as well as two cameras alone do; of three, it
must be the only one, as two cameras that are left may fit each other with a wrong one among them.
"""

from __future__ import annotations

import numpy as np

from ....data import KinemarkError
from ....data.array_types import Floats
from .growth import GOOD, TargetViews, best_start, check_connected, noise_of, thinned
from .seeds import stick_seeds
from .view_pairs import Pair, find_pairs

SUSPECTS = 4  # cameras that are left out at most; chosen for speed: the wrong one is nearly always the first
TRIES = 2  # beginnings without each of them at most; chosen for speed


def odd_camera(views: TargetViews, *, seed: int = 0) -> str | None:
    """The name of the camera without which the others fit each other's sticks; None where there is no such one."""
    if len(views.optics) < 3:
        return None
    views = thinned(views)
    optics, pairs = find_pairs(views.optics, views.uv, seed=seed)
    views = views._replace(optics=optics)
    suspects = np.argsort(-_suspicion(views, pairs), kind="stable")[:SUSPECTS]
    noise = min((noise_of(left) for c in suspects if (left := _without(pairs, c))), default=0.0)
    odd = (optics[c].camera.name for c in suspects if _fit_without(views, pairs, c, GOOD * noise))
    first = next(odd, None)
    return None if len(optics) == 3 and next(odd, None) else first


def _suspicion(views: TargetViews, pairs: list[Pair]) -> Floats:
    """(C) by (1); the spread is 1 where nothing fits."""
    assert views.along is not None
    each = np.full((len(views.optics), len(pairs), 2), np.nan)
    for i, pair in enumerate(pairs):
        seeds = stick_seeds(views.optics, pair, views.poses, views.along)
        each[[pair.a, pair.b], i] = pair.scale, min((seed.score for seed in seeds), default=1.0)
    return np.asarray(np.nanmedian(each, axis=1).prod(1))


def _without(pairs: list[Pair], c: int) -> list[Pair]:
    """The pairs of the other cameras, numbered without camera c."""
    return [p._replace(a=p.a - (p.a > c), b=p.b - (p.b > c)) for p in pairs if c not in (p.a, p.b)]


def _fit_without(views: TargetViews, pairs: list[Pair], c: int, limit: float) -> bool:
    """Whether the others fit within `limit`, px."""
    rest = [i for i in range(len(views.optics)) if i != c]
    some = TargetViews([views.optics[i] for i in rest], views.uv[rest], views.along)
    try:
        check_connected(some)
        return best_start(some, _without(pairs, c), tries=TRIES).scale <= limit
    except KinemarkError:
        return False
