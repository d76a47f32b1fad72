"""A camera that has every second image, or is looked at in frames of a period, fits as well as the others."""

import numpy as np

from kinemark.data import Detections, Rig
from kinemark.geometry import project_all
from kinemark.numerics.evenly import scattered
from kinemark.track.simultaneous import Simultaneous, track_simultaneously
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.noise.measurement_noise import sampled_frames
from kinemark.track.simultaneous.rig.unfitting_stretches import unfitting_stretches
from support.plain_ring import ring


def test_scattered_places_are_one_in_each_part_and_of_no_period() -> None:
    for n, most in ((224, 56), (120, 60), (1000, 100), (50, 50), (3, 7), (1, 1), (0, 5)):
        places = scattered(n, most)
        assert len(places) == min(n, most)
        assert (places * len(places) // max(n, 1) == np.arange(len(places))).all()
    for period in (2, 3, 4, 5):
        met = np.bincount(scattered(1000, 1000 // period) % period, minlength=period)
        assert met.min() > 0.8 * met.mean()


def with_every_second(markers: int, frames: int, first: int) -> tuple[Detections, Rig]:
    """Eight cameras round markers that sway together, one of which has images of each second frame from `first` on."""
    rng, rig = np.random.default_rng(1), ring(8)
    t = np.arange(frames)[:, None] / 200
    sway = np.stack([400 * np.sin(3 * t), 400 * np.cos(3 * t), 50 * np.sin(9 * t)], -1)
    uv = project_all(rig, rng.uniform([-400, -400, 200], [400, 400, 1600], (markers, 3)) + sway)
    counts = np.full((8, frames), markers)
    counts[3, 1 - first :: 2] = 0
    rows = np.concatenate([uv[c, f] for c, f in np.ndindex(8, frames) if counts[c, f]])
    return Detections.build(rig.names, 200.0, counts, rows + rng.normal(0, 0.2, rows.shape)), rig


def test_a_camera_with_every_second_image_is_not_left_out() -> None:
    frames = 224
    detections, rig = with_every_second(13, frames, 0)
    met = np.isin(sampled_frames(read_images(detections, rig)), np.arange(0, frames, 2)).mean()
    assert 0.3 < met < 0.7
    result = track_simultaneously(detections, rig, Simultaneous())
    assert not len(result.noise.inconsistent)
    assert not result.unfitting
    assert ((result.tracks.cloud.detection >= 0).sum(0) > 0.95 * detections.counts.sum(1)).all()


def test_a_camera_with_images_of_odd_frames_alone_fits_in_all_parts() -> None:
    """Every fourth frame of each part is looked at, which all were even."""
    assert unfitting_stretches(*with_every_second(16, 400, 1)) == ()
