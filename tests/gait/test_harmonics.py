"""Harmonics of a gait curve."""

import numpy as np
import pytest

from kinemark.gait.harmonics import HARMONICS, curve_harmonics

STRIDE = np.linspace(0, 1, 101)


def test_what_a_curve_is_made_of_comes_back():
    rng = np.random.default_rng(1)
    amplitude, phase = rng.uniform(1, 30, HARMONICS), rng.uniform(-170, 170, HARMONICS)
    waves = [
        a * np.cos(2 * np.pi * h * STRIDE + np.radians(p))
        for h, (a, p) in enumerate(zip(amplitude, phase, strict=True), 1)
    ]
    found = curve_harmonics(20.0 + sum(waves))
    np.testing.assert_allclose(found.amplitude, amplitude, atol=1e-9)
    np.testing.assert_allclose(found.phase_deg, phase, atol=1e-6)
    np.testing.assert_allclose(found.share, amplitude**2 / (amplitude**2).sum(), atol=1e-9)


def test_a_later_curve_has_the_same_amplitudes_and_a_short_gap_does_no_harm():
    curve = 30 * np.cos(2 * np.pi * STRIDE) + 12 * np.cos(4 * np.pi * STRIDE + 1)
    later = np.append(np.roll(curve[:-1], 17), np.roll(curve[:-1], 17)[0])
    np.testing.assert_allclose(curve_harmonics(later).amplitude, curve_harmonics(curve).amplitude, atol=1e-9)
    gap = curve.copy()
    gap[40:43] = np.nan
    np.testing.assert_allclose(curve_harmonics(gap).amplitude, curve_harmonics(curve).amplitude, atol=0.2)


@pytest.mark.parametrize("unknown", [slice(0, 1), slice(20, 40), slice(0, 101)])
def test_what_is_not_known_is_not_told(unknown):
    curve = np.cos(2 * np.pi * STRIDE)
    curve[unknown] = np.nan
    assert np.isnan(curve_harmonics(curve).amplitude).all()


def test_a_curve_that_does_not_move_has_no_shares():
    found = curve_harmonics(np.full(101, 1e6))
    assert np.isnan(found.share).all() and (found.amplitude < 1e-3).all()
