"""Cameras all round a subject who hides them from each other, so that each marker is seen by two of them or by one:
none of them is accused, and one that was turned elsewhere is."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import Detections, Rig
from kinemark.geometry import project
from kinemark.track.simultaneous import diagnose, track_simultaneously
from kinemark.track.simultaneous.rig.unfitting_stretches import Stretch, unfitting_stretches
from kinemark.track.simultaneous.simultaneous_method import DEFAULT
from support.laboratory import camera

RATE, FRAMES = 50.0, 150
WIDE = np.cos(np.deg2rad(80.0))
"""A marker on the body is seen from up to 80° beside its normal."""


def all_round(n, seed):
    """Cameras at uneven places of a circle."""
    rng = np.random.default_rng(seed)
    at = 2 * np.pi * (np.arange(n) + rng.uniform(-0.15, 0.15, n)) / n
    places = np.stack([3800 * np.cos(at), 3800 * np.sin(at), rng.uniform(1800, 2600, n)], 1)
    return Rig(tuple(camera(f"cam{k + 1}", place) for k, place in enumerate(places)))


def seen_on(rig, seed, markers=30):
    """A body of 300 mm that stands, sways and turns a little, (F, M, 3) mm, and what the cameras see of it."""
    rng, t = np.random.default_rng(seed), np.arange(FRAMES) / RATE
    at, up = rng.uniform(0, 2 * np.pi, markers), rng.uniform(100, 1700, markers)
    turned = at + 0.15 * np.sin(2 * t)[:, None]
    normal = np.stack([np.cos(turned), np.sin(turned), 0 * turned], -1)
    sway = np.stack([60 * np.sin(1.3 * t), 50 * np.cos(0.9 * t), 0 * t], -1)
    xyz = 150 * normal + np.broadcast_to(up[:, None] * [0.0, 0.0, 1.0], normal.shape) + sway[:, None]
    counts, uv, of = np.zeros((len(rig), FRAMES), int), [], np.zeros((FRAMES, markers), int)
    for c, one in enumerate(rig):
        ray = -one.R.T @ one.t - xyz
        seen = (ray * normal).sum(-1) > WIDE * np.linalg.norm(ray, axis=-1)
        counts[c], of = seen.sum(1), of + seen
        uv.append(project(one, xyz[seen]) + rng.normal(0, 0.15, (seen.sum(), 2)))
    return Detections.build(rig.names, RATE, counts, np.concatenate(uv)), int((of >= 2).sum())


def with_first_turned(rig, axes, degrees):
    """The same, its first camera turned from where it is calibrated."""
    turn = Rotation.from_euler(axes, degrees, degrees=True).as_matrix()
    return replace(rig, cameras=(replace(rig[0], R=turn @ rig[0].R, t=turn @ rig[0].t), *rig.cameras[1:]))


def with_each_turned(rig, seed, px):
    """The same, its cameras turned by about so many px."""
    rng, turned = np.random.default_rng(seed), []
    for one in rig:
        turn = Rotation.from_euler("xy", px / one.K[0, 0] * rng.normal(size=2)).as_matrix()
        turned.append(replace(one, R=turn @ one.R, t=turn @ one.t))
    return Rig(tuple(turned))


def told(rig, detections):
    result = track_simultaneously(detections, rig, DEFAULT)
    kinds = {(f.kind, f.cameras) for f in diagnose(detections, rig, result) if f.kind.startswith("camera_")}
    return kinds, len(result.tracks.cloud)


@pytest.mark.parametrize(("n", "seed"), [(3, 2), (4, 1), (4, 3), (4, 4)])
def test_a_camera_that_sees_another_side_is_not_accused(n, seed):
    rig = all_round(n, seed)
    detections, by_two = seen_on(rig, seed)
    kinds, points = told(rig, detections)
    assert kinds == set()
    assert points > 0.95 * by_two


@pytest.mark.parametrize("seed", [28, 30])
def test_a_camera_that_shares_a_marker_at_a_time_is_not_left_out(seed):
    """Of the samples 21 and 40 % were lost."""
    rig = all_round(3, seed)
    detections, by_two = seen_on(rig, seed, markers=15)
    kinds, points = told(rig, detections)
    assert kinds == set()
    assert points > 0.95 * by_two


@pytest.mark.parametrize(("n", "seed"), [(3, 2), (4, 2)])
def test_a_camera_that_was_turned_elsewhere_is_told(n, seed):
    rig = all_round(n, seed)
    detections, _ = seen_on(rig, seed)
    kinds, _ = told(with_first_turned(rig, "yz", [9, 7]), detections)
    assert kinds == {("camera_fits_nothing", ("cam1",))}


@pytest.mark.parametrize("seed", [1, 3])
def test_a_camera_that_sees_another_side_of_many_markers_is_not_left_out(seed):
    """Most pairs of images near each other's lines are by chance."""
    rig = all_round(3, seed)
    detections, by_two = seen_on(rig, seed, markers=45)
    kinds, points = told(rig, detections)
    assert not {"camera_fits_nothing", "camera_in_doubt"} & {kind for kind, _ in kinds}
    assert points > 0.95 * by_two


def test_a_camera_that_sees_another_side_of_noisy_markers_is_not_left_out():
    """Images of one marker lie in a wider heap beside each other's lines; of the samples 41 % were lost."""
    rig = all_round(3, 3)
    detections, by_two = seen_on(rig, 3, markers=45)
    noise = np.random.default_rng(3).normal(0, 0.37, detections.uv.shape)
    kinds, points = told(rig, replace(detections, uv=detections.uv + noise))
    assert not {"camera_fits_nothing", "camera_in_doubt"} & {kind for kind, _ in kinds}
    assert points > 0.9 * by_two


def test_cameras_that_see_hardly_a_marker_together_do_not_tell_of_a_third():
    """Nine in ten samples were lost, as a good camera was left out."""
    rig = all_round(3, 3)
    detections, by_two = seen_on(rig, 3, markers=60)
    kinds, points = told(with_each_turned(rig, 80, px=1.0), detections)
    assert not {kind for kind, _ in kinds} - {"camera_in_doubt"}
    assert points > 0.9 * by_two


@pytest.mark.parametrize(("seed", "axis"), [(4, "x"), (5, "y")])
def test_a_turned_camera_of_three_is_left_out_though_markers_that_stand_fit_it_by_chance(seed, axis):
    """No camera was told, and of 5 half of the points or more were of no marker."""
    rig = all_round(3, seed)
    detections, by_two = seen_on(rig, seed, markers=45)
    kinds, points = told(with_first_turned(rig, axis, 1.0), detections)
    assert kinds == {("camera_fits_nothing", ("cam1",))}
    assert points < 0.5 * by_two


def test_where_three_cameras_do_not_tell_which_is_wrong_one_is_in_doubt():
    rig = all_round(3, 2)
    detections, _ = seen_on(rig, 2, markers=45)
    kinds, _ = told(with_first_turned(rig, "yz", [9, 7]), detections)
    assert kinds == {("camera_in_doubt", ("cam1",))}


def test_a_camera_that_fits_nowhere_makes_no_good_one_lost_in_parts():
    """One was, for the first 97 frames."""
    rig = all_round(3, 24)
    detections, _ = seen_on(rig, 24, markers=15)
    found = unfitting_stretches(detections, with_first_turned(rig, "y", 1.5))
    assert found == (Stretch(0, 0, FRAMES),)


def test_a_camera_that_was_bumped_is_told_by_the_few_markers_that_it_shares():
    """At a time these are one or two, but they are many tracks'."""
    rig = all_round(5, 33)
    detections, _ = seen_on(rig, 33, markers=20)
    kinds, _ = told(with_first_turned(rig, "y", 0.5), detections)
    assert kinds == {("camera_shifted", ("cam1",))}
