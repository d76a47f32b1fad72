"""Paths of two cameras brought together in space (KISS section 4, "3D spatial matching").

An image in each camera gives the four DLT equations of KISS eq. 7 for three unknowns. Three of them are solved and the
fourth tells how badly the two images fit. The first two are the ray of the image (u₁, v₁), the third is a plane,

    X(λ) = C + λ M₁⁻¹ (u₁, v₁, 1),   C = −M₁⁻¹ m₁,   P₁ = [M₁ | m₁]                      (1)
    (p₁ − u₂ p₃) · (X, 1) = 0                                                            (2)

with the rows p of the second camera, so λ follows from one division, and the residual of the fourth, divided by the
depth p₃ · (X, 1) to be in px, is

    r = v₂ − p₂ · (X, 1) / p₃ · (X, 1)                                                   (3)

It is formed for all combinations of paths in every field. One field would do if no other marker came near; all of them
verify what was followed in the images. |r| is cut at twice the limit, so that one outlying field does not decide.

Two paths that came close in one camera may have gone on in each other's place. Then two pairs (a, b), (a', b') fit
better crosswise for some time,

    gain = Σ_f |r_ab| + |r_a'b'| − |r_ab'| − |r_a'b|                                     (4)

over the fields in which it is greatest. Where that is clearly above nothing, the two paths are swapped there in the
camera in which they were closer to each other when it began and ended (5).

A track is a pair of paths and the time in which Σ (limit − |r|) is greatest, the best of all first; its fields are
used, and what is left of both paths can be in another pair (6). So a path that went wrong is split and not believed.

As in the paper the fourth equation is that of v₂, so the second camera must stand beside the first one. If it stands
above it, (2) and the ray are nearly parallel and (3) says little.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints
from ...signal import assign_nearest
from .image_paths import FAR, Paths

AROUND = 3
"""Fields about a moment in which two paths are compared, of (5); chosen."""


class Paired(NamedTuple):
    """N points in the order of their fields: frame, path in each camera, and identity, all (N)."""

    frame: Ints
    one: Ints
    other: Ints
    id: Ints


class PathSwap(NamedTuple):
    """Two pairs that fit better crosswise in the fields first … stop − 1, and by how much in all, px."""

    gain: float
    first: int
    stop: int
    pairs: tuple[tuple[int, int], tuple[int, int]]


def residuals(one: Floats, other: Floats, P: Floats) -> Floats:
    """|r| (A, B, F) px of (3) for paths one (A, F, 2) and other (B, F, 2) in ideal px; inf where there is none."""
    inverse = np.linalg.inv(P[0, :, :3])
    C = -inverse @ P[0, :, 3]
    d = np.concatenate([one, np.ones_like(one[..., :1])], -1) @ inverse.T  # (1)  (A, F, 3)
    plane = P[1, 0] - other[..., :1] * P[1, 2]  # (2)  (B, F, 4)
    with np.errstate(invalid="ignore", divide="ignore"):
        lam = -(plane[..., :3] @ C + plane[..., 3]) / np.einsum("afk,bfk->abf", d, plane[..., :3])
        X = np.concatenate([C + lam[..., None] * d[:, None], np.ones((*lam.shape, 1))], -1)
        depth = X @ P[1, 2]
        r = np.abs(other[None, ..., 1] - X @ P[1, 1] / depth)  # (3)
        ahead = (lam > 0) & (depth > 0)  # λ is the depth in the first camera
    return np.where(ahead & np.isfinite(r), r, np.inf)


def without_swaps(one: Paths, other: Paths, P: Floats, *, limit: float, window: float) -> tuple[Paths, Paths]:
    """The paths, with those swapped that went on in each other's place, (4) and (5).

    Args:
        one: paths of the first camera.
        other: of the second.
        P: (2, 3, 4) of both.
        limit: of the residual, px.
        window: two paths can only have been mistaken for each other within twice this, px.
    """
    one, other = (Paths(paths.uv.copy(), paths.detection.copy()) for paths in (one, other))
    if not len(one.uv) or not len(other.uv):
        return one, other
    for _ in range(4 * len(one.uv)):  # each swap lessens the sum of residuals; the bound is only a bound
        r = np.minimum(residuals(one.uv, other.uv, P), 2 * limit)
        a, b = assign_nearest(r.mean(2), np.full(len(r), FAR))
        pairs = sorted(zip(a.tolist(), b.tolist(), strict=True))
        found = (_crosswise(r, two) for two in combinations(pairs, 2))
        for swap in sorted(found, key=lambda e: -e.gain):
            if swap.gain <= 4 * limit:
                return one, other
            if _swap_paths(one, other, swap, 2 * window):
                break
        else:
            return one, other
    return one, other


def paired(r: Floats, *, limit: float, shortest: int) -> Paired:
    """The tracks by (6), from residuals (A, B, F) px, numbered in the order in which they begin."""
    margin = limit - np.minimum(r, 2 * limit)
    points: list[tuple[int, int, int]] = []
    while margin.size:
        total, first, stop = best_interval(margin)
        a, b = np.unravel_index(int(total.argmax()), total.shape)
        own = np.arange(first[a, b], stop[a, b])
        own = own[margin[a, b, own] > 0]
        if len(own) < shortest:
            break
        points += [(int(f), int(a), int(b)) for f in own]
        margin[a, :, own] = margin[:, b, own] = -limit
    frame, one, other = np.array(sorted(points), np.int64).reshape(-1, 3).T
    pair = one * r.shape[1] + other
    known, begin = np.unique(pair, return_index=True)
    number = np.empty(len(known), np.int64)
    number[np.argsort(begin)] = np.arange(len(known))
    return Paired(frame, one, other, number[np.searchsorted(known, pair)] if len(pair) else pair)


def best_interval(value: Floats) -> tuple[Floats, Ints, Ints]:
    """Of series (…, F) the stretch with the greatest sum: the sum, its first field, and the one after its last."""
    total = np.concatenate([np.zeros((*value.shape[:-1], 1)), np.cumsum(value, -1)], -1)
    least = np.minimum.accumulate(total, -1)
    stop = (total - least).argmax(-1)
    until = np.where(np.arange(total.shape[-1]) <= stop[..., None], total, np.inf)
    first = until.argmin(-1)
    at = np.take_along_axis(total, np.stack([first, stop], -1), -1)
    return at[..., 1] - at[..., 0], first, stop


def _crosswise(r: Floats, pairs: tuple[tuple[int, int], tuple[int, int]]) -> PathSwap:
    """Where two pairs are better swapped, by (4)."""
    (a, b), (c, d) = pairs
    gain, first, stop = best_interval(r[a, b] + r[c, d] - r[a, d] - r[c, b])
    return PathSwap(float(gain), int(first), int(stop), pairs)


def _swap_paths(one: Paths, other: Paths, swap: PathSwap, near: float) -> bool:
    """Swap two paths in the camera in which they were closer (5); False where they were not near in either."""
    (a, b), (c, d) = swap.pairs
    n_fields = one.uv.shape[1]
    ends = [f for f in (swap.first, swap.stop) if 0 < f < n_fields]
    apart = [
        max((_least_apart(paths, i, j, f) for f in ends), default=np.inf)
        for paths, i, j in ((one, a, c), (other, b, d))
    ]
    if min(apart) > near:
        return False
    paths, i, j = (one, a, c) if apart[0] <= apart[1] else (other, b, d)
    own = slice(swap.first, swap.stop)
    for column in paths:
        column[[i, j], own] = column[[j, i], own]
    return True


def _least_apart(paths: Paths, i: int, j: int, f: int) -> float:
    """Least distance px of two paths within some fields of f; the residuals do not tell to the field when it was."""
    span = slice(max(f - AROUND, 0), f + AROUND + 1)
    apart = np.linalg.norm(paths.uv[i, span] - paths.uv[j, span], axis=-1)
    return float(np.nanmin(apart)) if np.isfinite(apart).any() else np.inf
