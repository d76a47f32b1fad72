"""Dropped tracks whose images are one marker's by their residuals, given back."""

import numpy as np
import pytest

from kinemark.data import Cloud
from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.candidate_points import fundamentals, intersect
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.drifting_pairs import UsualResiduals, usual_residuals
from kinemark.track.simultaneous.dropped_tracks import given_back
from kinemark.track.simultaneous.passes import Associations
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

NOISE, MARKERS, FRAMES, GATE = 0.1, 8, 120, 5.0
A, B = 0, 1
PART = np.arange(40, 60)


class Dropped:
    """Confirmed tracks of all markers but the first, which two cameras A and B see in PART; its track was dropped.

    Images count as five times as noisy as they are, as where a calibration is off.
    """

    def __init__(self, part=PART, off=None):
        rig = ring(4)
        detections, marker = observe(rig, dance(n=MARKERS, frames=FRAMES, seed=2), noise=NOISE, seed=3)
        images = read_images(detections, rig).noisier(np.full(4, (5 * NOISE) ** 2))
        held = np.full((4, MARKERS, FRAMES), -1)
        held[images.camera, marker, images.frame] = np.arange(len(marker))
        if off is not None:
            images = across_the_lines(images, held[A, 0, part], held[B, 0, part], off)
        self.images = images
        self.frame, self.id = np.repeat(np.arange(FRAMES), MARKERS - 1), np.tile(np.arange(1, MARKERS), FRAMES)
        self.detection = held[:, self.id, self.frame]
        self.part, self.pair = part, np.full((4, len(part)), -1)
        self.pair[[A, B]] = held[:, 0, part][[A, B]]
        self.shared = np.zeros(self.pair.shape, bool)

    def given_back(self, confirmed=tuple(range(1, MARKERS)), usual=None):
        """Frames in which the dropped track is given back, known to `every` beside the confirmed ones."""
        detection = np.concatenate([self.detection, self.pair], 1)
        shared = np.concatenate([np.zeros(self.detection.shape, bool), self.shared], 1)
        frame, id = np.concatenate([self.frame, self.part]), np.concatenate([self.id, 0 * self.part])
        point, none = intersect(self.images, detection), np.zeros(len(frame))
        every = Associations(frame, id, detection, shared, none, none, point.xyz, np.zeros((3, 3, 0)))
        usual = usual or usual_residuals(self.frame, self.id, self.detection, self.images, GATE)
        rows = given_back(every, np.array(confirmed), self.cloud(), self.id, self.images, usual, GATE)
        assert (every.id[rows] == 0).all()
        return every.frame[rows]

    def cloud(self):
        """The points of the confirmed tracks."""
        point = intersect(self.images, self.detection)
        start = np.arange(FRAMES + 1) * (MARKERS - 1)
        cov = point.cov.transpose(2, 0, 1)
        return Cloud(100.0, start, point.xyz.T, cov, np.zeros(len(self.frame)), np.ascontiguousarray(self.detection.T))


def across_the_lines(images, one, other, px):
    """The images with those of `other` (n) moved by px (n) across the lines of `one`'s camera."""
    uv = images.uv.copy()
    line = np.column_stack([uv[one], np.ones(len(one))]) @ fundamentals(images.P)[A, B].T
    uv[other] += np.asarray(px)[:, None] * line[:, :2] / np.linalg.norm(line[:, :2], axis=1)[:, None]
    return images._replace(uv=uv)


def test_a_dropped_track_of_one_marker_is_given_back():
    assert (Dropped().given_back() == PART).all()


@pytest.mark.parametrize(
    "off", [np.linspace(-1, 1, len(PART)), np.full(len(PART), 0.5)], ids=["drift", "within the noise, always aside"]
)
def test_one_of_two_markers_is_not(off):
    assert not len(Dropped(off=off).given_back())


def test_the_part_of_it_that_is_one_marker_is():
    part = np.arange(24, 72)  # two blocks
    off = np.where(part < 48, 0.8, 0.0)
    assert (Dropped(part, off).given_back() == part[part >= 48]).all()


def test_too_few_points_are_not():
    assert not len(Dropped(PART[:3]).given_back())


def test_images_that_a_confirmed_track_has_are_not_given_back():
    dropped = Dropped()
    dropped.detection[[A, B], np.flatnonzero((dropped.id == 1) & (dropped.frame == PART[0]))] = dropped.pair[[A, B], 0]
    assert (dropped.given_back() == PART[1:]).all()


def test_images_that_tracks_share_are_not():
    dropped = Dropped()
    dropped.shared[A, :12] = True
    assert (dropped.given_back() == PART[12:]).all()


def test_confirmed_tracks_are_not_given_twice():
    assert not len(Dropped().given_back(confirmed=range(MARKERS)))


def test_where_nothing_is_usual_nothing_is_given_back():
    dropped = Dropped()
    assert not len(dropped.given_back(usual=UsualResiduals({}, fundamentals(dropped.images.P))))


def test_a_scene_whose_calibration_is_off_where_two_cameras_see():
    """Four cameras, a file 0.3 px off: 577 of the 1700 samples that two cameras see were dropped."""
    made = make(scene(131120))
    result = tally(made, track_detections(made.detections, made.rig))
    assert result.two_found >= 0.97 * result.two
    assert not result.ghosts
    assert not result.swaps
