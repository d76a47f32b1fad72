"""An L-frame is recognised by its distances, whatever the world, and read from all frames in which it rests."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.calibrate.l_frame import l_frame, resting_l_frame
from kinemark.calibrate.world_frame import moved_to
from kinemark.data import KinemarkError
from support.laboratory import ring

A = Rotation.from_rotvec([0.3, -1.2, 2.0]).as_matrix()
B = np.array([3000.0, -800.0, 120.0])


@pytest.fixture
def rig():
    return ring(4)


FRAME = np.array([[0.0, 0, 20], [200, 0, 20], [600, 0, 20], [0, 400, 20]])


@pytest.mark.parametrize("scale", [1.0, 0.002])
@pytest.mark.parametrize("side", [1, -1])
def test_an_l_frame_is_recognised_in_any_order(rig, scale, side):
    """Whatever world the rig stands in, however the short arm lies: X along the long arm, Z to the cameras."""
    rng = np.random.default_rng(4)
    frame = FRAME * [1, side, 1]
    clutter = np.array([[900.0, 500, 1000], [-300, 800, 600]])
    order = rng.permutation(6)
    seen = np.concatenate([frame, clutter])[order]
    world = moved_to(rig, np.eye(3), scale * np.eye(3) @ A.T + B, scale=True)
    known = l_frame(world, scale * seen @ A.T + B, long=(200, 600), short=400, height=20, scale=scale != 1)
    wanted = np.concatenate([frame, np.full((2, 3), np.nan)])[order]
    assert np.allclose(known, wanted, equal_nan=True)
    back = moved_to(world, scale * seen @ A.T + B, known, scale=True)
    assert np.allclose(back.centres, rig.centres, atol=1e-6)
    below = l_frame(world, scale * seen @ A.T + B, long=(200, 600), short=400, scale=scale != 1, cameras_above=False)
    assert np.nanmax(below[:, 1] * side) <= 0  # seen from below the other way round


def test_an_l_frame_survives_noise_and_three_markers(rig):
    noisy = FRAME[[3, 0, 2]] + np.random.default_rng(5).normal(size=(3, 3))
    assert np.array_equal(l_frame(rig, noisy, long=600, short=400, height=20), FRAME[[3, 0, 2]])


def test_an_l_frame_that_cannot_be_told_is_refused(rig):
    with pytest.raises(KinemarkError, match="has 3 markers"):
        l_frame(rig, FRAME[:2], long=600, short=400)
    with pytest.raises(KinemarkError, match=r"off by 1\d\d\.\d mm"):
        l_frame(rig, FRAME[[0, 1, 3]], long=350, short=390)
    with pytest.raises(KinemarkError, match="in two ways"):
        l_frame(rig, FRAME[[0, 2, 3]] * [400 / 600 * 1.004, 1, 1], long=402, short=400)
    with pytest.raises(ValueError, match="wanted different distances"):
        l_frame(rig, FRAME, long=400, short=400)


def frames_of(n, *, noise=0.5, seed=6):
    """The L-frame in n frames, its markers in any order, some of them unseen, among strays."""
    rng = np.random.default_rng(seed)
    frames = []
    for _ in range(n):
        points = FRAME + noise * rng.normal(size=FRAME.shape)
        points = points[rng.random(len(points)) > 0.1]
        strays = rng.uniform(-900, 900, (rng.integers(0, 3), 3)) + np.array([0, 0, 1200])
        frames.append(rng.permutation(np.concatenate([points, strays])))
    return frames


@pytest.mark.parametrize(
    ("times", "unit"),
    [
        (0.9, ""),
        (1.1, ""),
        (0.001, ", as if the lengths that give the scale were stated in m"),
        (1 / 25.4, ", as if the lengths that give the scale were stated in inches"),
        (10.0, ", as if the L-frame's arms were stated in cm"),
    ],
)
def test_a_scale_that_is_wrong_is_told_from_a_frame_that_is_not_the_stated_one(rig, times, unit):
    seen = times * np.array([[0, 0, 0], [400, 0, 0], [0, 250, 0.0]])
    with pytest.raises(KinemarkError, match=f"All are {times:.3f} times as long{unit}: correct lengths_mm of the wand"):
        l_frame(rig, seen, long=400.0, short=250.0)


@pytest.mark.parametrize("seed", range(3))
def test_many_frames_place_the_world_better_than_one(rig, seed):
    arms = {"long": (200, 600), "short": 400, "height": 20}
    found = resting_l_frame(rig, frames_of(100, seed=seed), **arms)
    assert 40 < found.frames < 90 and found.moved == 0  # all four markers are seen in 66 of 100
    np.testing.assert_allclose(found.known, FRAME)
    assert np.abs(found.seen - FRAME).max() < 4.5 * 0.5 / np.sqrt(found.frames)


def test_frames_in_which_it_stands_elsewhere_are_left_out_and_counted(rig):
    frames = frames_of(30)
    frames += [frame + np.array([80.0, 30.0, 0.0]) for frame in frames_of(9, seed=7)]  # pushed aside at the end
    found = resting_l_frame(rig, frames, long=(200, 600), short=400, height=20)
    assert 3 <= found.moved <= 9 and found.off == pytest.approx(np.hypot(80, 30), abs=4)
    assert np.abs(found.seen - FRAME).max() < 0.6


def test_an_l_frame_in_no_frame_says_why(rig):
    with pytest.raises(KinemarkError, match="2 points are seen, and the L-frame has 4 markers"):
        resting_l_frame(rig, [FRAME[:2]] * 3, long=(200, 600), short=400)
    with pytest.raises(KinemarkError, match="No frame"):
        resting_l_frame(rig, [], long=(200, 600), short=400)


@pytest.mark.parametrize("always", [False, True])
def test_a_wrong_unit_is_told_beside_strays(rig, always):
    """By a frame that shows the L-frame alone, or, as a unit is hardly matched by chance, beside strays as well."""
    rng = np.random.default_rng(3)
    seen = 0.1 * np.array([[0, 0, 0], [400, 0, 0], [0, 250, 0.0]]) + rng.normal(0, 0.03, (3, 3))
    frames = [np.concatenate([seen, rng.uniform(-90, 90, (2 if always or f % 2 else 0, 3))]) for f in (1, 0, 1, 2, 3)]
    with pytest.raises(KinemarkError, match=r"All are 0\.1\d* times as long, as if the lengths .* were stated in cm"):
        resting_l_frame(rig, frames, long=400.0, short=250.0, tolerance=0.05)
    with pytest.raises(KinemarkError, match="Check its lengths"):  # 1.3 times as long may be chance
        resting_l_frame(rig, [13 * frame for frame in frames if len(frame) > 3], long=400.0, short=250.0)
