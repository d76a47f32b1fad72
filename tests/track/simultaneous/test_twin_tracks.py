"""A marker of which cameras disagree, as they stand otherwise than their file says, has one track and not two."""

import numpy as np
import pytest

from kinemark.data import Cloud, Tracks
from kinemark.track.simultaneous import Simultaneous, track_detections
from kinemark.track.simultaneous.candidate_points import intersect
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.solved_points import Working
from kinemark.track.simultaneous.told_by_tracks import of_tracks, with_noise
from kinemark.track.simultaneous.twin_tracks import joined_twins
from support.laboratory import observe
from support.motions import dance
from support.row_of_cameras import row, turned

FRAMES = 60


@pytest.mark.parametrize(("n", "stated"), [(4, True), (4, False), (6, False)])
def test_cameras_in_a_row_whose_file_is_off_make_one_track_a_marker(n, stated):
    seen = observe(row(n), dance(n=12, frames=FRAMES), noise=0.1, cov=stated or False)[0]
    tracks = track_detections(seen, turned(row(n), 1e-3 * np.linspace(-1, 1, n) ** 2))
    assert len(tracks.cloud) <= 12 * FRAMES
    assert (tracks.cloud.detection >= 0).sum() > 0.98 * len(seen)


@pytest.mark.parametrize("n", [4, 6])
def test_points_put_right_a_row_of_which_no_two_lines_tell(n):
    """Lines agree as well by the file as by the right rig, images of three cameras twice as well by the right one."""
    M, N = 12, 12 * FRAMES
    seen, marker = observe(row(n), dance(n=M, frames=FRAMES), noise=0.2, cov=False)
    file = turned(row(n), 5e-4 * np.linspace(-1, 1, n) ** 2)
    images, noise = with_noise(read_images(seen, file), Simultaneous())
    detection = np.full((N, n), -1)
    detection[images.frame * M + marker, images.camera] = np.arange(len(marker))
    xyz, cov = intersect(images, detection.T).xyz.T, np.tile(np.eye(3), (N, 1, 1))
    cloud = Cloud(100.0, np.arange(0, N + 1, M), xyz, cov, np.zeros(N), detection)
    tracks = Tracks(cloud, np.tile(np.arange(M), FRAMES))
    working, better = of_tracks(seen, images, [Working(file, images, noise)], tracks, Simultaneous())
    assert better
    before, after = (intersect(by, detection.T).squared for by in (images, read_images(seen, working.rig)))
    assert np.median(after) < 0.5 * np.median(before)


def two_tracks(apart, images, frames=20):
    """Two tracks, apart by (3) mm, with images of these cameras (2, C) of a row of four; and all images (D, 2) px."""
    rig, at = row(4), np.array([[0.0, 0.0, 900.0], np.add([0.0, 0.0, 900.0], apart)])
    uv, own = np.zeros((0, 2)), np.full((2, 4), -1)
    for k, c in np.argwhere(images):
        q = rig.P[c] @ [*at[k], 1.0]
        own[k, c], uv = len(uv), np.vstack([uv, q[:2] / q[2]])
    rows = 2 * frames
    cloud = Cloud(
        100.0,
        np.arange(0, rows + 1, 2),
        np.tile(at, (frames, 1)),
        np.tile(np.eye(3), (rows, 1, 1)),
        np.zeros(rows),
        np.tile(own, (frames, 1)),
    )
    return Tracks(cloud, np.tile([0, 1], frames)), uv, rig.P


def variances(uv):
    """Variances (D) px² of images with a noise of 0.2 px."""
    return np.full(len(uv), 0.04)


SIDES = [[1, 1, 0, 0], [0, 0, 1, 1]]


def test_twins_are_joined():
    tracks, uv, P = two_tracks((10.0, 5.0, 0.0), SIDES)
    joined = joined_twins(tracks, uv, variances(uv), P)
    np.testing.assert_array_equal(joined, np.tile([[0], [1], [2], [3]], 20))


@pytest.mark.parametrize(
    ("apart", "images", "frames"),
    [
        ((10.0, 5.0, 0.0), [[1, 1, 1, 0], [0, 0, 1, 1]], 20),  # a camera sees both
        ((90.0, 5.0, 0.0), SIDES, 20),  # images too far beside
        ((10.0, 5.0, 0.0), SIDES, 5),  # for a moment
        ((10.0, 5.0, 12.0), SIDES, 20),  # lines do not meet: two sides of a thin plate
    ],
)
def test_two_markers_are_left_apart(apart, images, frames):
    tracks, uv, P = two_tracks(apart, images, frames)
    np.testing.assert_array_equal(joined_twins(tracks, uv, variances(uv), P), tracks.cloud.detection.T)
