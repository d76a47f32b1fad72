"""Images of a camera of a row that lie beside the points of the others are theirs, before the rig is adjusted."""

import numpy as np
import pytest

from kinemark.data import Cloud, Detections, Tracks
from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.rig.images_beside import with_images_beside
from support.laboratory import observe
from support.motions import dance
from support.row_of_cameras import row, turned

FRAMES = 60


@pytest.mark.parametrize(
    ("angles", "noise", "seed"),
    [
        ([0.2, -0.2, 0.8], 0.1, 0),  # 17 % of all images, and 3 % of the first camera's, were in points
        ([-1.0, 0.3, -2.0, 0.8], 0.2, 9),  # 75 %, and none of the third's
    ],
)
def test_a_row_whose_file_is_off_uses_the_images_of_all_its_cameras(angles, noise, seed):
    true = row(len(angles))
    seen = observe(true, dance(n=12, frames=FRAMES, seed=seed), noise=noise, cov=False, seed=seed)[0]
    tracks = track_detections(seen, turned(true, 1e-3 * np.array(angles)))
    assert ((tracks.cloud.detection >= 0).sum(0) > 0.97 * seen.counts.sum(1)).all()


def point_and_image(beside, frames=20, taken=False):
    """A track of three cameras of a row of four, and an image of the fourth beside it by so many px, which is another
    track's; and the images."""
    rig, at = row(4), np.array([0.0, 0.0, 900.0])
    q = rig.P @ [*at, 1.0]
    uv = q[:, :2] / q[:, 2:] + np.outer([0, 0, 0, 1], beside)
    detections = Detections.build(
        rig.names,
        100.0,
        np.ones((4, frames), int),
        np.repeat(uv, frames, 0),
        np.broadcast_to(0.04 * np.eye(2), (4 * frames, 2, 2)),
    )
    own = np.arange(4)[:, None] * frames + np.arange(frames)
    detection = np.stack([np.where([[1], [1], [1], [0]], own, -1), np.where([[0], [0], [0], [1]], own, -1)], -1)
    detection = detection[..., : 1 + taken].reshape(4, -1).T
    n = len(detection)
    start = np.arange(0, n + 1, 1 + taken)
    cloud = Cloud(100.0, start, np.tile(at, (n, 1)), np.tile(np.eye(3), (n, 1, 1)), np.zeros(n), detection)
    return Tracks(cloud, np.tile(np.arange(1 + taken), frames)), read_images(detections, rig)


def test_an_image_on_all_lines_is_the_points():
    tracks, images = point_and_image((6.0, 0.0))
    whole = with_images_beside(tracks, images)
    np.testing.assert_array_equal(whole.cloud.detection[:, 3], 60 + np.arange(20))
    np.testing.assert_array_equal(whole.cloud.detection[:, :3], tracks.cloud.detection[:, :3])


@pytest.mark.parametrize(
    ("beside", "taken"),
    [
        ((0.0, 6.0), False),  # not on the lines
        ((12.0, 0.0), False),  # too far beside
        ((6.0, 0.0), True),  # another track's
    ],
)
def test_an_image_of_another_marker_is_left(beside, taken):
    tracks, images = point_and_image(beside, taken=taken)
    assert with_images_beside(tracks, images) is tracks


def test_few_images_are_left():
    tracks, images = point_and_image((6.0, 0.0), frames=40)
    few = images.only((images.camera < 3) | (images.frame < 2))
    assert with_images_beside(tracks, few) is tracks
