"""Of cameras that share each marker by twos the one that was moved is told by pairs of images, and put where it is."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import Detections
from kinemark.track.simultaneous import diagnose, track_simultaneously
from kinemark.track.simultaneous.moved_camera import moved_camera
from kinemark.track.simultaneous.simultaneous_method import DEFAULT
from track.simultaneous.test_cameras_all_round import all_round, seen_on, with_first_turned

SHARED = 5, 45
"""Seed and markers of three cameras all round, who share some 14 of the markers by twos and none by three."""


def ring_of_three(good=True):
    """Three cameras all round and what they see; the first one turned by a degree, unless all are good."""
    seed, markers = SHARED
    rig = all_round(3, seed)
    detections, by_two = seen_on(rig, seed, markers=markers)
    return rig if good else with_first_turned(rig, "y", 1.0), rig, detections, by_two


def test_the_camera_that_was_turned_is_told_with_where_it_stands():
    wrong, right, detections, _ = ring_of_three(good=False)
    ((c, one),) = moved_camera(detections, wrong).suspects.items()
    turn = Rotation.from_matrix(one.camera.R @ right[0].R.T).magnitude()
    assert c == 0 and np.rad2deg(turn) < 0.1
    assert np.linalg.norm(one.camera.centre - right[0].centre) < 10.0
    np.testing.assert_allclose(one.offset, [-20.9, 0.0], atol=1.0)


def test_its_images_are_used_from_there():
    """Two thirds of the samples were lost, as it was left out."""
    wrong, _, detections, by_two = ring_of_three(good=False)
    result = track_simultaneously(detections, wrong, DEFAULT)
    told = [f for f in diagnose(detections, wrong, result) if f.kind == "camera_put_right"]
    assert [f.cameras for f in told] == [("cam1",)]
    assert told[0].values["turned_deg"] == pytest.approx(1.0, abs=0.1) and told[0].values["moved_mm"] < 10.0
    assert result.rig[1] is wrong[1] and result.rig[2] is wrong[2]
    assert len(result.tracks.cloud) > 0.95 * by_two


def test_good_cameras_are_not_suspected():
    _, right, detections, _ = ring_of_three()
    assert moved_camera(detections, right).suspects == {}


def test_evidence_is_the_same_wherever_the_world_begins():
    wrong, _, detections, _ = ring_of_three(good=False)
    far = np.array([4e6, -3e6, 1e6])
    shifted = replace(wrong, cameras=tuple(replace(one, t=one.t - one.R @ far) for one in wrong))
    ((a, here),), ((b, there),) = (moved_camera(detections, each).suspects.items() for each in (wrong, shifted))
    assert a == b
    np.testing.assert_allclose(there.camera.centre - far, here.camera.centre, atol=1.0)


@pytest.mark.parametrize("cameras", [2, 5])
def test_of_two_cameras_and_of_many_none_is_suspected(cameras):
    rig = all_round(cameras, 1)
    detections, _ = seen_on(rig, 1)
    assert moved_camera(detections, with_first_turned(rig, "y", 1.0)).suspects == {}


def test_without_images_nothing_is_suspected():
    rig = all_round(3, 1)
    empty = Detections.build(rig.names, 50.0, np.zeros((3, 20), int), np.zeros((0, 2)))
    assert moved_camera(empty, rig).suspects == {}
