"""A marker of which cameras disagree, as they stand otherwise than their file says, has one track and not two."""

import numpy as np
import pytest

from kinemark.data import Cloud, Tracks
from kinemark.track.simultaneous import Simultaneous, track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.candidate_points import intersect
from kinemark.track.simultaneous.points.solved_points import Working
from kinemark.track.simultaneous.rig.told_by_tracks import of_tracks, with_noise
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
