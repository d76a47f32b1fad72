"""The world in which a calibrated rig is to stand: its scale, its origin and its axes.

A similarity X' = s A X + b, with A a rotation, leaves every image as it is if each camera becomes

    R' = R Aᵀ,   t' = s t − R' b                                         (1)

for then R' X' + t' = s (R X + t). K and the lens stay. Errors of the parameters follow by the derivative of (1): with
R ← exp([r]×) R,

    r' = r,   d t' = s d t + [R' b]× r                                   (2)

so that a covariance Σ becomes M Σ Mᵀ (3), with M all ones on the diagonal but for (2). The similarity itself is
taken as exact: it says what the world is.

A, b and s are those that lay seen points on known ones with the least squares (Umeyama 1991): with both about their
means, x and y, Σ y xᵀ = U D Vᵀ,

    A = U diag(1, 1, |U Vᵀ|) Vᵀ,   s = trace(D diag(1, 1, |U Vᵀ|)) / Σ |x|²   (4)

An L-frame lies on the floor, a corner marker and one or more on each of two arms at right angles. Which marker is which
follows from the distances between them. X runs along the long arm, Z up, to the side where the cameras are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np
from numpy.typing import ArrayLike

from ..data import Camera, KinemarkError, Rig
from ..data.array_types import Floats
from ..numerics.vectors import cross_matrix
from .bundle import BundleFit

MISFIT = 0.1
MOST = 12
CLEAR = 1e-3


def scaled(rig: Rig, factor: float) -> Rig:
    """The rig with all lengths times `factor`: known distance / distance found.

    Raises:
        ValueError: the factor is not a positive number.
    """
    if not 0 < factor < np.inf:
        raise ValueError(f"factor is {factor}, wanted a number above 0")
    return _transformed(rig, np.eye(3), np.zeros(3), float(factor))


def moved_to(rig: Rig, seen: Floats, known: Floats, *, scale: bool = False) -> Rig:
    """The rig in the world where points seen at (M, 3) are, as nearly as possible, at known places (M, 3) mm.

    Args:
        rig: in any world.
        seen: (M, 3) in the rig's world; rows with NaN in either are passed over.
        known: (M, 3) the same points in the world that is wanted, mm.
        scale: whether lengths may change; else they stay and only a motion is made.

    Raises:
        ValueError: the shapes differ.
        KinemarkError: fewer than three points, points on a line, or known distances that are not those seen.
    """
    return _transformed(rig, *similarity(seen, known, scale=scale))


def fit_scaled(fit: BundleFit, factor: float) -> BundleFit:
    """`scaled` for all of a bundle adjustment's result."""
    return _with_world(fit, scaled(fit.rig, factor), np.eye(3), np.zeros(3), factor)


def fit_moved_to(fit: BundleFit, seen: Floats, known: Floats, *, scale: bool = False) -> BundleFit:
    """`moved_to` for all of a bundle adjustment's result."""
    A, b, s = similarity(seen, known, scale=scale)
    return _with_world(fit, _transformed(fit.rig, A, b, s), A, b, s)


def similarity(seen: Floats, known: Floats, *, scale: bool = False) -> tuple[Floats, Floats, float]:
    """A (3, 3), b (3) and s of (4) with known ≈ s A seen + b; s is 1 unless `scale`. Errors as in `moved_to`."""
    if seen.shape != known.shape or seen.ndim != 2 or seen.shape[1] != 3:
        raise ValueError(f"seen has shape {seen.shape} and known {known.shape}, wanted (points, 3) of both")
    both = np.isfinite(seen).all(1) & np.isfinite(known).all(1)
    a, b = seen[both], known[both]
    x, y = a - a.mean(0, keepdims=True) if len(a) else a, b - b.mean(0, keepdims=True) if len(b) else b
    for points, what in ((x, "seen"), (y, "known")):
        spread = np.linalg.svd(points, compute_uv=False) if len(points) >= 3 else np.zeros(3)
        if not spread[1] > CLEAR * spread[0]:
            raise KinemarkError(
                f"{len(a)} points, {what} in one place or on one line, do not fix a world. Show at least three markers "
                "that form a triangle."
            )
    U, D, Vt = np.linalg.svd(y.T @ x)
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))])
    A = (U * signs) @ Vt  # (4)
    grown = float((D * signs).sum() / (x**2).sum())
    s = grown if scale else 1.0
    off, size = np.sqrt(((s * x @ A.T - y) ** 2).sum(1).mean()), np.sqrt((y**2).sum(1).mean())
    if off > MISFIT * size:
        raise KinemarkError(
            f"Known points differ from those seen by {off:.0f} mm RMS, and are only {size:.0f} mm from their middle. "
            f"Their sizes are as {grown:.3g} to 1. Check which point is which, the units, and whether scale is free."
        )
    return A, b.mean(0) - s * A @ a.mean(0), s


def l_frame(
    rig: Rig,
    xyz: Floats,
    *,
    long: float | Sequence[float],
    short: float | Sequence[float],
    height: float = 0.0,
    tolerance: float = 0.02,
    scale: bool = False,
    cameras_above: bool = True,
) -> Floats:
    """Where the markers of an L-frame are in its world, (M, 3) mm, for `moved_to`; NaN for points that are none of it.

    Args:
        rig: the cameras; most of them are above the floor.
        xyz: (M, 3) points that were seen, of which some are the L-frame's.
        long: distance of the marker on the long arm from the corner, or of several, mm. X runs along it.
        short: the same of the short arm.
        height: of the markers' centres above the floor, mm.
        tolerance: share of the longest distance by which the others may be off.
        scale: whether only the distances' proportions are right, as after `calibrate_points`.
        cameras_above: whether Z points to the side of the L-frame's plane on which the cameras are, else away.

    Raises:
        ValueError: a distance is not positive, or the arms have markers at the same distances.
        KinemarkError: the L-frame is not among the points, or more than once.
    """
    arms = np.atleast_1d(np.asarray(long, np.float64)), np.atleast_1d(np.asarray(short, np.float64))
    if any(not (arm > 0).all() or len(np.unique(arm)) < len(arm) for arm in arms) or set(arms[0]) == set(arms[1]):
        raise ValueError(f"arms are {arms[0].tolist()} and {arms[1].tolist()} mm, wanted different distances above 0")
    model = np.zeros((1 + len(arms[0]) + len(arms[1]), 3))
    model[1 : 1 + len(arms[0]), 0] = arms[0]
    model[1 + len(arms[0]) :, 1] = arms[1]
    rows = _recognised(xyz, model, tolerance, scale)
    A, b, s = similarity(xyz[rows], model, scale=scale)
    centres = s * rig.centres @ A.T + b
    if (np.median(centres[:, 2]) > 0) != cameras_above:
        model[:, 1] *= -1  # the short arm lies to the other side
    known = np.full((len(xyz), 3), np.nan)
    known[rows] = model + np.array([0.0, 0.0, height])
    return known


def _recognised(xyz: Floats, model: Floats, tolerance: float, scale: bool) -> list[int]:
    """Which points (M, 3) are the model's (m, 3), by the distances between them."""
    there = np.flatnonzero(np.isfinite(xyz).all(1))
    if not len(model) <= len(there) <= MOST:
        raise KinemarkError(
            f"{len(there)} points are seen, and the L-frame has {len(model)} markers. Show it to the cameras alone "
            f"(at most {MOST} points)."
        )
    wanted = _distances(model)
    choices = np.array(list(permutations(there, len(model))))
    found = _distances(xyz[choices])
    if scale:
        found = found * ((found * wanted).sum(-1) / np.maximum((found**2).sum(-1), 1e-300))[:, None]
    off = np.abs(found - wanted).max(-1) / wanted.max()
    best = np.argsort(off)[:2]
    if not off[best[0]] <= tolerance:
        raise KinemarkError(
            f"No {len(model)} of {len(there)} points have the L-frame's distances: the best are off by "
            f"{off[best[0]] * wanted.max():.1f} mm. Check its lengths, and that all its markers are seen."
        )
    if len(best) > 1 and off[best[1]] <= tolerance:
        raise KinemarkError(
            "The L-frame's markers can be taken in two ways: its distances are too much alike, or there are points "
            "beside it. Use arms of unequal lengths, or a smaller tolerance."
        )
    return [int(i) for i in choices[best[0]]]


def _distances(points: Floats) -> Floats:
    """(…, m (m − 1) / 2) between all pairs of points (…, m, 3)."""
    i, j = np.triu_indices(points.shape[-2], 1)
    return np.asarray(np.linalg.norm(points[..., i, :] - points[..., j, :], axis=-1))


def carried(camera: Camera, A: ArrayLike, b: ArrayLike, s: float) -> tuple[Camera, Floats]:
    """The camera after (1), and M (15, 15) of (3)."""
    R = camera.R @ np.asarray(A, np.float64).T
    lever = R @ np.asarray(b, np.float64)
    M = np.eye(15)
    M[12:15, 12:15] *= s
    M[12:15, 9:12] = cross_matrix(lever)  # (2)
    return replace(camera, R=R, t=s * camera.t - lever, cov=M @ camera.cov @ M.T), M


def _transformed(rig: Rig, A: Floats, b: Floats, s: float) -> Rig:
    corners = np.array(np.meshgrid(*rig.volume.T, indexing="ij")).reshape(3, -1).T
    moved = s * corners @ A.T + b
    cameras = tuple(carried(camera, A, b, s)[0] for camera in rig)
    return Rig(cameras, rig.method, np.stack([moved.min(0), moved.max(0)]))


def _with_world(fit: BundleFit, rig: Rig, A: Floats, b: Floats, s: float) -> BundleFit:
    xyz = s * fit.xyz @ A.T + b
    there = xyz[np.isfinite(xyz).all(1)]
    rig = replace(rig, volume=np.stack([there.min(0), there.max(0)]))
    M = np.zeros_like(fit.joint)
    for c, camera in enumerate(fit.rig):
        at = slice(15 * c, 15 * c + 15)
        M[at, at] = carried(camera, A, b, s)[1]
    return fit._replace(rig=rig, xyz=xyz, joint=M @ fit.joint @ M.T)
