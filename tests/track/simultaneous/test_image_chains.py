"""Where images go on in their own camera, beyond the frames in which a track has them."""

import numpy as np
import pytest

from kinemark.data import Detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.ghosts.image_chains import alone, images_beyond
from support.laboratory import ring

FRAMES, MOST, RIG = 12, 4, ring(2)
TIME = np.arange(FRAMES)
PATH = np.stack([300 + 3.0 * TIME, 200 + 2.0 * TIME], 1)


def images_of(*paths, merged=()):
    """The images of paths (F, 2) px in the first of two cameras, and their rows (n, F); NaN where there is none."""
    uv = np.stack(paths, 1)
    seen, marks = np.isfinite(uv[..., 0]), np.zeros((FRAMES, len(paths)), bool)
    for frame, path in merged:
        marks[frame, path] = True
    counts = np.stack([seen.sum(1), np.zeros(FRAMES, int)])
    detections = Detections.build(RIG.names, 100.0, counts, uv[seen], merged=marks[seen])
    row = np.full(seen.shape, -1)
    row[seen] = np.arange(seen.sum())
    return read_images(detections, RIG), row.T


def beyond(images, last, step=1, radius=2.0, r=0.0):
    return images_beyond(images, np.array([last]), step, np.array([radius]), r, MOST)[0].tolist()


def test_images_go_on_until_the_recording_ends_forwards_and_backwards():
    images, (row,) = images_of(PATH)
    assert beyond(images, row[5:8]) == row[8:12].tolist()
    assert beyond(images, row[7:10]) == [*row[10:12].tolist(), -1, -1]
    assert beyond(images, row[3:6][::-1], step=-1) == [*row[[2, 1, 0]].tolist(), -1]


@pytest.mark.parametrize(("aside", "ends"), [(1.9, False), (2.1, True)])
def test_they_end_where_none_is_near_the_place_where_one_is_expected(aside, ends):
    path = PATH.copy()
    path[9:] += [0.0, aside]
    images, (row,) = images_of(path)
    assert (beyond(images, row[5:8])[1] == -1) == ends


def test_they_end_where_two_are_near_it():
    other = np.full((FRAMES, 2), np.nan)
    other[9] = PATH[9] + [1.0, 1.0]
    images, (row, _) = images_of(PATH, other)
    assert beyond(images, row[5:8]) == [row[8], -1, -1, -1]


def test_they_end_where_another_marker_takes_the_place_of_one_that_is_hidden():
    hidden, passing = PATH.copy(), PATH[9] + (TIME - 9)[:, None] * [-1.0, 1.0]
    hidden[9:], passing[10:] = np.nan, np.nan
    images, (row, _) = images_of(hidden, passing)
    assert beyond(images, row[5:8]) == [row[8], -1, -1, -1]


def test_they_end_where_two_merge_in_a_file_that_does_not_say_so():
    """The other one comes by, and both have their image in the middle from then on."""
    path, other = PATH.copy(), PATH + np.array([0.0, 8.0])
    path[9:], other[9:] = path[9:] + np.array([0.0, 1.5]), np.nan
    images, (row, _) = images_of(path, other)
    assert beyond(images, row[5:8], r=0.0)[1] == row[9]
    assert beyond(images, row[5:8], r=6.0)[1] == -1


def test_they_end_where_a_file_says_that_two_merge():
    images, (row,) = images_of(PATH, merged=[(9, 0)])
    assert beyond(images, row[5:8]) == [row[8], -1, -1, -1]


def test_an_image_is_alone_where_no_other_of_the_frame_before_is_nearer_or_within_the_resolution():
    images, (row, other) = images_of(PATH, PATH + np.array([0.0, 9.0]))
    found, before = row[[5]], row[[4]]
    assert alone(images, found, before, 0.0).all()
    assert alone(images, found, before, 7.0).all()
    assert not alone(images, found, before, 12.0).any()
    assert not alone(images, found, other[[4]], 0.0).any()
