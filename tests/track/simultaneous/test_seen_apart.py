"""Whether a camera tells that two tracks are two markers."""

import numpy as np
import pytest

from kinemark.track.simultaneous.neighbouring_points import TrackPoints
from kinemark.track.simultaneous.seen_apart import FRAMES, SeenApart

N, RADIUS = 20, 4.0  # frames, px
FOCAL, DEPTH = 1000.0, 4000.0  # px, mm
P = np.array([[[FOCAL, 0, x, 0], [0, FOCAL, 0, 0], [0, 0, 1, DEPTH]] for x in (0.0, 50.0)])
MM = DEPTH / FOCAL  # across, of a px


def apart(aside, *, both=0):
    """What is said of two tracks `aside` (n) mm from each other, of which camera 0 shows the first and camera 1 the
    second, and camera 0 both of them in so many frames."""
    aside = np.broadcast_to(aside, N)
    frame, id = np.tile(np.arange(N), 2), np.repeat([0, 1], N)
    xyz = np.zeros((2 * N, 3))
    xyz[N:, 0] = aside
    detection = np.full((2, 2 * N), -1)
    detection[0, :N], detection[1, N:] = np.arange(N), N + np.arange(N)
    detection[0, N : N + both] = 2 * N + np.arange(both)
    mixed = np.random.default_rng(1).permutation(2 * N)
    points = TrackPoints(frame[mixed], id[mixed], xyz[mixed], np.broadcast_to(np.eye(3), (2 * N, 3, 3)))
    asked = SeenApart(points, detection[:, mixed], P, RADIUS)
    return asked(np.array([0, 1]), np.array([1, 0])).tolist()


@pytest.mark.parametrize(("px", "said"), [(0.9 * RADIUS, False), (1.1 * RADIUS, True)])
def test_two_tracks_farther_from_each_other_than_images_that_are_one_are_apart(px, said):
    """One marker would have two images in a camera then, though neither camera has an image of each."""
    assert apart(px * MM) == [said, said]


@pytest.mark.parametrize(("share", "said"), [(0.3, False), (0.7, True)])
def test_the_distance_counts_in_half_of_the_frames(share, said):
    far = np.where(np.arange(N) < share * N, 3 * RADIUS * MM, 0.0)
    assert apart(far) == [said, said]


@pytest.mark.parametrize(("both", "said"), [(FRAMES - 1, False), (FRAMES, True)])
def test_a_camera_with_an_image_of_each_tells_in_several_frames(both, said):
    assert apart(1.0, both=both) == [said, said]


def test_the_camera_that_shows_the_distance_best_tells():
    """Both cameras see the distance across; along the line of sight of both none of it is seen."""
    frame, id = np.tile(np.arange(N), 2), np.repeat([0, 1], N)
    side = np.array([[[0, 0, FOCAL, 0], [0, FOCAL, 0, 0], [1, 0, 0, DEPTH]]])
    xyz = np.zeros((2 * N, 3))
    xyz[N:, 2] = 3 * RADIUS * MM
    points = TrackPoints(frame, id, xyz, np.broadcast_to(np.eye(3), (2 * N, 3, 3)))
    nothing = np.full((3, 2 * N), -1)
    pair = np.array([0]), np.array([1])
    assert not SeenApart(points, nothing[:2], P, RADIUS)(*pair)[0]
    assert SeenApart(points, nothing, np.concatenate([P, side]), RADIUS)(*pair)[0]


def test_tracks_that_are_never_there_at_once_are_not_told_apart():
    frame, id = np.arange(2 * N), np.repeat([0, 1], N)
    points = TrackPoints(frame, id, np.zeros((2 * N, 3)), np.broadcast_to(np.eye(3), (2 * N, 3, 3)))
    assert not SeenApart(points, np.full((2, 2 * N), -1), P, RADIUS)(np.array([0]), np.array([1]))[0]
