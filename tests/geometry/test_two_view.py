"""Two views: laws of the fundamental and the essential matrix, against known cameras and with wrong points."""

import cv2
import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.geometry import fundamental, normalised, project
from kinemark.geometry.two_view import (
    essential,
    fit_fundamental,
    midpoints,
    poses,
    relative_pose,
    robust_fundamental,
    sampson_distance,
)
from support.laboratory import ring


@pytest.fixture
def views():
    """Two cameras without lenses, points before both, and their pixels."""
    rig = ring(3, lens=np.zeros(5))
    xyz = np.random.default_rng(0).uniform([-1000, -700, 0], [1000, 700, 2000], (300, 3))
    return rig[0], rig[1], xyz, project(rig[0], xyz), project(rig[1], xyz)


def same_up_to_sign(F, G):
    return np.abs(F - np.sign((F * G).sum()) * G).max()


def test_the_fundamental_matrix_is_that_of_the_cameras(views):
    one, two, _, a, b = views
    F = fit_fundamental(a, b)
    assert same_up_to_sign(F, fundamental(one.P, two.P)) < 1e-10
    assert np.linalg.matrix_rank(F, tol=1e-8 * np.linalg.norm(F)) == 2
    assert np.abs(sampson_distance(F, a, b)).max() < 1e-6
    noisy = fit_fundamental(a, b + np.random.default_rng(6).normal(size=b.shape))
    assert np.linalg.svd(noisy, compute_uv=False)[2] < 1e-9 * np.linalg.norm(noisy)  # all epipolar lines meet


def test_it_moves_with_the_images(views):
    """F of transformed images is H₂⁻ᵀ F H₁⁻¹: scaling and shifting must not change the answer."""
    _, _, _, a, b = views
    H = np.diag([3.0, 3.0, 1.0])
    H[:2, 2] = [5000.0, -900.0]
    F = fit_fundamental(a * 3 + H[:2, 2], b)
    wanted = fit_fundamental(a, b) @ np.linalg.inv(H)
    assert same_up_to_sign(F, wanted / np.linalg.norm(wanted)) < 1e-10


def test_sampson_distance_is_that_of_opencv_and_a_distance(views):
    _, _, _, a, b = views
    F = fit_fundamental(a, b)
    b = b + np.random.default_rng(1).normal(size=b.shape)
    ours = sampson_distance(F, a, b)
    theirs = [cv2.sampsonDistance(np.append(p, 1.0), np.append(q, 1.0), F) for p, q in zip(a, b, strict=True)]
    assert np.allclose(ours**2, theirs, rtol=1e-6)
    assert 0.6 < ours.std() < 0.8  # of noise in one image only: 1/√2 where both epipolar lines bend alike


@pytest.mark.parametrize("wrong", [0.02, 0.3])
def test_wrong_pairs_are_found(views, wrong):
    rng = np.random.default_rng(2)
    _, _, _, a, b = views
    bad = rng.random(len(a)) < wrong
    a = a + 0.1 * rng.normal(size=a.shape)
    b = np.where(bad[:, None], rng.uniform(0, 1000, b.shape), b + 0.1 * rng.normal(size=b.shape))
    F, inliers = robust_fundamental(a, b, trials=400)
    off = np.abs(sampson_distance(F, views[3], views[4]))
    assert np.median(off) < 0.05
    assert (inliers & ~bad).sum() > 0.95 * (~bad).sum()
    assert (inliers & bad).sum() <= 0.02 * len(a)  # those near their line by chance


def test_the_same_seed_gives_the_same_matrix(views):
    a, b = views[3] + np.random.default_rng(3).normal(size=views[3].shape), views[4]
    assert np.array_equal(robust_fundamental(a, b, seed=5)[0], robust_fundamental(a, b, seed=5)[0])


def test_missing_points_are_passed_over_and_too_few_refused(views):
    a, b = views[3].copy(), views[4]
    a[100:] = np.nan
    assert same_up_to_sign(fit_fundamental(a, b), fit_fundamental(a[:100], b[:100])) < 1e-12
    a[7:] = np.nan
    for fit in (fit_fundamental, robust_fundamental):
        with pytest.raises(KinemarkError, match="7 points in common"):
            fit(a, b)


def test_the_pose_is_that_between_the_cameras(views):
    one, two, xyz, a, b = views
    E = essential(fit_fundamental(a, b), one.K, two.K)
    assert np.allclose(np.linalg.svd(E, compute_uv=False), np.array([1, 1, 0]) / np.sqrt(2), atol=1e-9)
    x, y = normalised(one, a), normalised(two, b)
    R, t = relative_pose(E, x, y)
    assert np.allclose(R, two.R @ one.R.T, atol=1e-9)
    base = two.t - R @ one.t
    assert np.allclose(t, base / np.linalg.norm(base), atol=1e-9)
    seen, depth1, depth2 = midpoints(R, t, x, y)
    assert np.allclose(seen * np.linalg.norm(base), xyz @ one.R.T + one.t, atol=1e-5)
    assert (depth1 > 0).all()
    assert (depth2 > 0).all()


def test_all_four_poses_have_the_essential_matrix(views):
    E = essential(fundamental(views[0].P, views[1].P), views[0].K, views[1].K)
    R, t = poses(E)
    assert np.allclose(np.linalg.det(R), 1)
    for Ri, ti in zip(R, t, strict=True):
        x, y, z = ti
        made = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ Ri
        assert same_up_to_sign(made / np.linalg.norm(made), E) < 1e-9


def test_many_at_once_are_as_one_by_one(views):
    one, _, _, a, b = views
    F = fit_fundamental(a, b)
    scales = np.array([0.8, 1.0, 1.3])
    K = scales[:, None, None] ** np.array([1.0, 1.0, 0.0])[:, None] * one.K
    x, y = np.stack([a / s / 1000 for s in scales]), np.stack([b / s / 1000 for s in scales])
    R, t = relative_pose(essential(F, K, K), x, y)
    for i in range(3):
        Ri, ti = relative_pose(essential(F, K[i], K[i]), x[i], y[i])
        assert np.allclose(R[i], Ri)
        assert np.allclose(t[i], ti)
