"""Images of one camera that run together, in files that do not mark them."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Camera, Detections, Rig
from kinemark.track.simultaneous import track_simultaneously, track_with_decisions
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.ghosts import unmarked_merging
from kinemark.track.simultaneous.ghosts.merging_in_images import MOST, merged_in_images
from kinemark.track.simultaneous.ghosts.unmarked_merging import with_merging_in_images
from kinemark.track.simultaneous.simultaneous_method import DEFAULT
from support.scenes import make, scene, tally

K = np.array([[1000.0, 0, 500], [0, 1000, 400], [0, 0, 1]])
RIG = Rig((Camera("c", np.array([1000, 800]), K, np.eye(3), np.zeros(3), np.zeros(5)),))
R = 8.0


def passing(frames, together, *, only=None):
    """Two images that pass each other, 3 px a frame: one in the middle while nearer than R; or the first alone."""
    rows, truth = [], []
    for f in range(frames):
        x = 3.0 * (f - frames / 2 + 0.5)
        both = np.array([[500 + x, 400.0], [500 - x, 402.0]])
        near = abs(2 * x) < R
        rows.append(both[:1] if near and only else both.mean(0, keepdims=True) if near and together else both)
        truth += [near and together] * len(rows[-1])
    counts = np.array([[len(part) for part in rows]])
    return Detections.build(("c",), 100.0, counts, np.vstack(rows)), np.array(truth)


def test_images_that_run_together_and_apart_are_merged_ones():
    detections, truth = passing(20, together=True)
    found = merged_in_images(read_images(detections, RIG), R)
    np.testing.assert_array_equal(found, truth)
    assert truth.sum() == 2


@pytest.mark.parametrize("only", [True, False])
def test_an_image_that_is_hidden_or_passes_is_no_merged_one(only):
    detections, _ = passing(20, together=False, only=only)
    assert not merged_in_images(read_images(detections, RIG), R).any()


def side_by_side(frames, begin, vanish):
    """Two images that come to 6 px of each other and go on so, one in the middle from frame `begin` on; from `vanish`
    on one of the two alone. And which images are of both."""
    apart = np.maximum(6.0, 6.0 + 2.0 * (begin + 0.5 - np.arange(frames)))
    along = np.stack([300.0 + 4.0 * np.arange(frames), np.full(frames, 400.0)], 1)
    both = along[:, None] + np.multiply.outer(apart / 2, [[0, 1.0], [0, -1.0]])
    rows = [*both[:begin], *both[begin:vanish].mean(1, keepdims=True), *both[vanish:, :1]]
    counts = np.array([[len(part) for part in rows]])
    truth = np.repeat((np.arange(frames) >= begin) & (np.arange(frames) < vanish), counts[0])
    return Detections.build(("c",), 100.0, counts, np.vstack(rows)), truth


def test_images_are_merged_until_one_of_both_vanishes():
    detections, truth = side_by_side(60, 10, 14)
    found = merged_in_images(read_images(detections, RIG), R)
    np.testing.assert_array_equal(found, truth)


@pytest.mark.parametrize("noise", [0.0, 0.4])
def test_where_none_vanishes_only_the_next_images_count(noise):
    detections, truth = side_by_side(60, 10, 60)
    uv = detections.uv + np.random.default_rng(1).normal(0, noise, detections.uv.shape)
    found = merged_in_images(read_images(replace(detections, uv=uv), RIG), R)
    np.testing.assert_array_equal(np.flatnonzero(found), np.flatnonzero(truth)[:MOST])


def test_time_backwards_and_shifted_images_tell_the_same():
    detections, truth = passing(21, together=True)
    flipped = detections.frame.max() - detections.frame
    order = np.lexsort([np.arange(len(truth)), flipped])
    back = Detections.build(("c",), 100.0, detections.counts[:, ::-1], detections.uv[order] + [100.0, -50.0])
    found = merged_in_images(read_images(back, RIG), R)
    np.testing.assert_array_equal(found, truth[order])


def test_files_that_mark_merged_images_are_believed():
    detections, truth = passing(20, together=True)
    images = read_images(detections, RIG)
    marked = images._replace(merged=np.arange(len(truth)) == 0)
    assert with_merging_in_images(marked) is marked


@pytest.mark.parametrize(("n", "tells"), [(2, False), (3, True), (4, True), (5, False)])
def test_three_and_four_cameras_are_told_by_one_of_them(n, tells, monkeypatch):
    monkeypatch.setattr(unmarked_merging, "resolution", lambda images: R)
    one, truth = passing(20, together=True)
    names = tuple("abcde"[:n])
    many = Detections.build(names, 100.0, np.tile(one.counts, (n, 1)), np.tile(one.uv, (n, 1)))
    images = read_images(many, Rig(tuple(replace(RIG.cameras[0], name=name) for name in names)))
    found = with_merging_in_images(images)
    np.testing.assert_array_equal(found.merged, np.tile(truth & tells, n))
    np.testing.assert_allclose(found.variance - images.variance, np.where(found.merged, (R / 4) ** 2, 0.0))


def test_merged_images_of_markers_without_a_track_make_fewer_ghosts():
    whole = scene(147050)
    one = make(whole._replace(seconds=100 / whole.rate))
    counts = tally(one, track_simultaneously(one.detections, one.rig, DEFAULT).tracks)
    assert counts.ghosts <= 6  # 15 else
    assert counts.two_found > 0.97 * counts.two and counts.more_found == counts.more


def test_points_of_images_that_one_camera_shows_to_be_of_two_markers_are_listed():
    """Two cameras, and more than four, do not believe it: the operator is told (0.68 of these points without it)."""
    made = make(scene(9346))
    tracks, decisions = track_with_decisions(made.detections, made.rig)
    markers = np.bincount(made.image[made.image >= 0], minlength=len(made.detections.uv))
    detection, frame = tracks.cloud.detection, tracks.cloud.frame
    few = ((detection >= 0) & (markers[detection] == 1)).sum(1) < 2
    told = np.zeros(len(frame), bool)
    for one in decisions:
        own = np.isin(tracks.id, one.tracks) & (frame >= one.first) & (frame <= one.last)
        told |= own & (one.kind == "merge")
    assert (few & told).sum() > 0.9 * few.sum() > 100
    assert (told & ~few).sum() < 0.1 * told.sum()
