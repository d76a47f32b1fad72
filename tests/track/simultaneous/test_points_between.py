"""Merged images of two markers in several cameras, taken for a third marker between them."""

import numpy as np
import pytest

from kinemark.data import Rig
from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.candidate_points import intersect
from kinemark.track.simultaneous.ghosts.points_between import between_markers
from kinemark.track.simultaneous.points.neighbouring_points import TrackPoints
from support.laboratory import camera, observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

CAMERAS, FRAMES = 6, 20


def three_markers(share, seen=None):
    """Points of two markers 12 mm apart in four cameras, and of a third a share of the way between them in two others;
    with r. Marker `seen` has an image of its own in the first of these."""
    one = dance(n=1, frames=FRAMES, seed=2)
    way = np.array([3.0, 4.0, 11.0])
    rig = ring(CAMERAS)
    detections, marker = observe(rig, np.concatenate([one, one + way, one + share * way]), noise=0.05, seed=3)
    images = read_images(detections, rig)
    held = np.full((CAMERAS, 3, FRAMES), -1)
    held[images.camera, marker, images.frame] = np.arange(len(marker))
    apart = np.linalg.norm(images.uv[held[:2, 0]] - images.uv[held[:2, 1]], axis=-1).max()
    whole = held.copy()
    held[:2, :2], held[2:, 2] = -1, -1
    if seen is not None:
        held[0, seen] = whole[0, seen]
    held = held.reshape(CAMERAS, -1)
    point = intersect(images, held)
    frame, id = np.tile(np.arange(FRAMES), 3), np.repeat(np.arange(3), FRAMES)
    return TrackPoints(frame, id, point.xyz.T, point.cov.transpose(2, 0, 1)), held, images, 1.2 * apart


def test_a_point_half_way_is_given_up():
    points, held, images, r = three_markers(0.5)
    assert (between_markers(points, held, images, r) == (points.id == 2)).all()


@pytest.mark.parametrize("share", [0.0, 1.0, 1.5])
def test_a_point_elsewhere_stays(share):
    assert not between_markers(*three_markers(share)).any()


def test_where_no_images_merge_it_stays():
    points, held, images, _ = three_markers(0.5)
    assert not between_markers(points, held, images, 0.0).any()


@pytest.mark.parametrize("seen", [0, 1])
def test_where_either_marker_has_its_own_image_it_stays(seen):
    """One of both cameras has an image of one of the markers: there is no need of a common one."""
    assert not between_markers(*three_markers(0.5, seen)).any()


ALONG, UP = np.array([20.0, 0.0, 0.0]), np.array([0.0, 0.0, 20.0])
BESIDE = Rig(
    tuple(camera(f"c{i}", place) for i, place in enumerate([(4000, -400, 1500), (4000, 400, 1500), (0, 4000, 1500)]))
)
ACROSS = Rig((*BESIDE, camera("c3", (0, -4000, 1500))))
RESOLUTION = 6.0


def no_track_beside(half, shown=(-1.0, 1.0), own=False, until=FRAMES, rig=BESIDE):
    """Points of the common images of two markers, which two cameras side by side have, `half` (3) mm from either; the
    third camera has images at these shares of `half`, of all but the first `until` a frame; a fourth one has the last
    instead. The first of them may have a track, of an image in camera 0."""
    one = dance(n=1, frames=FRAMES, seed=2)
    detections, marker = observe(
        rig, np.concatenate([one, *(one + share * half for share in shown)]), noise=0.05, seed=3
    )
    c = np.repeat(np.arange(len(rig)), detections.counts.sum(1))
    shows = marker > 0 if rig is BESIDE else marker == c - 1
    kept = np.where(c >= 2, shows, marker == 0) | ((c == 0) & (marker == 1) & own)
    kept &= (marker < 2) | (np.concatenate([np.repeat(np.arange(FRAMES), n) for n in detections.counts]) < until)
    images = read_images(detections.keep(kept), rig)
    held = np.full((len(rig), len(shown) + 1, FRAMES), -1)
    held[images.camera, marker[kept], images.frame] = np.arange(kept.sum())
    held = held[:, : 1 + own].reshape(len(rig), -1)
    point = intersect(images, held)
    frame, id = np.tile(np.arange(FRAMES), 1 + own), np.repeat(np.arange(1 + own), FRAMES)
    return TrackPoints(frame, id, point.xyz.T, point.cov.transpose(2, 0, 1)), held, images, RESOLUTION


def test_a_point_that_another_camera_sees_as_two_is_given_up():
    assert between_markers(*no_track_beside(ALONG)).all()


@pytest.mark.parametrize(("shown", "given_up"), [((1.0, -1.0), True), ((1.0, 1.0), False), ((1.0, -2.0), False)])
def test_a_point_of_which_two_cameras_see_one_side_each_is_given_up(shown, given_up):
    assert (between_markers(*no_track_beside(ALONG, shown, rig=ACROSS)) == given_up).all()


@pytest.mark.parametrize(("until", "given_up"), [(1, True), (0, False)])
def test_a_point_of_which_one_of_both_is_hidden_later_is_given_up(until, given_up):
    """Half of a track and more: with one image alone, at times or always, nothing tells that it is of one of two."""
    assert (between_markers(*no_track_beside(ALONG, until=until)) == given_up).all()


@pytest.mark.parametrize(
    ("half", "shown", "own"),
    [
        pytest.param(ALONG, (1.0,), False, id="one image"),
        pytest.param(ALONG, (-0.2, 1.8), False, id="not half way"),
        pytest.param(UP, (-1.0, 1.0), False, id="too far apart to merge"),
        pytest.param(ALONG / 5, (-1.0, 1.0), False, id="too near to be told apart"),
        pytest.param(ALONG, (-1.0, 1.0), True, id="of a track with an image of its own"),
    ],
)
def test_a_point_beside_other_images_stays(half, shown, own):
    assert not between_markers(*no_track_beside(half, shown, own)).any()


def test_a_scene_in_which_markers_merge_in_cameras_side_by_side():
    """68 of its points were no marker's without this, and 815 of 826 samples of two cameras were found."""
    made = make(scene(120050))
    count = tally(made, track_detections(made.detections, made.rig))
    assert count.ghosts <= 15
    assert count.two_found >= 813
