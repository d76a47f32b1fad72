"""The knee's motion by Grood and Suntay against turns and shifts that are known."""

import numpy as np
import pytest

from kinemark.kinematics import turned
from kinemark.kinematics.knee import knee_motion


def posed(seed, side, n=40):
    """Femur and tibia (R, t) and the truth: deg (flexion, adduction, internal rotation)."""
    rng = np.random.default_rng(seed)
    deg = np.stack([rng.uniform(-10, 120, n), rng.uniform(-25, 25, n), rng.uniform(-30, 30, n)], -1)
    s = 1.0 if side == "left" else -1.0
    femur = turned(rng.uniform(-80, 80, (n, 3)), "xyz")
    joint = turned(deg * [1.0, -s, -s], "yxz")
    t = rng.normal(0, 500, (n, 3))
    return (femur, t), (femur @ joint, t), deg


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_three_angles_are_those_of_flexion_adduction_rotation_in_turn(side):
    femur, tibia, deg = posed(1, side)
    np.testing.assert_allclose(knee_motion(*femur, *tibia, side=side).deg, deg, atol=1e-9)


@pytest.mark.parametrize("side", ["left", "right"])
def test_shifts_are_along_the_joints_own_axes(side):
    (R, t), (S, _), _ = posed(2, side)
    axes = knee_motion(R, t, S, t, side=side).axes
    lateral = 1.0 if side == "right" else -1.0
    away = 3.0 * lateral * axes[:, 0] + 5.0 * axes[:, 1] - 7.0 * axes[:, 2]
    found = knee_motion(R, t, S, t + away, side=side).mm
    across = lateral * (axes[:, 0] * axes[:, 2]).sum(1)  # the first and last are not square to each other
    np.testing.assert_allclose(found[:, 1], 5.0, atol=1e-9)
    np.testing.assert_allclose(found[:, 0], 3.0 - 7.0 * across, atol=1e-9)
    np.testing.assert_allclose(found[:, 2], 7.0 - 3.0 * across, atol=1e-9)


def test_a_knee_seen_in_a_mirror_is_the_other_knee():
    (R, t), (S, u), _ = posed(3, "left")
    M = np.diag([1.0, -1.0, 1.0])
    left = knee_motion(R, t, S, u + 4.0 * R[..., 0], side="left")
    right = knee_motion(M @ R @ M, t @ M, M @ S @ M, (u + 4.0 * R[..., 0]) @ M, side="right")
    np.testing.assert_allclose(left.deg, right.deg, atol=1e-9)
    np.testing.assert_allclose(left.mm, right.mm, atol=1e-9)


def test_a_gap_stays_a_gap():
    (R, t), (S, u), _ = posed(4, "right")
    R[5] = np.nan
    found = knee_motion(R, t, S, u, side="right")
    assert np.isnan(found.deg[5]).all() and np.isfinite(np.delete(found.deg, 5, 0)).all()
