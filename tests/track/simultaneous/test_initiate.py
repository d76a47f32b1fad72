"""Tracks are initiated of what moves far faster than all else."""

import numpy as np
import pytest

from kinemark.track.simultaneous import track_detections
from support.laboratory import observe, ring
from support.motions import dance

RATE, HIT, FRAMES = 250.0, 60, 100


@pytest.mark.parametrize("speed", [10_000.0, 35_000.0])
def test_a_ball_that_is_struck_is_found(speed):
    """It is a few of the markers for a short time, so no window tells how fast it is."""
    after = np.maximum(np.arange(FRAMES) - HIT, 0)[:, None] / RATE
    ball = np.array([-1200.0, 300, 900]) + speed * after * np.array([0.9, -0.3, 0.3])
    xyz = np.concatenate([dance(n=15, frames=FRAMES), ball[None]])
    rig = ring(8)
    detections, marker = observe(rig, xyz, noise=0.2, seed=1, rate=RATE)
    tracks = track_detections(detections, rig)
    seen = np.bincount(detections.frame[marker == 15], minlength=FRAMES) >= 3
    off = np.linalg.norm(tracks.cloud.xyz - ball[tracks.cloud.frame], axis=1)
    found = np.isin(np.arange(FRAMES), tracks.cloud.frame[off < 10.0])
    wanted = seen & (np.arange(FRAMES) > HIT)
    assert (found & wanted).sum() >= 0.9 * wanted.sum()
