"""Images of a stretch that points hold before it and after it, where these meet or elsewhere."""

import numpy as np
import pytest

from kinemark.track.simultaneous import Simultaneous
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.ghosts.chance_meetings import chance_meetings
from kinemark.track.simultaneous.ghosts.drift_beyond import drifting_beyond
from kinemark.track.simultaneous.ghosts.drifting_pairs import drifting, usual_residuals
from kinemark.track.simultaneous.ghosts.held_beyond import MOST, held_elsewhere
from support.laboratory import observe, ring
from support.motions import dance

NOISE, MARKERS, FRAMES, METHOD = 0.1, 8, 200, Simultaneous()
PART = np.arange(98, 101)
ONE, OTHER, MEETING = 0, MARKERS, MARKERS + 1


def meeting(aside=60.0):
    """Frame, track and detections (4, P) of points, and the images: markers ONE and OTHER move alike, so that the image
    of ONE in camera 0 fits that of OTHER in camera 1. In PART these two make track MEETING. Otherwise ONE has a point
    of cameras 0, 2 and 3, and OTHER of 1, 2 and 3. With no distance `aside` both are one marker."""
    rig, xyz = ring(4), dance(n=MARKERS, frames=FRAMES, seed=2)
    along = rig[0].centre - rig[1].centre
    xyz = np.concatenate([xyz, xyz[:1] + aside * along / np.linalg.norm(along)])
    detections, marker = observe(rig, xyz, noise=NOISE, seed=3)
    images = read_images(detections, rig).noisier(np.full(4, NOISE**2))
    whole = np.full((4, MARKERS + 2, FRAMES), -1)
    whole[images.camera, marker, images.frame] = np.arange(len(marker))
    other = whole[1, OTHER if aside else ONE].copy()
    usable = ~np.isin(marker, [ONE, OTHER])
    usable[whole[0, ONE]] = usable[other] = True
    whole[0, MEETING, PART], whole[1, MEETING, PART] = whole[0, ONE, PART], other[PART]
    whole[1, ONE], whole[0, OTHER] = -1 if aside else whole[1, ONE], -1
    whole[:, ONE, PART], whole[:, OTHER, PART] = -1, -1
    if not aside:
        whole[:, OTHER] = -1
    detection = whole.reshape(4, -1)
    kept = (detection >= 0).any(0)
    frame, id = np.tile(np.arange(FRAMES), MARKERS + 2), np.repeat(np.arange(MARKERS + 2), FRAMES)
    images = images._replace(usable=usable, by_cell=images.by_cell.keep(usable))
    return frame[kept], id[kept], detection[:, kept], images


def score(aside=60.0):
    frame, id, detection, images = meeting(aside)
    return held_elsewhere(frame, detection, np.where(id == MEETING, 0, -1), 1, images, 0.0)[0]


def test_points_that_hold_either_image_alone_lie_elsewhere():
    """In each frame beyond, before and after, a point of ONE and a point of OTHER."""
    assert np.log1p(4 * MOST) >= score() > np.log(40.0)


def test_points_of_the_same_marker_lie_there():
    assert score(aside=0.0) == 0.0


def test_a_stretch_of_two_points_is_not_told():
    frame, id, detection, images = meeting()
    few = (id == MEETING) & (frame < PART[2])
    assert held_elsewhere(frame, detection, np.where(few, 0, -1), 1, images, 0.0) == 0.0


@pytest.mark.parametrize("aside", [60.0, 0.0])
def test_a_meeting_that_does_not_drift_and_has_no_rival_is_given_up(aside):
    """No other judge tells it, as both markers move alike."""
    frame, id, detection, images = meeting(aside)
    usual = usual_residuals(frame, id, detection, images, METHOD.gate)
    known = frame, id, detection, images, usual
    assert not drifting(*known, METHOD.gate).any()
    assert not drifting_beyond(*known, 0.0, METHOD.gate, 1 / 100).any()
    out = chance_meetings(*known, 0.0, METHOD.gate)
    assert not out[id != MEETING].any()
    assert out[id == MEETING].all() == out.any() == (aside > 0)
