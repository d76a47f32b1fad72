"""How much a variance that few residuals tell is enlarged."""

import numpy as np
import pytest

from kinemark.numerics.small_sample import variance_factor


@pytest.mark.parametrize("nu", [1, 2, 5, 20])
def test_intervals_hold(nu):
    """Of numbers by the variance that so many others tell, 95 % are within 1.96 standard deviations, or nearly."""
    rng = np.random.default_rng(nu)
    variance = rng.chisquare(nu, 200_000) / nu * variance_factor(nu)
    assert np.mean(np.abs(rng.normal(size=200_000)) < 1.96 * np.sqrt(variance)) == pytest.approx(0.95, abs=0.004)


def test_more_residuals_enlarge_less():
    factors = [variance_factor(nu) for nu in (0, 1, 2, 3, 4, 10, 1000)]
    assert factors[0] == factors[1] and (np.diff(factors[1:]) < 0).all()
    assert factors[-1] == pytest.approx(1, abs=0.01)
