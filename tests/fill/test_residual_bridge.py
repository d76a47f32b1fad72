"""The residual bridge: how long residuals last does not hang on how many frames are missing."""

import numpy as np
import pytest

from kinemark.fill.known_samples import Span
from kinemark.fill.residual_bridge import Leftover, bridge


def slow(frames: int, seed: int) -> np.ndarray:
    """(F, 3) mm, residuals that hardly change from one frame to the next."""
    noise = np.random.default_rng(seed).normal(size=(frames + 60, 3))
    window = np.hanning(61)
    return np.stack([np.convolve(column, window / np.linalg.norm(window), "valid") for column in noise.T], axis=1)


@pytest.mark.parametrize("seed", range(4))
def test_holes_do_not_make_residuals_short_lived(seed):
    whole = slow(1000, seed)
    holed = whole.copy()
    for start in range(20, 1000, 30):
        holed[start : start + 2] = np.nan
    span = Span(0, 500, 502, 499, 502)
    beside, frames = whole[[499, 502]], np.array([500.0, 501.0])
    filled = [bridge(Leftover.of(residual, 1), span, frames, beside) for residual in (whole, holed)]
    sizes = [np.sqrt(np.trace(cov, axis1=1, axis2=2)) for _, cov in filled]
    np.testing.assert_allclose(sizes[1], sizes[0], rtol=0.5)
    for xyz, _ in filled:
        np.testing.assert_allclose(xyz, whole[500:502], atol=0.02)


@pytest.mark.parametrize("seed", range(4))
def test_a_bridge_is_never_larger_than_what_residuals_are_like(seed):
    """Correlations from few pairs of frames contradict one another; the fill must not blow up by them."""
    rng = np.random.default_rng(seed)
    residual = rng.normal(size=(60, 3))
    residual[rng.random(60) < 0.6] = np.nan
    beside = np.ones((2, 3))
    for length in (1, 5, 20):
        frames = np.arange(10.0, 10 + length)
        xyz, cov = bridge(Leftover.of(residual, 1), Span(0, 10, 10 + length, 9, 10 + length), frames, beside)
        assert np.abs(xyz).max() < 2 and (np.linalg.eigvalsh(cov) >= -1e-9).all()
