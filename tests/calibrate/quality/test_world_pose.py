"""How well the room is known that an L-frame gave."""

from dataclasses import replace

import numpy as np
import pytest
from room import judged

from kinemark.calibrate.quality import joint_of, world_pose
from kinemark.calibrate.resection import moved
from kinemark.calibrate.wand import Wand
from kinemark.data import Rig
from kinemark.geometry import project_all, refine, triangulate, undistort
from kinemark.synth import ring

ARMS = np.array([[300.0, 200, 0], [900, 200, 0], [300, 600, 0]])
COV = np.diag([0.0] * 9 + [4e-8] * 3 + [0.16] * 3)  # turns known to 0.2 mrad, places to 0.4 mm
RIG = Rig(tuple(replace(camera, cov=COV) for camera in ring(4)))
NOISE = 0.3


def placed(rig, uv):
    uv = uv.transpose(1, 0, 2)
    ideal = np.stack([undistort(camera, uv[:, c]) for c, camera in enumerate(rig)], 1)
    alike = np.broadcast_to(NOISE**2 * np.eye(2), (*uv.shape, 2))
    return refine(rig, triangulate(ideal, rig.P), uv, alike).xyz


def motions(off, spread):
    """(M, 3, 7): each turn, shift and growth, one after the other."""
    turns = np.stack([np.cross(axis, off) for axis in np.eye(3)], -1)
    return np.concatenate([turns, np.tile(np.eye(3), (len(off), 1, 1)), off[..., None] / spread], -1)


@pytest.mark.parametrize(("frames", "free"), [(1, 6), (25, 6), (1, 7)])
def test_an_l_frame_puts_the_room_as_far_off_as_is_stated(frames, free):
    world = world_pose(RIG, joint_of(RIG), ARMS, centroid_sd=NOISE, frames=frames, grows=free == 7)
    back = np.linalg.pinv(motions(ARMS - world.centre, world.spread)[..., :free].reshape(-1, free))
    rng, seen, square = np.random.default_rng(1), project_all(RIG, ARMS), []
    for _ in range(150):
        wrong = tuple(moved(c, np.ones(15, bool), np.sqrt(np.diag(COV)) * rng.normal(size=15)) for c in RIG)
        found = placed(Rig(wrong), seen + NOISE / np.sqrt(frames) * rng.normal(size=seen.shape))
        p = back @ (found - ARMS).ravel()
        square.append(p @ np.linalg.solve(world.cov[:free, :free], p))
    assert np.mean(square) == pytest.approx(free, rel=0.15)
    assert np.linalg.matrix_rank(world.cov) == free


def test_it_grows_away_from_the_l_frame_and_is_the_same_for_neighbours():
    world = world_pose(RIG, joint_of(RIG), ARMS, centroid_sd=NOISE)
    near, far = world.at(np.array([world.centre, world.centre + np.array([0, 0, 1800.0])]))
    assert np.trace(far) > 4 * np.trace(near)
    assert np.linalg.eigvalsh(near).min() > 0


def test_points_that_do_not_fix_a_room_say_nothing():
    row = ARMS[0] + np.outer([0.0, 300, 600], [1.0, 0, 0])
    assert world_pose(RIG, joint_of(RIG), row, centroid_sd=NOISE) is None
    assert world_pose(RIG, joint_of(RIG), ARMS + np.array([0, 0, 9000.0]), centroid_sd=NOISE) is None


def test_positions_in_a_room_that_is_off_are_within_what_is_stated():
    """The L-frame on the floor, the wand above it: whole calibrations; of one, ellipsoids alone hold a tenth.

    All places of a calibration share one motion, so three calibrations are asked together.
    """
    first, *others = (judged(seed, Wand()) for seed in (2013, 2014, 2015))
    assert first.apart < 0.2 and first.moved > 0.4
    assert np.mean([[one.room, one.rest] for one in (first, *others)], axis=0).min() > 0.9
