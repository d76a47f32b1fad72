"""Filling from two reference markers: on the line through them, and on the circle of known distances."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import Detections, Rig
from kinemark.fill import AlongLine, Circle, Gap, MarkerArray, Rays
from kinemark.fill.methods.along_line import fill_along_line
from kinemark.fill.methods.circle import fill_circle
from kinemark.fill.rays import sharpened
from kinemark.geometry import project
from support.filling import off
from support.laboratory import IDEAL, camera

GAP = Gap(0, 150, 210)


def segment(place, *, twist=0.0, frames=400, noise=0.0, seed=0):
    """A marker in this place on a segment that swings like a shank, and turns about its own line by `twist` rad; the
    two others lie on that line."""
    t = np.arange(frames) / 100
    swing = Rotation.from_rotvec(np.stack([0.2 * np.cos(2 * t), 0.9 * np.sin(4 * t), 0 * t], 1))
    turn = swing * Rotation.from_rotvec(twist * np.outer(np.sin(1.3 * t), [0, 0, 1.0]))
    shape = np.array([place, [0, 0, 0], [0, 0, 250.0]])
    xyz = np.stack([turn.apply(p) for p in shape]) + np.stack([800 * t, 40 * np.sin(6 * t), 500 + 0 * t], 1)
    xyz += np.random.default_rng(seed).normal(0, noise, xyz.shape) if noise else 0
    return MarkerArray(xyz, 100.0, ("ANK", "TIB1", "TIB2"))


@pytest.mark.parametrize("s", [-120.0, 100.0, 400.0])
def test_a_marker_on_the_line_is_found_on_it_before_between_and_beyond(s):
    motion = segment([0, 0, s], twist=1.0)
    said = fill_along_line(motion.hidden([GAP]), [GAP], method=AlongLine())[0]
    assert off(said, motion, GAP).max() < 1e-6
    assert said.references == (1, 2)


def test_what_stands_off_the_line_is_left_over_and_said():
    motion = segment([30.0, 0, 400.0], twist=0.3)
    said = fill_along_line(motion.hidden([GAP]), [GAP])[0]
    wrong = off(said, motion, GAP)
    assert 2.0 < wrong.max() < 30.0  # how it turns about the line is not known
    sd = np.sqrt(np.trace(said.cov, axis1=1, axis2=2))
    assert 0.3 < wrong.mean() / sd.mean() < 2.0
    assert wrong[[0, -1]].max() < wrong.max() / 3  # it joins on to the samples


def test_the_circle_is_exact_where_the_segment_does_not_turn_about_its_line():
    motion = segment([60.0, 0, 400.0])
    gap = Gap(0, 150, 180)
    said = fill_circle(motion.hidden([gap]), [gap])[0]
    line = fill_along_line(motion.hidden([gap]), [gap])[0]
    assert off(said, motion, gap).max() < 0.6  # a swing is not quite without turning
    assert off(said, motion, gap).max() < off(line, motion, gap).max() / 4


def test_a_marker_on_the_circle_keeps_its_distances_wherever_it_is_on_it():
    motion = segment([60.0, 0, 400.0], twist=1.2, noise=0.2)
    said = fill_circle(motion.hidden([GAP]), [GAP], method=Circle(reference_markers=("TIB1", "TIB2")))[0]
    wrong = off(said, motion, GAP)
    assert wrong.max() > 5.0
    for k in (1, 2):
        d = np.linalg.norm(said.xyz - motion.xyz[k, GAP.start : GAP.stop], axis=1)
        true = np.linalg.norm(motion.xyz[0] - motion.xyz[k], axis=1)[GAP.start : GAP.stop]
        assert np.abs(d - true).max() < 2.0
    values, axes = np.linalg.eigh(said.cov[30])
    assert values[2] > 4 * values[1]  # unsure along the circle alone
    e = said.xyz[30] - motion.xyz[0, GAP.start + 30]
    assert abs(axes[:, 2] @ e) > 0.9 * np.linalg.norm(e)


def test_one_camera_and_the_circle_are_a_place():
    """The ray of a single camera meets the circle (2.5 (8))."""
    motion = segment([60.0, 0, 400.0], twist=0.6, noise=0.2)
    said = fill_circle(motion.hidden([GAP]), [GAP])[0]
    rig = Rig((camera("c0", (1500.0, -3500.0, 900.0), target=(1400.0, 0.0, 700.0), lens=IDEAL),))
    uv = project(rig[0], motion.xyz[0]) + np.random.default_rng(1).normal(0, 0.1, (400, 2))
    seen = Detections.build(("c0",), 100.0, np.ones((1, 400), int), uv, np.tile(0.01 * np.eye(2), (400, 1, 1)))
    rays = Rays(rig, seen, np.ones(400, bool))
    sharp = sharpened(said.xyz, said.cov, GAP.start, rays)
    assert (sharp.detection[:, 0] >= 0).mean() > 0.7
    before, after = (np.median(off(one, motion, GAP)) for one in (said, sharp))
    assert after < before / 3 and after < 1.5


def test_the_pair_that_is_least_off_is_taken_of_many():
    motion = segment([0, 0, 400.0], twist=1.0)
    far = motion.xyz[1:] * 1.0
    far[:, :, 1] += 300 + 100 * np.sin(np.arange(400) / 15)
    xyz = np.concatenate([far, motion.xyz])
    many = MarkerArray(xyz, 100.0, ("X", "Y", *motion.names))
    gap = Gap(2, 150, 210)
    for fill in (fill_along_line, fill_circle):
        assert fill(many.hidden([gap]), [gap])[0].references == (3, 4)


def test_gaps_at_an_end_have_one_side_and_markers_never_seen_a_reason():
    motion = segment([60.0, 0, 400.0])
    end = Gap(0, 370, 400)
    said = fill_circle(motion.hidden([end]), [end])[0]
    assert off(said, motion, end).max() < 15.0 and np.isfinite(said.cov).all()
    never = Gap(0, 0, 400)
    assert "nowhere seen" in fill_circle(motion.hidden([never]), [never])[0].reason
    alone = MarkerArray(motion.xyz[:2], 100.0, motion.names[:2])
    for fill in (fill_along_line, fill_circle):
        assert "two reference markers" in fill(alone.hidden([GAP]), [GAP])[0].reason
    with pytest.raises(ValueError, match="wanted two different ones"):
        Circle(reference_markers=("TIB1",))
