"""Choosing places for cameras among candidates.

Camera c sees place i with the derivative J_ci of its image by the place, and knows it by J_ciᵀ J_ci / s². Together with
what is known before, that it is within the room, σ₀, a place is off along each axis by

    e_i = √(trace (Σ_c J_ciᵀ J_ci / s² + 1 / σ₀²)⁻¹ / 3)                 (1)

which is near σ₀ where no camera sees it. The cameras are to make

    mean e_i + p · (share of places that fewer than three cameras see)   (2)

small, since what only two see cannot be told from a false pair by a third. As (1) sums over cameras, all candidates for
one camera are judged at once: each camera in turn is added where (2) falls most (greedy), then each in turn is moved to
where it is least, until none moves (exchange; Fedorov 1972, for designs of experiments).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import Camera
from ..data.array_types import Bools, Floats
from ..geometry import point_jacobian

UNKNOWN_MM = 20.0
"""σ₀ of (1), mm: what a place costs that is not measured; chosen."""
PAIR_MM = 1.0
"""p of (2), mm: what it costs that no third camera confirms a place; chosen."""
SWEEPS = 6
"""Rounds of exchange at most; chosen: it ends by itself after two to four."""
APART_MM = 400.0
"""Least distance of two cameras that are placed; chosen."""
EQUAL = 1e-5
"""Share by which two costs may differ and count as one, so that rounding does not choose; chosen above that of single
precision."""


class Candidates(NamedTuple):
    """K cameras and what each would know of N places: information (6, K, N) 1/mm² in the order xx, xy, xz, yy, yz, zz,
    in single precision, which is enough to choose by; seen (K, N); centres (K, 3) mm."""

    cameras: tuple[Camera, ...]
    information: NDArray[np.float32]
    seen: Bools
    centres: Floats


def judged(cameras: Sequence[Camera], seen: Bools, xyz: Floats, *, centroid_sd: float) -> Candidates:
    """Cameras that see (K, N) of places (N, 3) mm, for centroids of `centroid_sd` px."""
    information = np.zeros((6, len(cameras), len(xyz)), np.float32)
    for k, camera in enumerate(cameras):
        J = point_jacobian(camera, xyz[seen[k]])
        pairs = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
        for entry, (i, j) in enumerate(pairs):
            information[entry, k, seen[k]] = (J[..., i] * J[..., j]).sum(-1) / centroid_sd**2
    return Candidates(tuple(cameras), information, seen, np.array([c.centre for c in cameras]).reshape(-1, 3))


def cost(information: NDArray[np.float32], count: Floats, weight: Floats) -> Floats:
    """(…) mm by (2), of information (6, …, N) and cameras (…, N), the places weighted by (N), which sum to 1."""
    a, b, c, d, e, f = information
    a, d, f = (part + np.float32(UNKNOWN_MM**-2) for part in (a, d, f))
    first, second, third = d * f - e * e, a * f - c * c, a * d - b * b
    det = a * first + b * (c * e - b * f) + c * (b * e - c * d)
    off = np.sqrt((first + second + third) / (3 * det))  # (1)
    return np.asarray((off + PAIR_MM * (count < 3)) @ weight)  # (2)


def choose(found: Candidates, weight: Floats, n: int, *, given: Candidates | None = None) -> list[int]:
    """Indices of n candidates that make (2) small together with the cameras given, which stay where they are.

    Args:
        found: the candidates.
        weight: (N) of the places, which sum to 1.
        n: how many to choose; fewer come back where no further candidate is apart from the others.
        given: cameras that stand already, judged at the same places.
    """
    base = np.zeros((6, len(weight)), np.float32) if given is None else given.information.sum(1)
    count = np.zeros(len(weight)) if given is None else given.seen.sum(0).astype(np.float64)
    fixed = np.zeros((0, 3)) if given is None else given.centres
    chosen: list[int] = []
    for _ in range(n):
        best = _best(found, weight, base, count, fixed, chosen)
        if best is None:
            return chosen
        chosen.append(best)
    for _ in range(SWEEPS):
        before = list(chosen)
        for k in range(len(chosen)):
            best = _best(found, weight, base, count, fixed, chosen[:k] + chosen[k + 1 :])
            chosen[k] = chosen[k] if best is None else best
        if chosen == before:
            break
    return chosen


def _best(
    found: Candidates,
    weight: Floats,
    base: NDArray[np.float32],
    count: Floats,
    fixed: Floats,
    others: Sequence[int],
) -> int | None:
    """The candidate that makes (2) least beside the others and what is fixed; None where none is apart from them."""
    others = list(others)
    stand = np.concatenate([fixed, found.centres[others]])
    near = (np.linalg.norm(found.centres[:, None] - stand, axis=-1) < APART_MM).any(1)
    if near.all():
        return None
    known = base + found.information[:, others].sum(1)
    seen = count + found.seen[others].sum(0)
    costs = np.where(near, np.inf, cost(known[:, None] + found.information, seen + found.seen, weight))
    return int((costs <= costs.min() * (1 + EQUAL)).argmax())
