"""A camera of which little is known, from points in space, some of which it sees in the wrong place.

A DLT (`seeds.projections`) of samples of points; the one whose median distance is least, fitted again to what
is near. Its K is put back to what is assumed: the pixels' shape and the centre in the image's middle, so that only
the focal length f = √(f_x f_y) and the rotation R are taken from it. The place follows from x × (R X + t) = 0, which is
linear in t (1). Then pose, and pose with focal length and k1, by robust least squares.
"""

from __future__ import annotations

import numpy as np

from ....data import Camera
from ....data.array_types import Floats
from ....geometry import decompose
from ....numerics.robust import cauchy_weight
from ..misfit import Mirrored
from ..parts import KnownPoints, complete
from ..robust_adjustment import SOFT, solve_robust
from ..solver import BundleState, Freedom, ImageObservations
from .seeds import projections
from .unknown_optics import UnknownOptics

FOCUS = (0.3, 6.0)
"""Least and greatest focal length that is believed, in image widths; chosen (see benchmarks/bundle.py)."""

TRIALS, SAMPLE = 60, 9  # samples of points, and points of each, three more than a DLT needs; chosen
POSE = np.arange(15) >= 9  # of `data.PARAMETERS`, the six of the pose; by definition


def rough_freedom(optics: UnknownOptics, *, focus_held: bool = False) -> Freedom:
    """Pose, focal length and k1, or the lens in pixels where it is known."""
    free = POSE.copy()
    free[[0, 1]] = not focus_held
    free[4] = not optics.lens
    return Freedom(free, True, optics.lens)


def equal_covariances(uv: Floats) -> ImageObservations:
    """Points (C, N, 2) that all weigh the same."""
    return ImageObservations(uv, np.broadcast_to(np.eye(2), (*uv.shape, 2)), complete(uv))


def resected(optics: UnknownOptics, xyz: Floats, uv: Floats) -> Camera:
    """A camera from points (n, 3) that it sees at (n, 2), some of them wrong."""
    f0 = float(optics.camera.size.max())
    P = _robust_projection(xyz, optics.ideal(uv) / f0)
    K, R, _ = decompose(P, front=np.median(xyz, axis=0))
    if K[1, 1] < 0:
        raise Mirrored(optics.camera.name)
    f = f0 * float(np.clip(np.sqrt(K[0, 0] * K[1, 1]), FOCUS[0], FOCUS[1]))
    t = _translation(R, xyz, optics.ideal(uv) / f)
    state = BundleState((optics.with_focus(f, R, t),), (KnownPoints(xyz),))
    for freedom in (Freedom(POSE), rough_freedom(optics)):
        state, _ = solve_robust(state, equal_covariances(uv[None]), (freedom,), steps=15)
    return state.cameras[0]


def _translation(R: Floats, xyz: Floats, xy: Floats) -> Floats:
    """t (3) from x × (R X + t) = 0, each point weighed down as it fits badly."""
    y = xyz @ R.T
    rows = np.zeros((len(xyz), 2, 3))
    rows[:, 0, 0] = rows[:, 1, 1] = 1.0
    rows[..., 2] = -xy
    b = -(y[:, :2] - xy * y[:, 2:])
    w = np.ones(len(xyz))
    for _ in range(10):
        t = np.linalg.lstsq((rows * w[:, None, None]).reshape(-1, 3), (b * w[:, None]).ravel(), rcond=None)[0]
        residual = np.linalg.norm(rows @ t - b, axis=1)
        w = np.sqrt(cauchy_weight(residual**2, SOFT * float(np.median(residual)) + 1e-12))
    return np.asarray(t)


def _robust_projection(xyz: Floats, xy: Floats) -> Floats:
    """(3, 4) the DLT of a sample of points with the least median distance, fitted again to what is near."""
    rng = np.random.default_rng(0)
    rows = np.argsort(rng.random((TRIALS, len(xyz))), axis=1)[:, : min(SAMPLE, len(xyz))]
    P = projections(xyz[rows], xy[rows])
    misfit = _misses(P, xyz, xy)
    best = misfit[np.median(misfit, axis=1).argmin()]
    for _ in range(3):
        near = best <= 4 * np.median(best) + 1e-12
        P = projections(xyz[near][None], xy[near])
        best = _misses(P, xyz, xy)[0]
    return np.asarray(P[0])


def _misses(P: Floats, xyz: Floats, xy: Floats) -> Floats:
    """(T, n) distances of images (n, 2) from the projections P (T, 3, 4) of points (n, 3)."""
    image = np.concatenate([xyz, np.ones((len(xyz), 1))], 1) @ P.transpose(0, 2, 1)
    depth = np.where(np.abs(image[..., 2:]) > 1e-12, image[..., 2:], 1e-12)
    return np.asarray(np.linalg.norm(image[..., :2] / depth - xy, axis=-1))
