"""Terms of which images tell nothing else than what is usual stay there, as uncertain as they are."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.calibrate.bundle import Bundle, bundle, sticks_through
from kinemark.data import Rig
from kinemark.geometry import project_all, rigid_align, triangulate
from kinemark.geometry.camera import undistort_all
from kinemark.synth import ring

ALONG = np.array([0.0, 180.0, 500.0])
MIDDLE = np.array([1200.0, 700.0, 1000.0])
PLAIN = np.array([-0.1, 0.05, 0.0, 0.0, 0.0])


def laboratory(seed, *, tangential=0.0, aspect=0.0, noise=0.1):
    """A rig, the start, sticks (F, 3, 3) in half of the volume, their pixels (C, N, 2)."""
    rng = np.random.default_rng(seed)
    cameras = []
    for camera in ring(int(rng.integers(3, 8))):
        K, lens = camera.K.copy(), PLAIN.copy()
        K[1, 1] *= 1 + aspect * rng.normal()
        lens[2:4] = tangential * rng.normal(size=2)
        cameras.append(replace(camera, K=K, distortion=lens))
    middle = MIDDLE + rng.uniform(-1, 1, (250, 3)) * [450, 900, 700] + [450, 0, 0]
    way = rng.normal(size=(250, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    xyz = middle[:, None] + (ALONG - ALONG.mean())[:, None] * way[:, None]
    uv = project_all(Rig(tuple(cameras)), xyz.reshape(-1, 3))
    uv = uv + noise * rng.normal(size=uv.shape)
    size = np.array([camera.size for camera in cameras])[:, None]
    uv = np.where(((uv > 0) & (uv < size - 1)).all(-1, keepdims=True), uv, np.nan)
    start = Rig(tuple(replace(camera, K=ring(1)[0].K, distortion=PLAIN) for camera in cameras))
    return Rig(tuple(cameras)), start, xyz, uv


def fitted(seed, method=None, **lenses):
    """The true rig, the fit, and how far exact images beyond the waved volume lie from the truth, RMS mm."""
    rig, start, xyz, uv = laboratory(seed, **lenses)
    fit = bundle(start, (sticks_through(xyz, ALONG),), uv, method=method)
    used = np.isfinite(fit.xyz).all(1)
    R, t = rigid_align(xyz.reshape(-1, 3)[used], fit.xyz[used])[:2]
    places = MIDDLE + np.random.default_rng(seed).uniform(-1, 1, (200, 3)) * [900, 900, 750]
    found = triangulate(undistort_all(fit.rig, project_all(rig, places).transpose(1, 0, 2)), fit.rig.P)
    return rig, fit, np.sqrt(((found - places @ R.T - t) ** 2).sum(1).mean())


def test_lenses_without_such_terms_are_calibrated_as_if_that_were_known():
    usual = [fitted(seed)[2] for seed in range(60, 68)]
    exact = [fitted(seed, Bundle(usual_lens=False))[2] for seed in range(60, 68)]
    assert np.mean(usual) < 1.08 * np.mean(exact)


def test_terms_stay_and_have_the_uncertainty_that_images_leave_them():
    _, fit, _ = fitted(61)
    for camera in fit.rig:
        assert not camera.distortion[2:].any()
        assert camera.K[1, 1] / camera.K[0, 0] == pytest.approx(1, abs=1e-12)
        assert (np.sqrt(np.diag(camera.cov)[6:8]) > 1e-5).all()


def test_terms_that_images_show_are_fitted_and_others_stay():
    rig, fit, _ = fitted(62, tangential=1e-3)
    found, true = (np.array([camera.distortion[2:4] for camera in each]) for each in (fit.rig, rig))
    assert np.abs(found - true).max() < 0.3 * np.abs(true).max()
    assert [camera.K[1, 1] / camera.K[0, 0] for camera in fit.rig] == pytest.approx([1] * len(rig), abs=1e-12)


def test_pixels_that_are_not_square_are_found():
    rig, fit, _ = fitted(63, aspect=2e-3, noise=0.05)
    ratios = [[camera.K[1, 1] / camera.K[0, 0] for camera in each] for each in (fit.rig, rig)]
    assert np.abs(np.subtract(*ratios)).max() < 5e-4
