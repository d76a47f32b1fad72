"""Points of an adjusted rig, solved with the given one: those that only motion tells go over with the others."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.geometry.weighted_points import DEFAULT_ERRORS
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.noise.measurement_noise import Noise
from kinemark.track.simultaneous.points.solved_points import (
    Solver,
    Working,
    _gone_over,
    on_given_rig,
    solved,
    with_few_smoothed,
)
from kinemark.track.simultaneous.simultaneous_method import Simultaneous
from support.laboratory import observe, ring
from support.motions import dance

MARKERS, FRAMES = 4, 40
ELSEWHERE, TURN = np.array([-5.0, 0.5, -10.0]), np.array([0.002, -0.001, 0.0015])
"""mm and rad: how a rig that is adjusted to images stands beside the given one."""

METHOD = Simultaneous()

BESIDE = np.array([0.0, 1000.0, 0.0])
"""mm, from markers on a line."""


def recorded(noise):
    """A solver, and the points of markers by the given rig; every ninth has the image of one camera alone."""
    rig, xyz = ring(4), dance(n=MARKERS, frames=FRAMES, seed=2)
    detections, marker = observe(rig, xyz, noise=noise, seed=3)
    images = read_images(detections, rig)
    detection = np.full((4, FRAMES * MARKERS), -1)
    detection[images.camera, images.frame * MARKERS + marker] = np.arange(len(marker))
    frame, which = np.divmod(np.arange(FRAMES * MARKERS), MARKERS)
    true, none, vague = xyz[which, frame], np.zeros(len(rig)), np.arange(len(frame)) % 9 == 0
    solver = Solver(
        detections,
        Working(rig, images, Noise(none, none, none, none, none, none)),
        np.zeros(len(marker), bool),
        DEFAULT_ERRORS,
    )
    cloud = solved(frame, detection, true.T, solver)
    return solver, cloud, vague


def standing_elsewhere(cloud, vague):
    """The points by a rig that stands elsewhere; the vague ones are known by motion, to a millimetre."""
    middle = cloud.xyz.mean(0)
    xyz = middle + (cloud.xyz - middle) @ Rotation.from_rotvec(TURN).as_matrix().T + ELSEWHERE
    one = np.where(np.arange(4) > 0, -1, cloud.detection)
    cov = np.where(vague[:, None, None], np.eye(3), cloud.cov)
    return replace(cloud, xyz=xyz, cov=cov, detection=np.where(vague[:, None], one, cloud.detection))


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_points_that_motion_tells_stand_among_the_others(noise):
    solver, cloud, vague = recorded(noise)
    back = on_given_rig(standing_elsewhere(cloud, vague), solver)
    np.testing.assert_allclose(back.xyz[~vague], cloud.xyz[~vague], atol=0.02)
    np.testing.assert_allclose(back.xyz[vague], cloud.xyz[vague], atol=0.02)  # 11 mm where they stayed


def test_what_does_not_go_over_alike_is_in_the_covariance():
    """The others stand 3 mm here or there by the adjusted rig, as lenses do; so a vague one does too."""
    solver, cloud, vague = recorded(0.0)
    sent = standing_elsewhere(cloud, vague)
    bent = 3.0 * np.sin(cloud.xyz[:, :1] / 30.0) * np.array([1.0, 0.0, 0.0])
    back = on_given_rig(replace(sent, xyz=sent.xyz + bent), solver)
    off = back.xyz[vague] - cloud.xyz[vague]
    assert 1.0 < np.sqrt((off[:, 0] ** 2).mean()) < 1.5 * np.sqrt(back.cov[vague][:, 0, 0].mean() - 1)
    np.testing.assert_allclose(back.cov[vague][:, 2, 2], 1.0, atol=0.1)


def test_points_none_of_which_the_images_tell_stay():
    solver, cloud, _ = recorded(0.0)
    sent = standing_elsewhere(cloud, np.ones(len(cloud), bool))
    np.testing.assert_array_equal(on_given_rig(sent, solver).xyz, sent.xyz)


def test_points_on_a_line_say_nothing_of_what_is_beside_it():
    """A vague point a metre beside goes as they go, and not as their noise would turn it."""
    _, cloud, vague = recorded(0.0)
    line = np.array([1.0, 0.0, 0.0])
    middle = cloud.xyz.mean(0)
    noise = np.random.default_rng(1).normal(0, 0.3, cloud.xyz.shape)
    flat = middle + ((cloud.xyz - middle) @ line)[:, None] * line + noise
    before = np.where(vague[:, None], flat + BESIDE, flat)
    after = before + ELSEWHERE + np.random.default_rng(2).normal(0, 0.3, flat.shape)
    xyz, _ = _gone_over(before, after, np.flatnonzero(~vague), np.flatnonzero(vague))
    assert np.abs(xyz - before[vague] - ELSEWHERE).max() < 1.0


@pytest.mark.parametrize("telling", [4, 8, 30])
def test_few_points_do_not_send_others_astray(telling):
    """By the noise of few points others would go anywhere, with a covariance of 0."""
    rng, off, stated = np.random.default_rng(3), [], []
    for _ in range(100):
        before = np.vstack([rng.normal(0, 300.0, (telling, 3)), rng.normal(0, 900.0, 3)])
        after = before + ELSEWHERE + rng.normal(0, 1.0, before.shape)
        xyz, left = _gone_over(before, after, np.arange(telling), np.array([telling]))
        off.append(xyz[0] - before[-1] - ELSEWHERE)
        stated.append(np.linalg.inv(left[0]))
    assert np.abs(off).max() < 8.0  # 41 mm of four and 15 of eight else
    squared = np.einsum("ij,ijk,ik->i", off, stated, off)
    assert np.median(squared) < 6.0


def test_points_of_merged_images_are_where_their_tracks_lead():
    """Of three frames in ten one of two images is merged, and 15 mm beside: all that two cameras see stays."""
    solver, cloud, _ = recorded(0.1)
    ids, frame = np.tile(np.arange(MARKERS), FRAMES), cloud.frame
    few = (frame % 10 > 3) & (frame % 10 < 7)
    two = cloud.detection.copy()
    two[few, 2:] = -1
    merged = np.zeros(len(solver.detections), bool)
    merged[two[few, 1]] = True
    off = np.where(few[:, None], [0.0, 15.0, 0.0], 0.0)
    seen = replace(
        cloud, detection=two, xyz=cloud.xyz + off, cov=np.where(few[:, None, None], 100.0 * np.eye(3), cloud.cov)
    )
    images = solver.working.images._replace(merged=merged)
    found = with_few_smoothed(seen, ids, images, Simultaneous(), 0.5)
    np.testing.assert_array_equal(found.xyz[~few], seen.xyz[~few])
    error, sd = found.xyz[few] - cloud.xyz[few], np.sqrt(np.trace(found.cov[few], axis1=1, axis2=2))
    assert np.sqrt((error**2).sum(1).mean()) < 1.0
    assert 0.5 < np.sqrt((error**2).sum(1).mean()) / np.median(sd) < 1.5
    alone = with_few_smoothed(seen.keep(few), ids[few], images, Simultaneous(), 0.5)
    np.testing.assert_array_equal(alone.xyz, seen.xyz[few])


ALONG = np.array([0.6, 0.0, 0.8])
"""A ray along which two cameras side by side do not know where a point is."""


def led_along_a_ray(vague):
    """The points of markers, and the same with some (P) up to 60 mm along a ray, which is known to 30 mm there."""
    solver, cloud, _ = recorded(0.1)
    off = np.where(vague, np.random.default_rng(5).normal(0, 30.0, len(vague)), 0.0)[:, None] * ALONG
    wide = np.where(vague[:, None, None], 900.0 * np.outer(ALONG, ALONG), 0.0)
    seen = replace(cloud, xyz=cloud.xyz + off, cov=cloud.cov + wide)
    return cloud, seen, with_few_smoothed(seen, np.tile(np.arange(MARKERS), FRAMES), solver.working.images, METHOD, 0.5)


def test_points_that_others_near_know_better_are_where_their_tracks_lead():
    """Of three frames in ten, at the beginning and the end of a recording too."""
    vague = np.repeat((np.arange(FRAMES) + 4) % 10 > 6, MARKERS)
    true, seen, found = led_along_a_ray(vague)
    np.testing.assert_array_equal(found.xyz[~vague], seen.xyz[~vague])
    off, sd = found.xyz[vague] - true.xyz[vague], np.sqrt(np.trace(found.cov[vague], axis1=1, axis2=2))
    assert np.sqrt((off**2).sum(1).mean()) < 2.0  # 29 before
    assert 0.3 < np.sqrt((off**2).sum(1).mean()) / np.median(sd) < 1.5
    assert (np.linalg.norm(off, axis=1) < 4 * sd).all()


def test_points_that_are_all_as_vague_stay():
    _, seen, found = led_along_a_ray(np.ones(MARKERS * FRAMES, bool))
    np.testing.assert_array_equal(found.xyz, seen.xyz)
    np.testing.assert_array_equal(found.cov, seen.cov)
