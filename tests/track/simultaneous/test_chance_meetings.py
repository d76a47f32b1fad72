"""Chance meetings of images of two markers, told by the free images that either of them has."""

import numpy as np
import pytest
from chance_meetings import Counted, fitted

from kinemark.track.simultaneous import Simultaneous, track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.ghosts.chance_meetings import FEW, chance_meetings
from kinemark.track.simultaneous.ghosts.drift_beyond import drifting_beyond
from kinemark.track.simultaneous.ghosts.drifting_pairs import drifting, usual_residuals
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

NOISE, MARKERS, FRAMES, RATE, METHOD = 0.1, 8, 120, 100.0, Simultaneous()
PART, ASIDE = np.arange(40, 60), 200.0
ONE, OTHER = 0, MARKERS


class Meeting:
    """Points of all markers in four cameras; but in PART, those of marker ONE are its image in camera 0 and that of
    marker OTHER in camera 1, which lies ASIDE in the plane of both cameras, so that these images fit.

    The images of cameras 2 and 3 in PART are free: of marker ONE in camera 2, of OTHER in camera 3.
    """

    def __init__(self, aside=ASIDE):
        rig = ring(4)
        xyz = dance(n=MARKERS, frames=FRAMES, seed=2)
        along = rig[0].centre - rig[1].centre
        xyz = np.concatenate([xyz, xyz[:1] + aside * along / np.linalg.norm(along)])
        detections, marker = observe(rig, xyz, noise=NOISE, seed=3)
        images = read_images(detections, rig).noisier(np.full(4, (5 * NOISE) ** 2))
        whole = np.full((4, MARKERS + 1, FRAMES), -1)
        whole[images.camera, marker, images.frame] = np.arange(len(marker))
        free = np.isin(marker, [ONE, OTHER])
        free &= np.isin(images.frame, PART) | (marker == ONE)
        free &= np.where(marker == ONE, images.camera != 3, images.camera != 2)
        usable = free | ~np.isin(marker, [ONE, OTHER])
        usable[whole[:, ONE]] |= ~np.isin(np.arange(FRAMES), PART)
        detection = whole[:, :MARKERS].copy()
        detection[1, ONE, PART], detection[2:, ONE, PART] = whole[1, OTHER, PART], -1
        usable[whole[1, ONE, PART]] = usable[whole[0, OTHER, PART]] = False
        self.images, self.whole = images._replace(usable=usable, by_cell=images.by_cell.keep(usable)), whole
        self.frame, self.id = np.tile(np.arange(FRAMES), MARKERS), np.repeat(np.arange(MARKERS), FRAMES)
        self.detection = detection.reshape(4, -1)

    def without(self, marker, camera):
        usable = self.images.usable.copy()
        usable[self.whole[camera, marker, PART]] = False
        self.images = self.images._replace(usable=usable, by_cell=self.images.by_cell.keep(usable))
        return self

    def alone(self, part=PART):
        """Without the points of marker ONE in other frames, so that no three cameras see the track."""
        kept = (self.id != ONE) | np.isin(self.frame, part)
        self.frame, self.id, self.detection = self.frame[kept], self.id[kept], self.detection[:, kept]
        return self

    def known(self):
        usual = usual_residuals(self.frame, self.id, self.detection, self.images, METHOD.gate)
        return self.frame, self.id, self.detection, self.images, usual

    def given_up(self):
        out = chance_meetings(*self.known(), 0.0, METHOD.gate)
        assert not out[self.id != ONE].any()
        return self.frame[out].tolist()


def test_images_that_both_have_a_rival_are_two_markers():
    """They do not drift: no other judge tells them."""
    meeting = Meeting()
    assert not drifting(*meeting.known(), METHOD.gate).any()
    assert not drifting_beyond(*meeting.known(), 0.0, METHOD.gate, 1 / 100).any()
    assert meeting.given_up() == PART.tolist()


@pytest.mark.parametrize(("marker", "camera"), [(ONE, 2), (OTHER, 3)])
def test_one_rival_that_fits_as_well_tells_nothing(marker, camera):
    assert not Meeting().without(marker, camera).alone().given_up()


def test_the_free_images_of_the_same_marker_are_no_rivals():
    assert not Meeting(aside=0.0).given_up()


@pytest.mark.parametrize("alone", [True, False])
def test_one_rival_that_fits_better_tells(alone):
    """Also where three cameras see the track in other frames."""
    meeting = Meeting().without(ONE, 2)
    uv = meeting.images.uv.copy()
    uv[meeting.whole[0, ONE, PART], 1] += 0.2
    meeting.images = meeting.images._replace(uv=uv)
    assert not drifting(*meeting.known(), METHOD.gate).any()
    assert (meeting.alone() if alone else meeting).given_up() == PART.tolist()


def test_of_a_short_track_less_is_enough():
    """One rival that fits as well does not tell a track of twenty points, but one of four: chance makes more."""
    assert not Meeting().without(ONE, 2).alone().given_up()
    assert Meeting().without(ONE, 2).alone(PART[:4]).given_up() == PART[:4].tolist()
    assert not Meeting().without(ONE, 2).without(OTHER, 3).alone(PART[:4]).given_up()


def test_a_point_of_a_merged_image_is_not_judged_and_those_beside_it_are():
    meeting = Meeting()
    merged = np.zeros(len(meeting.images.uv), bool)
    merged[meeting.whole[0, ONE, PART[3]]] = True
    meeting.images = meeting.images._replace(merged=merged)
    assert meeting.given_up() == np.delete(PART, 3).tolist()


def test_a_merged_image_makes_no_third_of_a_meeting():
    meeting = Meeting()
    merged, third = np.zeros(len(meeting.images.uv), bool), meeting.whole[2, OTHER, PART]
    merged[third], meeting.detection[2, np.isin(meeting.frame, PART) & (meeting.id == ONE)] = True, third
    meeting.images = meeting.images._replace(merged=merged)
    assert meeting.given_up() == PART.tolist()


def test_ghosts_of_images_that_have_rivals_are_not_given():
    """Of sixty markers on three cameras: where nothing is asked of free partners there are 14 ghosts, and ten samples
    more. With partners that had to be linked over half of a stretch there were 11."""
    made = make(scene(130122))
    found = tally(made, track_detections(made.detections, made.rig))
    assert found.ghosts <= 8
    assert found.two_found >= 4570
    assert found.more_found == found.more


def test_the_coefficients_are_fitted_again():
    """By stretches of which (1) itself says how many points are ghosts."""
    rng = np.random.default_rng(4)
    evidence = rng.normal(size=(200, 4))
    points, b = rng.integers(1, 40, 200), np.array([-1.0, 0.4, -0.9, 2.0, 0.7])
    p = 1 / (1 + np.exp(-b[0] - evidence @ b[1:]))
    np.testing.assert_allclose(fitted(Counted(evidence, points * p, points * (1 - p))), b, atol=1e-3)


@pytest.mark.parametrize("cameras", [FEW, FEW + 1])
def test_before_many_cameras_nothing_is_judged(cameras):
    """Where the other cameras see none of these frames, as well."""
    frame, id, detection, images, usual = Meeting().alone(PART[:4]).known()
    detection = np.concatenate([detection, np.full((cameras - 4, len(frame)), -1)])
    assert chance_meetings(frame, id, detection, images, usual, 0.0, METHOD.gate).any() == (cameras == FEW)
