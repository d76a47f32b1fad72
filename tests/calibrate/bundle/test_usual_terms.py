"""How far lens terms are from usual is learned from all cameras of a rig."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.calibrate.bundle import Bundle, bundle, sticks_through
from kinemark.calibrate.bundle.usual_terms import SIZES, averaged
from kinemark.calibrate.quality import predicted_covariance
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
    """The true rig, the fit, and how far exact images beyond the waved volume lie from the truth, RMS mm: as it is, as
    the fit says."""
    rig, start, xyz, uv = laboratory(seed, **lenses)
    fit = bundle(start, (sticks_through(xyz, ALONG),), uv, method=method)
    used = np.isfinite(fit.xyz).all(1)
    R, t = rigid_align(xyz.reshape(-1, 3)[used], fit.xyz[used])[:2]
    places = MIDDLE + np.random.default_rng(seed).uniform(-1, 1, (200, 3)) * [900, 900, 750]
    found = triangulate(undistort_all(fit.rig, project_all(rig, places).transpose(1, 0, 2)), fit.rig.P)
    cov = predicted_covariance(fit.rig, found, centroid_sd=1e-3, joint=fit.joint)
    squares = ((found - places @ R.T - t) ** 2).sum(1), np.trace(cov, axis1=1, axis2=2)
    return rig, fit, np.sqrt([each[np.isfinite(squares[1])].mean() for each in squares])


def test_lenses_without_such_terms_are_calibrated_as_if_that_were_known():
    usual = np.array([fitted(seed)[2] for seed in range(60, 68)])
    exact = np.array([fitted(seed, Bundle(usual_lens=False))[2] for seed in range(60, 68)])
    assert usual[:, 0].mean() < 1.08 * exact[:, 0].mean()
    assert usual[:, 1].mean() < 1.25 * exact[:, 1].mean()


def test_terms_that_images_show_are_fitted_and_others_stay():
    rig, fit, _ = fitted(62, tangential=1e-3)
    found, true = (np.array([camera.distortion[2:4] for camera in each]) for each in (fit.rig, rig))
    assert np.abs(found - true).max() < 0.3 * np.abs(true).max()
    ratios = np.array([camera.K[1, 1] / camera.K[0, 0] for camera in fit.rig])
    assert np.abs(ratios - 1).max() < 1e-4


def test_pixels_that_are_not_square_are_found():
    rig, fit, _ = fitted(63, aspect=2e-3, noise=0.05)
    ratios = [[camera.K[1, 1] / camera.K[0, 0] for camera in each] for each in (fit.rig, rig)]
    assert np.abs(np.subtract(*ratios)).max() < 5e-4


def test_a_camera_that_is_held_stays_as_it_is():
    _, start, xyz, uv = laboratory(64)
    free = Bundle().freedom
    held = free._replace(free=np.zeros(15, bool))
    fit = bundle(start, (sticks_through(xyz, ALONG),), uv, freedoms=[held] + [free] * (len(start) - 1))
    assert np.array_equal(fit.rig[0].distortion, start[0].distortion) and np.array_equal(fit.rig[0].K, start[0].K)
    assert not fit.rig[0].cov.any() and np.isfinite(fit.joint).all()


def test_the_average_is_that_of_integration():
    """One term of one camera, of which images say exp(b x − F x² / 2)."""
    x, F, b = np.linspace(-6, 6, 20001), 4.0, 2.5
    one, odd = SIZES, np.ones(len(SIZES))  # the camera is like the others, its term with or without their mean, or odd
    sizes = np.concatenate([one, odd, odd, odd])
    density = (np.exp(-((x / sizes[:, None]) ** 2) / 2) / sizes[:, None]).sum(0) * np.exp(b * x - F * x**2 / 2)
    mean = (x * density).sum() / density.sum()
    variance = ((x - mean) ** 2 * density).sum() / density.sum()
    known = np.zeros((1, 6), bool)
    known[0, 0] = True
    found, M = averaged(np.array([b / (F + 1)]), np.array([[1 / (F + 1)]]), known)
    assert (found[0], M[0, 0]) == (pytest.approx(mean, rel=1e-5), pytest.approx(variance, rel=1e-5))


def learned(true, sd):
    """Errors of v̄ and standard deviations by M of terms (10, C, 6), which images tell to ± sd, in units of σ."""
    rng, P, found = np.random.default_rng(0), np.full(true.size, 1 / (1 + sd**-2)), []
    for _ in range(10):
        v = P * (true.ravel() + sd * rng.normal(size=true.size)) / sd**2
        mean, M = averaged(v, np.diag(P), np.ones(true.shape, bool))
        found.append((mean.reshape(true.shape) - true, np.sqrt(np.diag(M)).reshape(true.shape)))
    return (np.array(each) for each in zip(*found, strict=True))


def rms(x):
    return np.sqrt((x**2).mean())


def test_ideal_lenses_are_told_so_by_all_cameras_together():
    off, sd = learned(np.zeros((6, 6)), 0.3)
    assert rms(off) < 0.3 * 0.3 and rms(off) < rms(sd) < 0.5 * 0.3


def test_terms_of_usual_size_are_as_images_show_them():
    off, sd = learned(np.random.default_rng(1).normal(size=(6, 6)), 0.1)
    assert sd == pytest.approx(0.1, rel=0.05) and rms(off / sd) == pytest.approx(1, abs=0.1)


def test_terms_that_all_cameras_have_alike_are_told_by_all_together():
    """What each camera alone hardly shows is not taken for none, as if cameras were off in all directions."""
    true = np.zeros((8, 6))
    true[:, [0, 5]] = 0.7
    off, sd = learned(true, 0.7)
    assert rms(off[..., [0, 5]].mean(1)) < 0.4
    assert rms((off / sd)[..., [0, 5]]) < 1.2


def test_an_odd_camera_takes_nothing_from_the_others_nor_they_from_it():
    true = np.zeros((6, 6))
    true[2] = 1.5
    off, sd = learned(true, 0.3)
    odd, others = off[:, 2], off[:, np.arange(6) != 2]
    assert sd[:, 2] == pytest.approx(0.3, rel=0.1) and rms(odd / 0.3) < 1.3
    assert rms(others) < 0.3 * 0.3
