"""The world of a rig: a similarity changes no image, covariances go along."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.calibrate.bundle import FreePoints, bundle
from kinemark.calibrate.world_frame import fit_moved_to, fit_scaled, moved_to, scaled, similarity
from kinemark.data import KinemarkError, Rig
from kinemark.geometry import parameter_jacobian, project, project_all
from support.laboratory import ring

A = Rotation.from_rotvec([0.3, -1.2, 2.0]).as_matrix()
B = np.array([3000.0, -800.0, 120.0])


@pytest.fixture
def rig():
    """Four cameras with a volume and some covariance."""
    rng = np.random.default_rng(0)
    root = rng.normal(size=(4, 15, 15)) * np.array([1, 1, 1, 1, *5 * [1e-4], *3 * [1e-4], 1, 1, 1])[:, None]
    cameras = (replace(camera, cov=r @ r.T) for camera, r in zip(ring(4), root, strict=True))
    return Rig(tuple(cameras), "some method", np.array([[-1000.0, -700, 0], [1000, 700, 2000]]))


@pytest.fixture
def points():
    return np.random.default_rng(1).uniform([-1000, -700, 0], [1000, 700, 2000], (50, 3))


@pytest.mark.parametrize("scale", [1.0, 0.37])
def test_images_stay_when_the_world_moves(rig, points, scale):
    there = scale * points @ A.T + B
    moved = moved_to(rig, points[:5], there[:5], scale=scale != 1)
    assert np.allclose(project_all(moved, there), project_all(rig, points), atol=1e-8)
    assert np.allclose(moved.centres, scale * rig.centres @ A.T + B)
    assert moved.method == rig.method
    inside = (there > moved.volume[0]).all(1) & (there < moved.volume[1]).all(1)
    assert inside.all()


def test_a_scale_alone_grows_everything(rig, points):
    bigger = scaled(rig, 2.5)
    assert np.allclose(project_all(bigger, 2.5 * points), project_all(rig, points))
    assert np.allclose(bigger.volume, 2.5 * rig.volume)
    with pytest.raises(ValueError, match="factor is -1"):
        scaled(rig, -1)


@pytest.mark.parametrize("scale", [1.0, 3.0])
def test_the_uncertainty_of_images_stays_too(rig, points, scale):
    """J Σ Jᵀ, the covariance of a reprojection, is the same in every world."""
    there = scale * points @ A.T + B
    moved = moved_to(rig, points, there, scale=scale != 1)
    for old, new in zip(rig, moved, strict=True):
        J, K = parameter_jacobian(old, points), parameter_jacobian(new, there)
        assert np.allclose(K @ new.cov @ K.transpose(0, 2, 1), J @ old.cov @ J.transpose(0, 2, 1), rtol=1e-6)


def test_all_of_a_fit_goes_along(rig, points):
    uv = project_all(rig, points) + 0.1 * np.random.default_rng(2).normal(size=(4, 50, 2))
    fit = bundle(rig, (FreePoints(points),), uv)
    there = 2.0 * fit.xyz @ A.T + B
    moved = fit_moved_to(fit, fit.xyz, there, scale=True)
    assert np.allclose(moved.xyz, there)
    for c, camera in enumerate(moved.rig):
        assert np.allclose(moved.joint[15 * c : 15 * c + 15, 15 * c : 15 * c + 15], camera.cov)
        assert np.allclose(uv[c] - project(camera, moved.xyz), moved.residual[c], atol=1e-6)

    def spread(fit, at):
        J = np.zeros((4, len(at), 2, 60))
        for c, camera in enumerate(fit.rig):
            J[c, ..., 15 * c : 15 * c + 15] = parameter_jacobian(camera, at)
        J = J.reshape(-1, 60)
        return J @ fit.joint @ J.T

    assert np.allclose(spread(moved, there[:5]), spread(fit, fit.xyz[:5]), rtol=1e-5, atol=1e-9)
    assert np.allclose(fit_scaled(fit, 2.0).xyz, 2 * fit.xyz)


def test_the_similarity_is_the_best_one(points):
    """No small change of turn, place or size lays noisy points nearer."""
    rng = np.random.default_rng(3)
    known = 1.7 * points @ A.T + B + 5 * rng.normal(size=points.shape)
    R, b, s = similarity(points, known, scale=True)
    best = ((s * points @ R.T + b - known) ** 2).sum()
    for _ in range(20):
        turn, shift, grow = rng.normal(size=3) * 1e-3, rng.normal(size=3), 1 + 1e-3 * rng.normal()
        other = s * grow * points @ (Rotation.from_rotvec(turn).as_matrix() @ R).T + b + shift
        assert ((other - known) ** 2).sum() > best


def test_a_scale_that_nobody_asked_for_is_refused(rig, points):
    with pytest.raises(KinemarkError, match="sizes are as 2 to 1"):
        moved_to(rig, points, 2 * points)
    with pytest.raises(KinemarkError, match="which point is which"):
        moved_to(rig, points, points[::-1], scale=True)


def test_too_little_to_fix_a_world_is_refused(rig):
    line = np.outer(np.arange(4.0), [1.0, 2.0, 3.0])
    with pytest.raises(KinemarkError, match="on one line"):
        moved_to(rig, line, line)
    with pytest.raises(KinemarkError, match="2 points"):
        moved_to(rig, np.array([[0.0, 0, 0], [1, 0, 0], [np.nan, 1, 1]]), np.eye(3))
    with pytest.raises(ValueError, match="wanted \\(points, 3\\)"):
        moved_to(rig, line, line[:2])
