"""Where to begin: focal lengths and the pose of a pair of cameras, from its fundamental matrix and a grid.

F and the focal lengths f₁, f₂ give E = K₂ᵀ F K₁ and with it a pose and points up to scale. F alone hardly tells f₁ and
f₂ where optical axes meet, as they do in every laboratory (the formula of Bougnoux 1998 is 0 / 0 there). So they are
looked for on a grid:

- where a stick is seen, all its images must have one length: least spread of ln(length) (1);
- where only points are seen, a third camera must have square pixels and its centre in the middle of its image: its
  projection P = K [R | t] from a DLT on the pair's points has least

      (ln(K₂₂ / K₁₁) / 0.05)² + (K₁₂ / f / 0.05)² + |c / f|² / 0.1²      (2)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data.array_types import Floats, Ints
from ....geometry.two_view import essential, midpoints, relative_pose
from ....numerics.evenly import evenly
from ....numerics.vectors import homogeneous
from ..parts import complete
from .unknown_optics import UnknownOptics
from .view_pairs import FEWEST_COMMON, Pair

FOCI = np.geomspace(0.45, 4.0, 14)
"""Focal lengths that are tried, in image widths; chosen (see benchmarks/bundle.py)."""
FEWEST_STICKS = 8  # that fit a pair's F; chosen: of twelve that the pair must share
JUDGES = 60  # points that a beginning is judged by at most; chosen for speed
BY_STICKS = 3  # beginnings of a pair that are tried, at most, by (1); chosen
BY_POINTS = 4  # beginnings of a pair that are tried, at most, by (2); chosen
CHECK_CAMERAS = 3  # further cameras that a beginning is judged by; chosen for speed


class Seed(NamedTuple):
    """A guess where to begin: a pair with focal lengths, px, the pose of its second camera, and how bad it looks."""

    pair: Pair
    f: tuple[float, float]
    R: Floats
    t: Floats
    score: float


def _poses(
    optics: list[UnknownOptics], pair: Pair, x: Floats, y: Floats
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """The grid's f₁ and f₂ (G), poses R (G, 3, 3), t (G, 3), and points (G, n, 3) in the first camera's frame."""
    f1, f2 = (g.ravel() for g in np.meshgrid(FOCI * _width(optics[pair.a]), FOCI * _width(optics[pair.b])))
    K1, K2 = (np.stack([f, f, np.ones_like(f)], -1)[..., None] * np.eye(3) for f in (f1, f2))
    xn, yn = x / f1[:, None, None], y / f2[:, None, None]
    R, t = relative_pose(essential(pair.F, K1, K2), xn, yn)
    xyz, d1, d2 = midpoints(R, t, xn, yn)
    return f1, f2, R, t, np.where(((d1 > 0) & (d2 > 0))[..., None], xyz, np.nan)


def _width(optics: UnknownOptics) -> float:
    return float(optics.camera.size.max())


def stick_seeds(optics: list[UnknownOptics], pair: Pair, uv: Floats, along: Floats) -> list[Seed]:
    """The most likely focal lengths of a pair by (1), from sticks seen at uv (C, F, K, 2)."""
    K, (i, j) = len(along), (int(along.argmin()), int(along.argmax()))
    good = pair.good.reshape(-1, K)
    rows = np.flatnonzero(good[:, i] & good[:, j])
    if len(rows) < FEWEST_STICKS:
        return []
    rows = _evenly(rows)
    x, y = (optics[c].ideal(np.concatenate([uv[c, rows, i], uv[c, rows, j]])) for c in (pair.a, pair.b))
    f1, f2, R, t, xyz = _poses(optics, pair, x, y)
    length = np.log(np.linalg.norm(xyz[:, : len(rows)] - xyz[:, len(rows) :], axis=-1))
    behind = np.isnan(length).mean(1)
    length = np.where(np.isnan(length), 0.0, length)
    median = np.median(length, axis=1)
    spread = np.median(np.abs(length - median[:, None]), axis=1) + behind  # (1)
    size = float(np.ptp(along)) / np.exp(median)
    chosen = _minima(spread.reshape(len(FOCI), len(FOCI)))[:BY_STICKS]
    return [Seed(pair, (float(f1[g]), float(f2[g])), R[g], size[g] * t[g], float(spread[g])) for g in chosen]


def point_seeds(optics: list[UnknownOptics], pair: Pair, uv: Floats) -> list[Seed]:
    """The most likely focal lengths of a pair by (2), from points seen at uv (C, N, 2) by other cameras too."""
    seen = complete(uv) & pair.good
    seen[[pair.a, pair.b]] = False
    others = [int(c) for c in np.argsort(-seen.sum(1), kind="stable")[:CHECK_CAMERAS] if seen[c].sum() >= FEWEST_COMMON]
    score = np.zeros(len(FOCI) ** 2)
    for c in others:
        rows = _evenly(np.flatnonzero(seen[c]))
        x, y = (optics[i].ideal(uv[i, rows]) for i in (pair.a, pair.b))
        f1, f2, R, t, xyz = _poses(optics, pair, x, y)
        score += pixel_shape_error(projections(xyz, optics[c].ideal(uv[c, rows]) / _width(optics[c]))) / len(others)
    chosen = _minima(score.reshape(len(FOCI), len(FOCI)))[:BY_POINTS] if others else []
    return [Seed(pair, (float(f1[g]), float(f2[g])), R[g], t[g], float(score[g])) for g in chosen]


def _evenly(rows: Ints) -> Ints:
    """At most `JUDGES` of them."""
    return rows[evenly(len(rows), JUDGES)]


def known_focus_seed(optics: list[UnknownOptics], pair: Pair, uv: Floats) -> Seed:
    """A beginning with the focal lengths that the lenses came with."""
    f1, f2 = (float(optics[c].camera.K[0, 0]) for c in (pair.a, pair.b))
    E = essential(pair.F, np.diag([f1, f1, 1.0]), np.diag([f2, f2, 1.0]))
    x, y = (optics[c].ideal(uv[c, pair.good]) / f for c, f in ((pair.a, f1), (pair.b, f2)))
    return Seed(pair, (f1, f2), *relative_pose(E, x, y), pair.scale)


def projections(xyz: Floats, xy: Floats) -> Floats:
    """(G, 3, 4) DLT of G sets of points (G, n, 3) at images (n, 2) or (G, n, 2); trimmed once of what fits worst."""
    there = complete(xyz)
    n = np.minimum(np.maximum(there.sum(1), 1), xyz.shape[1] - 1)[:, None]
    X = np.where(there[..., None], xyz, 0.0)
    centre = X.sum(1, keepdims=True) / n[..., None]
    X = np.where(there[..., None], X - centre, 0.0)
    size = np.sqrt((X**2).sum((1, 2), keepdims=True) / (3 * n[..., None])) + 1e-300
    Xh = homogeneous(X / size)
    zero = np.zeros_like(Xh)
    A = np.stack(
        [np.concatenate([Xh, zero, -xy[..., :1] * Xh], -1), np.concatenate([zero, Xh, -xy[..., 1:] * Xh], -1)], 2
    )
    weight = there.astype(np.float64)
    for _ in range(3):
        rows = (A * weight[..., None, None]).reshape(len(A), -1, 12)
        P = np.linalg.eigh(rows.transpose(0, 2, 1) @ rows)[1][..., 0].reshape(-1, 3, 4)
        image = Xh @ P.transpose(0, 2, 1)
        residual = np.linalg.norm(
            image[..., :2] / (np.abs(image[..., 2:]) + 1e-12) * np.sign(image[..., 2:]) - xy, axis=-1
        )
        typical = np.take_along_axis(np.sort(np.where(there, residual, np.inf), axis=1), n // 2, axis=1)
        weight = (there & (residual <= 4 * typical)).astype(np.float64)
    T = np.zeros((len(P), 4, 4))
    T[:, :3, :3] = np.eye(3) / size
    T[:, :3, 3] = -(centre / size)[:, 0]
    T[:, 3, 3] = 1.0
    return np.asarray(P @ T)


def pixel_shape_error(P: Floats) -> Floats:
    """(2) of projections (G, 3, 4)."""
    M = P[..., :3]
    M = M / np.linalg.norm(M[..., 2:, :], axis=-1, keepdims=True)
    u, v, w = M[..., 0, :], M[..., 1, :], M[..., 2, :]
    cx, cy = (u * w).sum(-1), (v * w).sum(-1)
    fy = np.sqrt(np.maximum((v * v).sum(-1) - cy**2, 1e-12))
    skew = ((u * v).sum(-1) - cx * cy) / fy
    fx = np.sqrt(np.maximum((u * u).sum(-1) - cx**2 - skew**2, 1e-12))
    f = np.sqrt(fx * fy)
    bad = (np.log(fy / fx) / 0.05) ** 2 + (skew / f / 0.05) ** 2 + (cx**2 + cy**2) / f**2 / 0.1**2
    return np.where(np.isfinite(bad), np.minimum(bad, 1e6), 1e6)  # (2)


def _minima(table: Floats) -> list[int]:
    """Flat places of the table's local minima, the least first."""
    padded = np.pad(table, 1, constant_values=np.inf)
    around = [padded[1 + i : 1 + i + len(table), 1 + j : 1 + j + len(table)] for i in (-1, 0, 1) for j in (-1, 0, 1)]
    rows = np.flatnonzero(table <= np.min(around, axis=0))
    return [int(g) for g in rows[np.argsort(table.ravel()[rows])]]
