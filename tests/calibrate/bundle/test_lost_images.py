"""Laws of images that a camera lost: which camera, when and how many, and that a film in time stays as it is."""

import numpy as np
import pytest

from kinemark.calibrate.bundle.lost_images import changes, images_ahead, in_place
from kinemark.data import Detections
from kinemark.geometry import project_all
from kinemark.synth import ring, wand

FRAMES, RATE = 160, 50
IN_TIME = np.arange(FRAMES)


def film(cameras, shown, *, seed=0, noise=0.2):
    """A ring, and ends (C, F, 2, 2) px of a wand of which camera c shows the moments `shown[c]`, in any order."""
    rig = ring(cameras, distortion=(-0.15, 0.0, 0.0, 0.0, 0.0))
    xyz = wand((0.0, 500.0), duration_s=(FRAMES + 20) / RATE, rate=RATE, seed=seed, volume=rig.volume).xyz
    uv = np.stack([project_all(rig, xyz[:, shown.get(c, IN_TIME)].reshape(-1, 3))[c] for c in range(cameras)])
    rng = np.random.default_rng(seed)
    uv = uv.reshape(cameras, 2, FRAMES, 2).transpose(0, 2, 1, 3) + rng.normal(0, noise, (cameras, FRAMES, 2, 2))
    return rig, np.where(rng.random((cameras, FRAMES))[..., None, None] < 0.5, uv, uv[:, :, ::-1])


def told(rig, uv, late=None):
    ahead = images_ahead(rig, uv, np.zeros(len(rig)) if late is None else late)
    return [] if ahead is None else list(changes(rig.names, ahead, np.isfinite(uv).all((2, 3))))


@pytest.mark.parametrize("images", [1, 2, -1, -3, 7])
@pytest.mark.parametrize("cameras", [3, 5])
def test_the_camera_the_frame_and_the_number_are_told(cameras, images):
    rig, uv = film(cameras, {1: IN_TIME + images * (IN_TIME >= 70)}, seed=cameras)
    (one,) = told(rig, uv)
    assert (one.camera, one.images, one.alone) == (rig.names[1], images, True)
    assert one.first - 2 <= 70 <= one.last + max(2, images)  # nothing says where among those that it lost


def test_of_two_cameras_it_may_be_either():
    rig, uv = film(2, {1: IN_TIME + (IN_TIME >= 70)})
    (one,) = told(rig, uv)
    assert (abs(one.images), one.alone) == (1, False)


def test_images_lost_at_two_moments_by_two_cameras_are_told():
    rig, uv = film(5, {0: IN_TIME + (IN_TIME >= 40), 3: IN_TIME + 2 * (IN_TIME >= 110)}, seed=2)
    assert [(one.camera, one.images) for one in told(rig, uv)] == [(rig.names[0], 1), (rig.names[3], 2)]


def test_a_film_in_time_and_one_of_a_late_camera_lack_nothing():
    for seed in range(3):
        rig, uv = film(4, {}, seed=seed)
        assert told(rig, uv) == []
        rig, uv = film(4, {2: IN_TIME + 12}, seed=seed)
        assert told(rig, uv, late=np.array([0.0, 0.0, 12.2, 0.0])) == []


def test_where_a_camera_sees_nothing_the_frames_between_are_told():
    rig, uv = film(4, {1: IN_TIME + (IN_TIME >= 70)})
    uv[1, 60:90] = np.nan
    (one,) = told(rig, uv)
    assert (one.first, one.last) == (60, 90)


def test_images_are_put_in_the_frames_that_they_show():
    seen = Detections.build(("a", "b"), 50.0, np.ones((2, 12), int), np.arange(24.0)[:, None] * [1.0, 1.0])
    ahead = np.zeros((2, 12), np.int64)
    ahead[1, 5:] = 1
    placed = in_place(seen, ahead)
    assert [placed[0, f][0, 0] for f in range(12)] == list(range(12))
    assert [len(placed[1, f]) for f in range(12)] == [1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1, 1]
    assert placed[1, 7][0, 0] == 12 + 6
