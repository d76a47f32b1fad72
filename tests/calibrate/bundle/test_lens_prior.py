"""Lens terms that are not fitted have their usual size, and points beyond the waved volume the errors that follow."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.calibrate.bundle import Bundle, bundle, sticks_through
from kinemark.data import Rig
from kinemark.geometry import project_all, refine, rigid_align, triangulate
from kinemark.geometry.camera import undistort_all
from kinemark.synth import ring

ALONG = np.array([0.0, 180.0, 500.0])
MIDDLE = np.array([1200.0, 700.0, 1000.0])
INSIDE = 7.815  # χ² of three, 95 %
NOISE = 0.05  # px


def usual(camera, rng):
    """The camera with k3, p1, p2 and pixels that are not quite square."""
    K = camera.K.copy()
    K[1, 1] *= 1 + 3e-4 * rng.normal()
    return replace(camera, K=K, distortion=np.array([-0.1, 0.05, *(3e-4 * rng.normal(size=2)), 0.01 * rng.normal()]))


def seen(rig, xyz, rng):
    """Pixels (C, N, 2) of points (N, 3), NaN outside the images."""
    uv = project_all(rig, xyz) + NOISE * rng.normal(size=(len(rig), len(xyz), 2))
    size = np.array([camera.size for camera in rig])[:, None]
    return np.where(((uv > 0) & (uv < size - 1)).all(-1, keepdims=True), uv, np.nan)


def calibrated(seed, **method):
    """The true rig, the fit, sticks (N, 3) waved in a quarter of the volume, and the random numbers that follow."""
    rng = np.random.default_rng(seed)
    rig = Rig(tuple(usual(camera, rng) for camera in ring(int(rng.integers(3, 8)))))
    middle = MIDDLE + rng.uniform(-1, 1, (250, 3)) * [450, 450, 700] + rng.choice([-1, 1], 3) * [450, 450, 0]
    way = rng.normal(size=(250, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    xyz = middle[:, None] + (ALONG - ALONG.mean())[:, None] * way[:, None]
    plain = np.array([-0.1, 0.05, 0, 0, 0])
    start = Rig(tuple(replace(c, K=ring(1)[0].K, distortion=plain) for c in rig))
    fit = bundle(start, (sticks_through(xyz, ALONG),), seen(rig, xyz.reshape(-1, 3), rng), method=Bundle(**method))
    return rig, fit, xyz.reshape(-1, 3), rng


def judged(seed, **method):
    """Share of points all over the volume that lie in their 95 % ellipsoids, and their RMS error, mm."""
    rig, fit, waved, rng = calibrated(seed, **method)
    used = np.isfinite(fit.xyz).all(1)
    R, t = rigid_align(waved[used], fit.xyz[used])[:2]
    places = MIDDLE + rng.uniform(-1, 1, (200, 3)) * [900, 900, 750]
    uv = seen(rig, places, rng).transpose(1, 0, 2)
    found = refine(fit.rig, triangulate(undistort_all(fit.rig, uv), fit.rig.P), uv,
                   np.broadcast_to(np.eye(2) * NOISE**2, (*uv.shape, 2)))  # fmt: skip
    good = np.isfinite(found.xyz[:, 0])
    off = (found.xyz - places @ R.T - t)[good]
    d2 = np.einsum("ni,ni->n", off, np.linalg.solve(found.cov[good], off[..., None])[..., 0])
    return (d2 < INSIDE).mean(), np.sqrt((off**2).sum(1).mean())


def test_points_beyond_the_waved_volume_are_within_what_is_stated():
    """Held at zero, the terms that are not fitted would move these points by more than is stated of them."""
    inside, error = np.mean([judged(seed) for seed in range(6)], axis=0)
    exact, other = np.mean([judged(seed, usual_lens=False) for seed in range(6)], axis=0)
    assert inside > 0.92 and exact < 0.87
    assert error < other


def test_terms_that_are_told_little_of_stay_usual():
    """p1 and p2 have at most their usual standard deviation, and what is found of them is as sure as it says."""
    rig, fit, *_ = calibrated(40)
    sd = np.sqrt([np.diag(camera.cov)[6:8] for camera in fit.rig])
    off = np.array([a.distortion[2:4] - b.distortion[2:4] for a, b in zip(fit.rig, rig, strict=True)])
    assert (sd > 0).all() and (sd < 1.05e-3).all()
    assert np.abs(off / sd).max() < 4


@pytest.mark.parametrize("seed", [3, 5, 8, 9])  # without what is usual of k1 and k2 these fold
def test_few_poses_give_no_lens_that_folds_the_image_over(seed):
    rng = np.random.default_rng(seed)
    rig = Rig(tuple(replace(c, distortion=np.array([-0.2, 0.06, 0, 0, 0])) for c in ring(2)))
    way = rng.normal(size=(25, 1, 3))
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    xyz = MIDDLE + rng.uniform(-1, 1, (25, 1, 3)) * 450 + np.array([[-250.0], [250.0]]) * way
    uv = project_all(rig, xyz.reshape(-1, 3)) + 0.3 * rng.normal(size=(2, 50, 2))
    fit = bundle(rig, (sticks_through(xyz, [0, 500]),), uv)
    width, height = rig[0].size
    edge = np.stack(np.meshgrid([0, width / 2, width - 1], [0, height / 2, height - 1]), -1).reshape(-1, 1, 2)
    assert np.isfinite(undistort_all(fit.rig, edge.repeat(2, 1))).all()


@pytest.mark.parametrize("method", [{"usual_lens": False}, {"radial": 0}])
def test_lenses_that_are_exact_stay_so(method):
    _, fit, *_ = calibrated(41, **method)
    for camera in fit.rig:
        assert (np.diag(camera.cov)[6:9] == 0).all()
        assert camera.K[0, 0] == pytest.approx(camera.K[1, 1])
