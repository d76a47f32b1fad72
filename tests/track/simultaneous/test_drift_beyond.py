"""Chance meetings of two images, told by where these go on before they meet and after they part."""

import numpy as np
import pytest

from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.candidate_points import fundamentals
from kinemark.track.simultaneous.ghosts.drift_beyond import drifting_beyond
from kinemark.track.simultaneous.ghosts.drifting_pairs import drifting, usual_residuals
from support.laboratory import observe, ring
from support.motions import dance

NOISE, MARKERS, FRAMES, GATE, PAIR = 0.1, 8, 120, 5.0, [0, 1]
SHORT = np.arange(50, 60)
TURN = np.array([[0.0, 1.0], [-1.0, 0.0]])
AFTER = np.arange(FRAMES) - SHORT.mean()


class Meeting:
    """Points of all markers but 0 in four cameras; of that one in frames SHORT those of the cameras PAIR alone.

    The second of these has its images `px` (FRAMES) across the lines of the first, and shaken along them. They are
    taken for five times as noisy as they are, so that all of SHORT pass the gate.
    """

    def __init__(self, px, *, frames=SHORT, hidden=(), shaken=0.0):
        rig = ring(4)
        detections, marker = observe(rig, dance(n=MARKERS, frames=FRAMES, seed=2), noise=NOISE, seed=3)
        images = read_images(detections, rig).noisier(np.full(4, (5 * NOISE) ** 2))
        detection = np.full((4, MARKERS * FRAMES), -1)
        detection[images.camera, marker * FRAMES + images.frame] = np.arange(len(marker))
        a, b = detection[PAIR, :FRAMES]
        line = np.column_stack([images.uv[a], np.ones(FRAMES)]) @ fundamentals(images.P)[0, 1].T
        uv, usable = images.uv.copy(), np.ones(len(marker), bool)
        across = line[:, :2] / np.linalg.norm(line[:, :2], axis=1)[:, None]
        uv[b] += np.asarray(px)[:, None] * across + (shaken * (-1.0) ** np.arange(FRAMES))[:, None] * across @ TURN
        usable[b[list(hidden)]] = False
        index = images.by_cell.keep(usable)
        self.images = images._replace(uv=uv, usable=usable, by_cell=index)
        detection[2:, :FRAMES] = -1
        kept = np.ones(MARKERS * FRAMES, bool)
        kept[:FRAMES] = np.isin(np.arange(FRAMES), frames)
        self.frame, self.id = np.tile(np.arange(FRAMES), MARKERS)[kept], np.repeat(np.arange(MARKERS), FRAMES)[kept]
        self.detection = detection[:, kept]

    def given_up(self, judge, *more):
        usual = usual_residuals(self.frame, self.id, self.detection, self.images, GATE)
        return judge(self.frame, self.id, self.detection, self.images, usual, *more)

    def beyond(self, rate=100):
        out = self.given_up(drifting_beyond, 0.0, GATE, 1 / rate)
        assert not out[self.id > 0].any()
        return self.frame[out].tolist()


MEET = 0.002 * AFTER**3
"""px: 0.2 at most in SHORT, which noise hides, and 4 px 8 frames beyond it."""


def test_images_that_part_after_they_met_are_two_markers():
    meeting = Meeting(MEET)
    assert not meeting.given_up(drifting, GATE).any()
    assert meeting.beyond() == SHORT.tolist()


def test_slow_drift_at_a_high_rate_is_looked_at_for_longer():
    """0.2 px 8 frames beyond, which noise hides, and 0.7 px 15 frames beyond, which is 0.06 s at 250 Hz."""
    slow = 0.0001 * AFTER**3
    assert not Meeting(slow).beyond()
    assert Meeting(slow).beyond(rate=250) == SHORT.tolist()


def test_images_of_one_marker_stay_wherever_they_go_on():
    assert not Meeting(0 * AFTER).beyond()


def test_images_that_end_with_the_track_stay():
    beside = [*range(SHORT[0] - 10, SHORT[0]), *range(SHORT[-1] + 1, SHORT[-1] + 11)]
    assert not Meeting(MEET, hidden=beside).beyond()


def test_a_residual_that_jumps_is_another_marker_s_image_in_place_of_one_that_is_hidden():
    """Where a marker shakes its images go on in a wide place, but along the lines of the other camera."""
    assert Meeting(MEET, shaken=1.2).beyond() == SHORT.tolist()
    away = np.where(np.isin(np.arange(FRAMES), SHORT), 0.0, 3.8)
    assert not Meeting(away, shaken=1.2).beyond()


def test_images_of_a_marker_that_are_off_for_a_while_beside_its_stretch_are_no_other_marker_s():
    """By 1.5 px, ten times the noise, and within the gate."""
    off = np.where(np.isin(np.arange(FRAMES), SHORT), 0.0, 1.5)
    assert not Meeting(off).beyond()


@pytest.mark.parametrize(("more", "judged"), [(30, True), (42, False)])
def test_long_stretches_tell_by_themselves(more, judged):
    frames = np.arange(SHORT[0] - more // 2, SHORT[-1] + 1 + more - more // 2)
    px = np.sign(AFTER) * np.maximum(np.abs(AFTER) - more / 2, 0) ** 3 * 0.002
    assert bool(Meeting(px, frames=frames).beyond()) == judged


def seen_by_three(px):
    """The same, but for one point of the track, which a third camera sees."""
    meeting = Meeting(px)
    meeting.detection[2, meeting.id == 0] = np.where(np.arange(len(SHORT)) == 4, 0, -1)
    return meeting


def test_images_that_part_are_two_markers_also_in_a_track_that_three_cameras_see():
    assert seen_by_three(MEET).beyond() == np.delete(SHORT, 4).tolist()


def test_what_a_calibration_leaves_of_a_track_that_three_cameras_see_is_there_beyond_its_stretch_too():
    """0.4 px all the time, as of no other marker."""
    apart = np.full(FRAMES, 0.4)
    assert Meeting(apart).beyond() == SHORT.tolist()
    assert not seen_by_three(apart).beyond()
