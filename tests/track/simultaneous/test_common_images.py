"""Images of two markers, in a file that does not say so, which another camera sees apart."""

import numpy as np
import pytest

from kinemark.track.simultaneous import Simultaneous, track_detections
from kinemark.track.simultaneous.common_images import of_common_images
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.drifting_pairs import usual_residuals
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

NOISE, MARKERS, FRAMES, RATE, METHOD = 0.1, 8, 120, 100.0, Simultaneous()
PART = np.arange(40, 70)
ONE, OTHER = 0, MARKERS
BESIDE = np.array([15.0, 15.0, 3.0])
RESOLUTION = 10.0


def given_up(share=0.5, beside=BESIDE, free=True, r=RESOLUTION):
    """Frames of marker ONE that are given up. In PART two cameras see it: camera 0 has an image that lies a share of
    the way to that of marker OTHER, `beside` (3) mm from it, and camera 1 has images of both, of which OTHER's may be
    free."""
    rig, xyz = ring(4), dance(n=MARKERS, frames=FRAMES, seed=2)
    detections, marker = observe(rig, np.concatenate([xyz, xyz[:1] + beside]), noise=NOISE, seed=3)
    images = read_images(detections, rig).noisier(np.full(4, (5 * NOISE) ** 2))
    whole = np.full((4, MARKERS + 1, FRAMES), -1)
    whole[images.camera, marker, images.frame] = np.arange(len(marker))
    uv = images.uv.copy()
    uv[whole[0, ONE, PART]] += share * (uv[whole[0, OTHER, PART]] - uv[whole[0, ONE, PART]])
    usable = marker != OTHER
    usable[whole[1, OTHER, PART]] = free
    usable[whole[2:, ONE, PART]] = False
    images = images._replace(uv=uv, usable=usable, by_cell=images.by_cell.keep(usable))
    detection = whole[:, :MARKERS].copy()
    detection[2:, ONE, PART] = -1
    frame, id = np.tile(np.arange(FRAMES), MARKERS), np.repeat(np.arange(MARKERS), FRAMES)
    detection = detection.reshape(4, -1)
    usual = usual_residuals(frame, id, detection, images, METHOD.gate)
    out = of_common_images(frame, id, detection, images, usual, r, 1 / RATE, METHOD)
    assert not out[id != ONE].any()
    return frame[out].tolist()


def test_an_image_in_the_middle_of_two_is_of_both():
    assert given_up() == PART.tolist()


@pytest.mark.parametrize("share", [0.0, 0.2])
def test_an_image_of_the_marker_itself_is_not(share):
    """The other marker is hidden in this camera."""
    assert not given_up(share)


def test_without_an_image_beside_it_nothing_is_told():
    assert not given_up(free=False)


@pytest.mark.parametrize("r", [0.0, 1.0])
def test_where_images_do_not_merge_or_the_other_is_far_nothing_is_told(r):
    assert not given_up(r=r)


def test_a_scene_in_which_markers_merge():
    """Before 241 of its points were no marker's, and 6 863 of 7 094 samples of two cameras were found."""
    made = make(scene(22078))
    count = tally(made, track_detections(made.detections, made.rig))
    assert count.ghosts <= 130
    assert count.two_found >= 6860
