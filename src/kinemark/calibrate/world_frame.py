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
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..data import Camera, KinemarkError, Rig
from ..data.array_types import Floats
from ..numerics.vectors import cross_matrix
from .bundle import BundleFit

MISFIT = 0.1  # of the frame's size; points that are laid on each other worse are not the same; chosen
CLEAR = 1e-3  # of the longest extent; thinner, points lie on a line and give no frame; chosen


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
    A, b, s = laid_on(seen, known, scale=scale)
    both = np.isfinite(seen).all(1) & np.isfinite(known).all(1)
    x, y = (points[both] - points[both].mean(0) for points in (seen, known))
    residual = np.sqrt(((s * x @ A.T - y) ** 2).sum(1).mean())
    size = np.sqrt((y**2).sum(1).mean())
    if residual > MISFIT * size:
        grown = float(((x @ A.T) * y).sum() / (x**2).sum())
        raise KinemarkError(
            f"Known points differ from those seen by {residual:.0f} mm RMS, and are only {size:.0f} mm from their "
            f"middle. Their sizes are as {grown:.3g} to 1. Check which point is which, the units, and whether scale "
            "is free."
        )
    return A, b, s


def laid_on(seen: Floats, known: Floats, *, scale: bool = False) -> tuple[Floats, Floats, float]:
    """`similarity` of points that may fit badly.

    Raises:
        ValueError: the shapes differ.
        KinemarkError: fewer than three points, or points on a line.
    """
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
    s = float((D * signs).sum() / (x**2).sum()) if scale else 1.0
    return A, b.mean(0) - s * A @ a.mean(0), s


def carried(camera: Camera, A: ArrayLike, b: ArrayLike, s: float) -> tuple[Camera, Floats]:
    """The camera after (1), and M (15, 15) of (3)."""
    R = camera.R @ np.asarray(A, np.float64).T
    lever = R @ np.asarray(b, np.float64)
    M = np.eye(15)
    M[12:15, 12:15] *= s
    M[12:15, 9:12] = cross_matrix(lever)  # (2)
    return replace(camera, R=R, t=s * camera.t - lever, cov=M @ camera.cov @ M.T, common=M @ camera.common), M


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
