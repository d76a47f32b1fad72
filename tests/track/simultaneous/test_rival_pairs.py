"""Rival pairs: stretches of two images that something else explains better."""

import numpy as np
import pytest

from kinemark.track.simultaneous import Simultaneous, track_with_decisions
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.candidate_points import fundamentals, intersect
from kinemark.track.simultaneous.following.passes import Associations
from kinemark.track.simultaneous.ghosts.rival_pairs import stretches, without_rivalled
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

RATE, METHOD, FRAMES = 100.0, Simultaneous(), 40
STRETCH = slice(10, 30)


def made(*, wrong=1, by=0.4, hidden=(3,)):
    """Images of one marker, and a track of all of them, but in frames STRETCH of cameras 0 and 1 only.

    There those of the others are free, but for `hidden` cameras, and that of camera `wrong` is `by` px off the line of
    camera 0's.
    """
    rig = ring(4)
    detections, marker = observe(rig, dance(n=1, frames=FRAMES, seed=2), noise=0.05, seed=3)
    images = read_images(detections, rig)
    detection = np.full((4, FRAMES), -1)
    detection[images.camera, images.frame] = np.arange(len(marker))
    assert (detection >= 0).all()
    uv, usable = images.uv.copy(), images.usable.copy()
    line = uv[detection[0, STRETCH]] @ fundamentals(images.P)[0, wrong][:2, :2].T
    line += fundamentals(images.P)[0, wrong][:2, 2]
    uv[detection[wrong, STRETCH]] += by * line / np.linalg.norm(line, axis=1)[:, None]
    usable[detection[list(hidden), STRETCH]] = False
    images = images._replace(uv=uv, usable=usable, by_cell=images.by_cell.keep(usable))
    held = detection.copy()
    held[2:, STRETCH] = -1
    point, none = intersect(images, held), np.zeros(held.shape, bool)
    zero = np.zeros(FRAMES)
    track = Associations(np.arange(FRAMES), np.zeros(FRAMES, int), held, none, zero, zero, point.xyz, point.cov)
    return images, track, detection


def judged(images, track):
    return without_rivalled(list(track), images, fundamentals(images.P), 1 / RATE, METHOD)


def test_a_stretch_is_given_up_for_a_rival_that_fits_better():
    images, track, detection = made()
    found = judged(images, track)
    after = found.associations
    assert set(after.id) == {0, 1}
    new = after.take(after.id == 1)
    np.testing.assert_array_equal(new.frame, np.arange(FRAMES)[STRETCH])
    np.testing.assert_array_equal(new.detection[[0, 2]], detection[[0, 2], STRETCH])
    assert (new.detection[[1, 3]] == -1).all()
    np.testing.assert_allclose(new.xyz, intersect(images, new.detection).xyz)
    assert not np.isin(after.frame[after.id == 0], new.frame).any()


def test_a_merged_image_makes_no_third_of_a_stretch():
    """It fits the wrong pair as well as the true one."""
    images, track, detection = made()
    merged, held = images.merged.copy(), track.detection.copy()
    merged[detection[3, STRETCH]], held[3, STRETCH] = True, detection[3, STRETCH]
    after = judged(images._replace(merged=merged), track._replace(detection=held)).associations
    np.testing.assert_array_equal(after.detection[[0, 2]][:, after.id == 1], detection[[0, 2], STRETCH])
    assert not np.isin(np.arange(FRAMES)[STRETCH], after.frame[after.id == 0]).any()


def test_what_comes_after_a_stretch_that_is_given_up_is_a_piece_of_the_same_track():
    found = judged(*made()[:2])
    after = found.associations
    piece = found.pieces(after.id, after.frame)
    assert (piece[(after.id == 0) & (after.frame < STRETCH.start)] == 0).all()
    assert (piece[(after.id == 0) & (after.frame >= STRETCH.stop)] == 2).all()
    np.testing.assert_array_equal(piece[after.id == 1], 1)
    np.testing.assert_array_equal(found.whole(), [0, 1, 0])


@pytest.mark.parametrize("by", [0.4, 40.0])
def test_a_rival_that_fits_worse_changes_nothing(by):
    images, track, _ = made(wrong=2, by=by)
    found = judged(images, track)
    np.testing.assert_array_equal(found.associations.detection, track.detection)
    np.testing.assert_array_equal(found.pieces(track.id, track.frame), track.id)
    np.testing.assert_array_equal(found.whole(), [0])


def test_an_image_goes_into_one_rival_alone():
    images, track, _ = made(hidden=())
    after = judged(images, track).associations
    held = after.detection[after.detection >= 0]
    assert len(np.unique(held)) == len(held)


def test_images_of_other_tracks_are_no_rivals():
    images, track, detection = made()
    other = np.full((4, FRAMES), -1)
    other[2:, STRETCH] = detection[2:, STRETCH]
    other = track._replace(id=track.id + 1, detection=other)
    both = Associations(*(np.concatenate(columns, -1) for columns in zip(track, other, strict=True)))
    np.testing.assert_array_equal(judged(images, both).associations.detection, both.detection)


def test_a_stretch_is_of_one_track_and_of_the_same_two_cameras():
    _, track, detection = made()
    np.testing.assert_array_equal(
        stretches(track.frame, track.id, track.detection) >= 0, np.isin(np.arange(FRAMES), np.arange(FRAMES)[STRETCH])
    )
    changed = track.detection.copy()
    changed[1, 20:30], changed[2, 20:30] = -1, detection[2, 20:30]
    number = stretches(track.frame, track.id, changed)
    assert len(set(number[10:20])) == len(set(number[20:30])) == 1
    assert number[19] != number[20]
    assert (stretches(2 * track.frame, track.id, track.detection) == -1).all()


def test_a_rival_whose_images_have_less_noise_is_no_likelier():
    """Of one of eight markers, whose images tell what is usual: by (2) it is given up."""
    rig, markers, frames, part = ring(4), 8, 120, np.arange(50, 70)
    detections, marker = observe(rig, dance(n=markers, frames=frames, seed=2), noise=0.1, seed=3)
    images = read_images(detections, rig)
    detection = np.full((4, markers, frames), -1)
    detection[images.camera, marker, images.frame] = np.arange(len(marker))
    uv, usable = images.uv.copy(), images.usable.copy()
    one, other = detection[[0, 2], 0][:, part]
    line = np.column_stack([uv[one], np.ones(len(one))]) @ fundamentals(images.P)[0, 2].T
    off = np.einsum("ni,ni->n", line, np.column_stack([uv[other], np.ones(len(other))]))
    uv[other] -= (off / (line[:, :2] ** 2).sum(1))[:, None] * line[:, :2]
    usable[detection[3, 0, part]] = False
    images = images._replace(uv=uv, usable=usable, by_cell=images.by_cell.keep(usable))
    detection[2:, 0, part] = -1
    held = detection.reshape(4, -1)
    point, none = intersect(images, held), np.zeros(held.shape, bool)
    frame, id, zero = (
        np.tile(np.arange(frames), markers),
        np.repeat(np.arange(markers), frames),
        np.zeros(held.shape[1]),
    )
    track = Associations(frame, id, held, none, zero, zero, point.xyz, point.cov)
    np.testing.assert_array_equal(judged(images, track).associations.detection, held)


@pytest.mark.parametrize(("seed", "before", "most"), [(24, 24, 4), (37, 19, 2)])
def test_pairs_of_two_markers_give_way_to_true_ones(seed, before, most):
    """Scenes of four and of two cameras, in which tracks took images of two markers for one in `before` points."""
    scenery = make(scene(seed))
    found = tally(scenery, *track_with_decisions(scenery.detections, scenery.rig))
    assert found.ghosts <= most < before
    assert found.two_found >= 0.975 * found.two
