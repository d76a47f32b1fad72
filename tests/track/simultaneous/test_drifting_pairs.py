"""Images of two markers in two cameras, told from one marker's by their residual over many frames."""

import numpy as np
import pytest

from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.candidate_points import fundamentals
from kinemark.track.simultaneous.ghosts.drifting_pairs import (
    MAX_FACTOR,
    _polynomials,
    blocks,
    drifting,
    usual_residuals,
    without_strangers,
)
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

NOISE, MARKERS, FRAMES, GATE = 0.1, 8, 120, 5.0
PAIR, PART = (0, 1), np.arange(40, 60)
TIME = np.linspace(-1, 1, len(PART))


class Recording:
    """Points of all markers in all of some cameras; in PART those of marker 0 in the cameras PAIR alone."""

    def __init__(self, cameras=4, seed=3, taken_for=5.0):
        rig = ring(cameras)
        detections, marker = observe(rig, dance(n=MARKERS, frames=FRAMES, seed=2), noise=NOISE, seed=seed)
        images = read_images(detections, rig)
        self.images = images.noisier(np.full(cameras, (taken_for * NOISE) ** 2))
        self.frame, self.id = np.tile(np.arange(FRAMES), MARKERS), np.repeat(np.arange(MARKERS), FRAMES)
        self.detection = np.full((cameras, MARKERS * FRAMES), -1)
        self.detection[images.camera, marker * FRAMES + images.frame] = np.arange(len(marker))
        self.whole = self.detection.copy()
        self.detection[2:, PART] = -1

    def off(self, rows, px, along=None):
        """The images of points (n) in the second camera of PAIR moved by px (n) across the lines of the first's, or
        along those of another camera's."""
        uv, (a, b) = self.images.uv.copy(), PAIR
        a = a if along is None else along
        line = np.column_stack([uv[self.whole[a, rows]], np.ones(len(rows))]) @ fundamentals(self.images.P)[a, b].T
        away = line[:, :2] / np.linalg.norm(line[:, :2], axis=1)[:, None]
        away = away if along is None else away[:, ::-1] * [-1, 1]
        uv[self.whole[b, rows]] += np.asarray(px)[:, None] * away
        self.images = self.images._replace(uv=uv)
        return self

    def found(self):
        usual = usual_residuals(self.frame, self.id, self.detection, self.images, GATE)
        return np.flatnonzero(drifting(self.frame, self.id, self.detection, self.images, usual, GATE))

    def without_strangers(self):
        usual = usual_residuals(self.frame, self.id, self.detection, self.images, GATE)
        return without_strangers(self.frame, self.id, self.detection, self.images, usual, GATE)


@pytest.mark.parametrize("px", [1.0 * TIME, 0.4 + 0 * TIME, 1.2 * TIME**2 - 0.4], ids=["drift", "aside", "bend"])
def test_images_that_drift_past_each_other_are_given_up(px):
    """No image is farther off than twice the noise that it is taken to have, so that each passes the gate."""
    found = Recording().off(PART, px).found()
    assert len(found) >= 0.8 * len(PART)
    assert set(found) <= set(PART)


def test_the_part_of_a_track_that_drifts_is_given_up():
    px = np.where(np.arange(len(PART)) < 8, 0.8, 0.0)
    found = Recording().off(PART, px).found()
    assert set(PART[:8]) - set(found) <= {PART[0], PART[7]}
    assert len(set(found) - set(PART[:8])) <= 1


@pytest.mark.parametrize(("share", "whole"), [(0.7, True), (0.3, False)])
def test_a_track_of_two_cameras_of_which_most_drifts_is_given_up(share, whole):
    recording = Recording()
    own = recording.id != 0
    own[PART] = True
    first = PART[: round(share * len(PART))]
    recording.off(first, np.full(len(first), 0.8))
    recording.frame, recording.id, recording.detection = (
        recording.frame[own],
        recording.id[own],
        recording.detection[:, own],
    )
    assert (len(recording.found()) == len(PART)) == whole


@pytest.mark.parametrize("seed", range(8))
def test_images_of_one_marker_stay(seed):
    assert not len(Recording(seed=seed).found())


def test_a_camera_that_is_always_off_tells_nothing():
    everyone = np.arange(MARKERS * FRAMES)
    assert not len(Recording().off(everyone, np.full(len(everyone), 0.5)).found())


def test_what_several_tracks_of_two_cameras_share_is_the_calibration():
    recording = Recording()
    rows = np.concatenate([PART + k * FRAMES for k in range(4)])
    recording.detection[2:, rows] = -1
    assert not len(recording.off(rows, np.full(len(rows), 0.8)).found())


def test_pieces_of_what_stands_in_one_place_tell_nothing_of_the_calibration():
    """Reflections that stand still meet by chance all the time, and their track breaks in three."""
    recording, rows, rng = Recording(), np.arange(FRAMES), np.random.default_rng(4)
    for own in recording.detection[:, rows]:
        recording.images.uv[own] = recording.images.uv[own[0]] + NOISE * rng.normal(size=(FRAMES, 2))
    recording.detection[2:, rows] = -1
    recording.id[rows] = MARKERS + rows // 40
    assert set(recording.off(rows, np.full(FRAMES, 0.8)).found()) == set(rows)


def test_where_sound_points_drift_as_well_nothing_is_judged():
    """As those of cameras that are not synchronous, in motion and at rest: a few of them drift much more than usual."""
    recording = Recording()
    wild = (recording.frame + 7 * recording.id) % 60 < 12
    rows = np.flatnonzero(wild & (recording.id > 0))
    recording.off(rows, 2.0 * np.sin(recording.frame[rows] / 4)).off(PART, 1.0 * TIME)
    assert not len(recording.found())
    assert MAX_FACTOR < 10


def test_sound_points_with_images_of_other_markers_do_not_keep_it_from_judging():
    """One of the seven other markers has an image in each camera, of which one is another marker's half of the time."""
    recording = Recording()
    rows = np.flatnonzero((recording.id == 1) & (recording.frame < FRAMES // 2))
    found = recording.off(rows, 0.02 * recording.frame[rows] + 0.8).off(PART, 1.0 * TIME).found()
    assert len(found) >= 0.8 * len(PART)
    assert set(found) <= set(PART)


def test_where_many_sound_points_drift_a_little_nothing_is_judged():
    """As where markers touch in the images: what runs together drifts as well, and is not to be given up."""
    recording = Recording()
    rows = np.flatnonzero(np.isin(recording.id, [1, 2]) & (recording.frame < 100))
    recording.off(rows, 0.008 * recording.frame[rows] + 0.3).off(PART, 1.0 * TIME)
    assert not len(recording.found())
    assert (recording.without_strangers() == recording.detection).all()


def test_where_many_sound_points_have_images_of_other_markers_drift_is_judged():
    """Theirs are anywhere within the gate of 2.5 px, as those of chance meetings, which crowded scenes have many of."""
    recording = Recording()
    rows = np.flatnonzero(np.isin(recording.id, [1, 2]) & (recording.frame < 100))
    recording.off(rows, 0.02 * recording.frame[rows] + 0.8)
    found = recording.off(PART, 1.0 * TIME).found()
    assert len(found) >= 0.8 * len(PART)
    assert set(found) <= set(PART)


def test_merged_images_say_nothing():
    recording = Recording().off(PART, 1.0 * TIME)
    merged = recording.images.merged.copy()
    merged[recording.detection[0, PART]] = True
    recording.images = recording.images._replace(merged=merged)
    assert not len(recording.found())


def test_two_cameras_are_judged_by_all_their_points():
    found = Recording(cameras=2).off(PART, 1.0 * TIME).found()
    assert len(found) >= 0.8 * len(PART)
    assert set(found) <= set(PART)


def test_two_cameras_with_which_no_third_looks_are_judged_by_all_their_points():
    """As those of four that look past each other, two to the left and two to the right."""
    recording = Recording()
    recording.detection[2:] = -1
    found = recording.off(PART, 1.0 * TIME).found()
    assert len(found) >= 0.8 * len(PART)
    assert set(found) <= set(PART)


@pytest.mark.parametrize("images", [3, 4])
def test_of_several_images_the_one_that_drifts_past_the_others_is_given_up(images):
    """Of three or four that fit one another within the gate; the others stay, and so do those of all other points."""
    recording = Recording().off(PART, 0.6 + 0.4 * TIME)
    recording.detection[:images, PART] = recording.whole[:images, PART]
    left = recording.without_strangers()
    gone = np.argwhere(left != recording.detection)
    assert set(gone[:, 0]) == {PAIR[1]}
    assert set(gone[:, 1]) <= set(PART)
    assert len(gone) >= 0.8 * len(PART)


def test_a_merged_image_does_not_tell_which_of_two_is_the_stranger():
    one = Recording().off(PART, 1.5 * TIME)
    one.detection[2, PART] = one.whole[2, PART]
    merged = one.images.merged.copy()
    merged[one.whole[2, PART]] = True
    one.images = one.images._replace(merged=merged)
    np.testing.assert_array_equal(one.without_strangers(), one.detection)


def test_a_merged_image_is_no_stranger_where_one_of_the_others_is():
    """The stranger drifts past one of the others, and along the lines of the other."""
    one = Recording().off(PART, 1.5 * TIME, along=2)
    one.detection[2:, PART] = one.whole[2:, PART]
    merged = one.images.merged.copy()
    merged[one.whole[3, PART]] = True
    one.images = one.images._replace(merged=merged)
    gone = np.flatnonzero((one.without_strangers() != one.detection).any(1))
    assert len(gone)
    assert set(gone) <= set(PAIR)


@pytest.mark.parametrize("seed", range(4))
def test_of_several_images_of_one_marker_all_stay(seed):
    recording = Recording(seed=seed)
    recording.detection[2, PART] = recording.whole[2, PART]
    assert (recording.without_strangers() == recording.detection).all()


def test_few_sound_points_say_nothing():
    recording = Recording().off(PART, 1.0 * TIME)
    few = recording.id == 0
    recording.frame, recording.id, recording.detection = (
        recording.frame[few],
        recording.id[few],
        recording.detection[:, few],
    )
    assert not len(recording.found())


def test_blocks_hold_each_row_once_and_break_where_tracks_and_frames_do():
    frame = np.concatenate([np.arange(70), np.arange(80, 90), np.arange(5)])
    id = np.repeat([0, 0, 1], [70, 10, 5])
    found = blocks(frame, id)
    assert sorted(np.concatenate([block.ravel() for block in found])) == list(range(len(frame)))
    for block in found:
        assert (np.diff(frame[block], axis=1) == 1).all()
        assert (id[block] == id[block[:, :1]]).all()
    assert sorted(block.shape[1] for block in found for _ in block) == [5, 10, 23, 23, 24]


@pytest.mark.parametrize("n", [1, 2, 3, 9, 24])
def test_polynomials_are_orthonormal(n):
    p = _polynomials(n)
    np.testing.assert_allclose(p.T @ p, np.eye(min(n, 4)), atol=1e-12)


def test_a_scene_in_which_images_of_two_markers_drift():
    """116 of its points were no marker's without this, and 6780 of 7022 samples of two cameras were found."""
    made = make(scene(4117))
    count = tally(made, track_detections(made.detections, made.rig))
    assert count.ghosts <= 80
    assert count.two_found >= 6780
