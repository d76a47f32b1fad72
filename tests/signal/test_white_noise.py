"""The noise of a path is found whatever its movement."""

import numpy as np
import pytest

from kinemark.signal.white_noise import white_noise_sd
from support.scenes.bodies import walker

SECONDS = {25: 80, 50: 40, 100: 20, 250: 10}


def body(kind, rate):
    """(M, F, 3) mm of 12 markers, one a segment."""
    t = np.arange(SECONDS[rate] * rate) / rate
    return walker(kind, 12, t, np.random.default_rng(1), treadmill=True).xyz


@pytest.mark.parametrize("rate", [25, 50, 100, 250])
@pytest.mark.parametrize("kind", ["arms", "walk", "run"])
@pytest.mark.parametrize("sd", [0.1, 1.0])
def test_movement_adds_nothing_to_the_noise(kind, rate, sd):
    xyz = body(kind, rate)
    noisy = xyz + sd * np.random.default_rng(2).normal(size=xyz.shape)
    found = [white_noise_sd(path) for path in noisy]
    assert np.median(found) == pytest.approx(sd, rel=0.05)
    assert max(white_noise_sd(path) for path in xyz) < (0.1 if rate == 25 else 0.005)  # a runner's foot at 25 Hz
    if rate > 25:
        assert found == pytest.approx([sd] * len(found), rel=0.2)  # 2000 frames; differences of one path are correlated


def test_a_sprint_from_fifty_frames_a_second():
    xyz = body("sprint", 50)
    noisy = xyz + 0.3 * np.random.default_rng(2).normal(size=xyz.shape)
    assert np.median([white_noise_sd(path) for path in noisy]) == pytest.approx(0.3, rel=0.05)


def test_jumps_gaps_and_slow_errors_do_not_count():
    rng = np.random.default_rng(3)
    path = 0.5 * rng.normal(size=(4000, 3)) + np.arange(4000)[:, None] ** 2 * 1e-3
    path[1000:] += 40
    path[2000:2100] = np.nan
    slow = 3 * np.sin(np.arange(4000) / 200)[:, None]
    assert white_noise_sd(path + slow) == pytest.approx(0.5, rel=0.08)


def test_too_few_samples_in_a_row_say_nothing():
    path = np.random.default_rng(4).normal(size=(400, 3))
    assert np.isnan(white_noise_sd(path[:31])) and white_noise_sd(path[:60]) > 0
    path[::12] = np.nan
    assert np.isnan(white_noise_sd(path))
