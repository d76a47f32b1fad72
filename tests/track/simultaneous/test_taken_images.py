"""Images that a track has for a moment, of another track's marker."""

import numpy as np
import pytest

from kinemark.track.simultaneous import Simultaneous, track_detections
from kinemark.track.simultaneous.candidate_points import intersect
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.neighbouring_points import TrackPoints
from kinemark.track.simultaneous.taken_images import AROUND, without_taken
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

FRAMES, AT, METHOD = 60, 30, Simultaneous()
ONE, OTHER = 0, 1


def two_tracks(*, hidden, first=AT, last=AT, others=(0, 1), theirs=(1, 2)):
    """Points and detections of ONE, which cameras `others` see, and of OTHER 15 mm beside it, which `theirs` see, and
    the images. From frame `first` to `last` camera 1 has no image of the marker `hidden`, and ONE has the other's."""
    xyz = dance(n=1, frames=FRAMES, seed=2)
    rig = ring(4)
    beside = xyz + np.array([3.0, 4.0, 14.0])
    detections, marker = observe(rig, np.concatenate([xyz, beside]), noise=0.1, seed=3)
    images = read_images(detections, rig)
    held = np.full((4, 2, FRAMES), -1)
    held[images.camera, marker, images.frame] = np.arange(len(marker))
    part, its = slice(first, last + 1), held[1, 1 - hidden].copy()
    for track, cameras in ((ONE, others), (OTHER, theirs)):
        held[[c for c in range(4) if c not in cameras], track] = -1
    held[1, ONE, part], held[1, OTHER, part] = its[part], -1
    held = held.reshape(4, -1)
    frame, id = np.tile(np.arange(FRAMES), 2), np.repeat(np.arange(2), FRAMES)
    there = (held >= 0).sum(0) >= 2
    point = intersect(images, held[:, there])
    points = TrackPoints(frame[there], id[there], point.xyz.T, point.cov.transpose(2, 0, 1))
    return points, held[:, there], images


def taken(points, detection, images):
    """(n, 2) the track and frame of each image that is taken, all of camera 1."""
    out = without_taken(points, detection, images, 1 / 100, METHOD)
    changed = out != detection
    assert (out[changed] == -1).all() and not changed[[0, 2, 3]].any()
    return np.column_stack([points.id, points.frame])[changed[1]].tolist()


@pytest.mark.parametrize("theirs", [(1, 2), (1, 2, 3)])
@pytest.mark.parametrize("last", [AT, AT + AROUND - 1])
def test_an_image_that_the_other_track_lacks_for_a_moment_is_taken_back(theirs, last):
    """Whether the other has a point there or not."""
    tracks = two_tracks(hidden=ONE, last=last, theirs=theirs)
    assert taken(*tracks) == [[ONE, frame] for frame in range(AT, last + 1)]


def test_of_three_images_the_wrong_one_is_taken():
    assert taken(*two_tracks(hidden=ONE, others=(0, 1, 3))) == [[ONE, AT]]


@pytest.mark.parametrize("theirs", [(1, 2), (1, 2, 3)])
def test_an_image_stays_with_its_track_while_the_other_is_hidden(theirs):
    assert taken(*two_tracks(hidden=OTHER, theirs=theirs)) == []


def test_nothing_is_claimed_that_is_lacking_for_long():
    assert taken(*two_tracks(hidden=ONE, first=AT - AROUND, last=AT + AROUND)) == []


def test_without_tracks_there_is_nothing_to_take():
    points, detection, images = two_tracks(hidden=ONE)
    none = np.zeros(len(points.id), bool)
    assert without_taken(points.take(none), detection[:, none], images, 1 / 100, METHOD).shape == (4, 0)


def test_tracks_that_lose_an_image_to_others_have_it_again():
    """Of sixty markers on six cameras, without it: three ghosts and 2666 samples of two cameras."""
    made = make(scene(30226))
    found = tally(made, track_detections(made.detections, made.rig))
    assert found.ghosts <= 1
    assert found.two_found >= 2669
