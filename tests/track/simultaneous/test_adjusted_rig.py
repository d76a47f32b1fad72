"""The rig adjusted to epipolar residuals before anything is tracked."""

import numpy as np
import pytest

from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.candidate_points import intersect
from kinemark.track.simultaneous.rig.adjusted_rig import adjusted_rig
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes.placements import off

FRAMES = 120


def seen():
    """A ring of three cameras, detections of eight markers, and those of each point (C, S)."""
    true = ring(3)
    detections, marker = observe(true, dance(frames=FRAMES, seed=2), noise=0.2, seed=3)
    images = read_images(detections, true)
    detection = np.full((3, 8 * FRAMES), -1)
    detection[images.camera, marker * FRAMES + images.frame] = np.arange(len(marker))
    return true, detections, detection


@pytest.mark.parametrize("seed", [1, 2, 7])
def test_two_cameras_whose_lines_are_far_off_are_adjusted_where_those_of_others_are_not(seed):
    """Of a file 2 px off, the residuals of two cameras lie 3 to 5 px aside, those of two others about 0."""
    true, detections, detection = seen()
    wrong = off(true, 2.0, np.random.default_rng(seed))
    adjusted = adjusted_rig(read_images(detections, wrong), wrong, list(range(0, FRAMES, 5)))
    squared, best = (
        np.median(intersect(read_images(detections, rig), detection).squared.sum(0)) for rig in (adjusted, true)
    )
    assert squared < 1.5 * best
    assert len(track_detections(detections, wrong).cloud) == 8 * FRAMES
