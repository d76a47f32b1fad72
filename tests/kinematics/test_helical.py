"""Helical axes of screws that are known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.kinematics import body_pose
from kinemark.kinematics.helical import helical_axes, helical_axis


def screws(seed, n=50, deg=(2.0, 175.0)):
    """Poses before and after a screw about a line (n, point), and its turn and shift."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=(n, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    point, turn, along = rng.normal(0, 300, (n, 3)), rng.uniform(*deg, n), rng.normal(0, 20, n)
    R0, t0 = Rotation.random(n, random_state=seed).as_matrix(), rng.normal(0, 500, (n, 3))
    R = Rotation.from_rotvec(np.radians(turn)[:, None] * axis).as_matrix()
    t1 = np.einsum("nij,nj->ni", R, t0 - point) + point + along[:, None] * axis
    return (R0, t0, R @ R0, t1), axis, point, turn, along


def test_a_screw_comes_back():
    poses, axis, point, turn, along = screws(1)
    found = helical_axis(*poses, near=point)
    np.testing.assert_allclose(found.direction, axis, atol=1e-9)
    np.testing.assert_allclose(found.turn_deg, turn, atol=1e-9)
    np.testing.assert_allclose(found.along_mm, along, atol=1e-7)
    np.testing.assert_allclose(found.point, point, atol=1e-6)


def test_the_point_is_on_the_line_and_nearest_to_where_it_was_asked():
    poses, axis, point, _, _ = screws(2)
    near = np.array([100.0, -50.0, 900.0])
    off = helical_axis(*poses, near=near).point
    np.testing.assert_allclose(np.cross(off - point, axis), 0, atol=1e-5)
    np.testing.assert_allclose(((off - near) * axis).sum(1), 0, atol=1e-6)


def test_far_away_it_is_the_same():
    (R0, t0, R1, t1), _, _, _, _ = screws(3)
    here, far = helical_axis(R0, t0, R1, t1), helical_axis(R0, t0 + 1e7, R1, t1 + 1e7)
    np.testing.assert_allclose(far.point - 1e7, here.point, atol=1e-4)
    np.testing.assert_allclose(far.along_mm, here.along_mm, atol=1e-5)


def test_small_turns_and_gaps_have_no_axis():
    (R0, t0, R1, t1), _, _, _, _ = screws(4, deg=(0.1, 0.9))
    assert np.isnan(helical_axis(R0, t0, R1, t1).direction).all()
    assert np.isfinite(helical_axis(R0, t0, R1, t1, least_turn_deg=0.05).direction).all()
    R1 = R1.copy()
    R1[3] = np.nan
    assert np.isnan(helical_axis(R0, t0, R1, t1).turn_deg[3])
    with pytest.raises(ValueError, match="step is 40"):
        helical_axes(R0, t0, step=40)


def test_a_hinge_is_found_from_trembling_markers_as_surely_as_is_said():
    rng = np.random.default_rng(5)
    turn = 35 + 30 * np.sin(np.linspace(0, 2 * np.pi, 200))
    R = Rotation.from_rotvec(np.radians(turn)[:, None] * [0.0, 1.0, 0.0]).as_matrix()
    pin, body = np.array([20.0, 0.0, -15.0]), rng.normal(0, 60, (6, 3))
    xyz = np.einsum("fij,kj->kfi", R, body - pin) + pin + rng.normal(0, 0.3, (6, 200, 3))
    pose = body_pose(body, xyz)
    found = helical_axes(pose.R, pose.t, step=10, near=pin, least_turn_deg=8.0)
    told = np.isfinite(found.turn_deg) & np.isfinite(found.point).all(1)
    assert told.sum() > 60
    off = (found.point - pin)[told][:, [0, 2]]
    said = 0.3 / np.sqrt(6) * np.sqrt(0.5) / np.sin(np.radians(found.turn_deg[told]) / 2)
    assert 0.6 < np.sqrt(np.mean(off**2 / said[:, None] ** 2)) < 1.6
    assert np.abs(np.abs(found.direction[told, 1]) - 1).max() < 0.01
