"""Recordings that were started at different times are put together by what their markers show."""

import numpy as np
import pytest

from kinemark.data import Detections, KinemarkError
from kinemark.match import start_offsets
from kinemark.synth import observe, ring, stationary, walking


def shifted(detections, late, frames):
    """Detections of which camera c was started late[c] frames after the first of all, of so many frames."""
    uv, counts = [], []
    for c, first in enumerate(late):
        rows = [detections[c, f] for f in range(first, first + frames)]
        uv += rows
        counts.append([len(row) for row in rows])
    return Detections.build(detections.cameras, detections.rate, counts, np.concatenate(uv))


@pytest.mark.parametrize(
    ("late", "cameras", "noise", "seed"),
    [((30, 0, 55, 12), 4, 0.3, 0), ((0, 70, 3, 0, 41, 20), 6, 0.1, 1), ((18, 60), 2, 0.2, 2), ((5, 5, 5), 3, 0.2, 3)],
)
def test_starts_are_found_to_the_image(late, cameras, noise, seed):
    rig = ring(cameras, distortion=(-0.1, 0, 0, 0, 0), sweep_deg=360.0 if cameras > 2 else 70.0)
    seen = observe(rig, walking(duration_s=3.0, seed=seed), noise_px=noise, false_per_frame=0.5, dropout=0.1, seed=seed)
    found = start_offsets(shifted(seen.detections, late, 75), rig, most=80)
    assert found.images.tolist() == [first - late[0] for first in late]
    assert len(found.disagreeing) <= 1 and (found.clearness[1:] >= 1.4).all()


def test_what_does_not_move_tells_nothing():
    rig = ring(3)
    still = stationary(("a", "b", "c"), np.array([[1000.0, 600, 800], [1300, 900, 500], [900, 500, 1200]]), radius_mm=7)
    frames = [observe(rig, still, noise_px=0.2, seed=k).detections for k in range(40)]
    uv = np.concatenate([one[c, 0] for c in range(3) for one in frames])
    counts = [[len(one[c, 0]) for one in frames] for c in range(3)]
    with pytest.raises(KinemarkError, match="must move"):
        start_offsets(Detections.build(rig.names, 50.0, counts, uv), rig, most=20)


def test_a_start_farther_off_than_asked_for_is_refused():
    rig = ring(3)
    seen = observe(rig, walking(duration_s=3.0), noise_px=0.2).detections
    with pytest.raises(KinemarkError, match="cam2"):
        start_offsets(shifted(seen, (0, 60, 0), 80), rig, most=20)
