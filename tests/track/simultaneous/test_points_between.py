"""Merged images of two markers in several cameras, taken for a third marker between them."""

import numpy as np
import pytest

from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.candidate_points import intersect
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.neighbouring_points import TrackPoints
from kinemark.track.simultaneous.points_between import between_markers
from support.laboratory import observe, ring
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


def test_a_scene_in_which_markers_merge_in_cameras_side_by_side():
    """68 of its points were no marker's without this, and 815 of 826 samples of two cameras were found."""
    made = make(scene(120050))
    count = tally(made, track_detections(made.detections, made.rig))
    assert count.ghosts <= 15
    assert count.two_found >= 813
