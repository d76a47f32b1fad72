"""Filters have no lag, the cut-off that they state, and leave the noise that they foretell."""

from importlib import import_module

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_smoothing_spline

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.kinematics import Butterworth, WoltringSpline, residual_cutoff, smooth
from kinemark.signal.filters import butterworth, butterworth_gain, moving_average, residual_analysis
from kinemark.signal.splines import smoothing_spline
from kinemark.signal.woltring import spline_gain, woltring

RNG = np.random.default_rng(12)
RATE = 100.0
T = np.arange(1000) / RATE


def both(y, cutoff):
    return butterworth(y, rate=RATE, cutoff_hz=cutoff), woltring(y, cutoff=cutoff / RATE).values


@pytest.mark.parametrize("cutoff", [3.0, 8.0, 20.0])
def test_a_sine_at_the_cutoff_falls_to_one_over_root_two_without_lag(cutoff):
    y = np.stack([np.sin(2 * np.pi * cutoff * T), np.cos(2 * np.pi * cutoff * T)], -1)
    for out in both(y, cutoff):
        middle = slice(300, 700)
        assert np.abs(out[middle] - y[middle] / np.sqrt(2)).max() < 0.01


def test_slow_motion_passes_and_fast_does_not():
    slow, fast = np.sin(2 * np.pi * 0.5 * T)[:, None], np.sin(2 * np.pi * 30 * T)[:, None]
    for a, b in zip(both(slow, 6.0), both(fast, 6.0), strict=True):
        assert np.abs(a - slow)[100:-100].max() < 2e-3 and np.abs(b)[100:-100].max() < 0.03


@pytest.mark.parametrize("order", [1, 2, 4])
def test_butterworth_leaves_the_noise_that_it_foretells(order):
    y = RNG.normal(size=(4000, 20))
    out = butterworth(y, rate=RATE, cutoff_hz=10.0, order=order)
    assert abs(out[100:-100].var() / butterworth_gain(rate=RATE, cutoff_hz=10.0, order=order) - 1) < 0.05


@pytest.mark.parametrize("m", [2, 3])
def test_the_spline_leaves_the_noise_that_it_foretells(m):
    y = RNG.normal(size=(2000, 30))
    out = woltring(y, half_order=m, cutoff=0.08).values
    assert abs(out[100:-100].var() / spline_gain(0.08, half_order=m) - 1) < 0.05


def test_the_cubic_spline_is_the_one_that_others_find():
    y = 40 * np.sin(T[:300] * 5) + RNG.normal(size=300)
    for cutoff in (0.02, 0.1, 0.3):
        p = (np.sqrt(2) - 1) * (2 * np.pi * cutoff) ** -4.0
        theirs = make_smoothing_spline(np.arange(300.0), y, lam=p)(np.arange(300.0))
        assert np.abs(woltring(y[:, None], half_order=2, cutoff=cutoff).values[:, 0] - theirs).max() < 1e-8


def test_the_quintic_spline_minimises_its_functional():
    """Parabolas cost nothing and stay; the result is linear in the samples and symmetric in time."""
    t = np.arange(60.0)
    parabola = (0.03 * t**2 - t + 5)[:, None]
    assert np.abs(woltring(parabola, cutoff=0.01).values - parabola).max() < 1e-5
    a, b = RNG.normal(size=(2, 60, 1))
    S = [woltring(y, cutoff=0.1).values for y in (a, b, 2 * a - b, a[::-1])]
    assert np.allclose(S[2], 2 * S[0] - S[1]) and np.allclose(S[3], S[0][::-1])


def test_cross_validation_finds_nearly_the_best_smoothing():
    true = np.stack([100 * np.sin(2 * np.pi * 0.8 * T), 30 * np.cos(2 * np.pi * 1.7 * T)], -1)
    y = true + RNG.normal(size=true.shape)
    error = [np.sqrt(np.mean((woltring(y, cutoff=c).values - true) ** 2)) for c in np.geomspace(0.01, 0.4, 30)]
    found = woltring(y)
    assert np.sqrt(np.mean((found.values - true) ** 2)) < 1.1 * min(error)


def test_cross_validation_is_the_trace_of_the_smoother():
    """The score that is minimised, against the smoother's whole matrix."""
    n = 40
    y = np.sin(np.arange(n) / 5)[:, None] + 0.1 * RNG.normal(size=(n, 1))
    cutoffs = np.geomspace(0.02, 0.4, 200)
    scores = []
    for c in cutoffs:
        A = woltring(np.eye(n) + 0.0, cutoff=c).values
        scores.append(np.sum((y - A @ y) ** 2) / (n - np.trace(A)) ** 2)
    assert abs(np.log(woltring(y).cutoff / cutoffs[int(np.argmin(scores))])) < 0.08


def test_the_spline_goes_across_gaps_and_long_signals():
    true = np.sin(2 * np.pi * 0.5 * T)[:, None]
    y = true + 0.001 * RNG.normal(size=true.shape)
    y[400:420] = np.nan
    assert np.abs(woltring(y).values - true)[400:420].max() < 0.01
    assert len(woltring(np.tile(true, (6, 1)), cutoff=0.1).values) == 6000


def test_residual_analysis_finds_noise_and_a_good_cutoff():
    true = np.stack([200 * np.sin(2 * np.pi * 0.7 * T), 50 * np.sin(2 * np.pi * 2.1 * T + 1), 10 * T], -1)
    y = true + 0.8 * RNG.normal(size=true.shape)
    cutoff, sigma = residual_analysis(y, rate=RATE)
    assert abs(sigma / 0.8 - 1) < 0.05
    errors = {c: np.sqrt(np.mean((butterworth(y, rate=RATE, cutoff_hz=c) - true) ** 2)) for c in np.arange(2, 20, 0.5)}
    assert np.sqrt(np.mean((butterworth(y, rate=RATE, cutoff_hz=cutoff) - true) ** 2)) < 1.5 * min(errors.values())


@pytest.mark.parametrize("times", [2, 4])
def test_samples_put_between_leave_the_cutoff_of_residual_analysis(times):
    """Noise then ends where it did; of a file with noise up to half of its rate, all of it is found."""
    t, true = T[:400], 200 * np.sin(2 * np.pi * 0.9 * T[:400]) + 20 * np.sin(2 * np.pi * 4.5 * T[:400])
    y = true[:, None] + 0.3 * np.random.default_rng(3).normal(size=(400, 3))
    before, _ = residual_analysis(y, rate=RATE)
    after, _ = residual_analysis(CubicSpline(t, y)(np.arange(399 * times + 1) / (times * RATE)), rate=times * RATE)
    assert abs(after / before - 1) < 0.1
    sigma = residual_analysis(np.random.default_rng(4).normal(size=(4000, 3)), rate=times * RATE)[1]
    assert abs(sigma - 1) < 0.05


def test_filters_refuse_what_they_cannot_do():
    with pytest.raises(ValueError, match="cutoff_hz is 60"):
        butterworth(np.zeros((100, 1)), rate=RATE, cutoff_hz=60.0)
    with pytest.raises(ValueError, match="samples, wanted more"):
        butterworth(np.zeros((5, 1)), rate=RATE, cutoff_hz=6.0)
    with pytest.raises(ValueError, match="wanted more than 6"):
        woltring(np.zeros((6, 1)))
    with pytest.raises(ValueError, match=r"0 to 0\.5"):
        woltring(np.zeros((60, 1)), cutoff=0.7)
    with pytest.raises(ValueError, match="residual analysis"):
        residual_analysis(np.zeros((20, 1)), rate=RATE)
    for method in (Butterworth, WoltringSpline):
        with pytest.raises(ValueError, match="cutoff_hz"):
            method(cutoff_hz=-1.0)


def trial(sd=0.5):
    true = np.stack([150 * np.sin(2 * np.pi * 0.6 * T), 80 * np.cos(2 * np.pi * 0.6 * T), 20 * T], -1)
    cov = np.tile(sd**2 * np.eye(3), (len(T), 1, 1))
    noisy = true + sd * RNG.normal(size=true.shape)
    holed = noisy.copy()
    holed[300:340] = holed[700:702] = np.nan
    paths = (MarkerTrajectory.measured("whole", noisy, cov=cov), MarkerTrajectory.measured("holed", holed, cov=cov))
    return Trajectories(paths, RATE), true


@pytest.mark.parametrize("method", [Butterworth(6.0), Butterworth(), WoltringSpline(6.0), WoltringSpline()])
def test_markers_are_smoothed_gaps_stay_and_covariances_are_true(method):
    raw, true = trial()
    out = smooth(raw, method=method)
    assert [(np.isnan(a.xyz) == np.isnan(b.xyz)).all() for a, b in zip(raw, out, strict=True)] == [True, True]
    error = (out["whole"].xyz - true)[50:-50]
    stated = np.sqrt(out["whole"].cov[500, 0, 0])
    assert error.std() < 0.3 and 0.85 < error.std() / stated < 1.3
    turn = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1.0]])  # what is smoothed turns with the laboratory
    turned = smooth(Trajectories((MarkerTrajectory.measured("w", raw["whole"].xyz @ turn.T),), RATE), method=method)
    assert np.allclose(turned["w"].xyz, out["whole"].xyz @ turn.T, atol=1e-6)


def test_short_paths_are_kept_as_they_are():
    short = Trajectories(
        (
            MarkerTrajectory.measured("s", RNG.normal(size=(6, 3))),
            MarkerTrajectory.measured("n", np.full((6, 3), np.nan)),
        ),
        RATE,
    )
    for method in (Butterworth(6.0), Butterworth(), WoltringSpline()):
        out = smooth(short, method=method)
        assert np.array_equal(out.xyz, short.xyz, equal_nan=True)
    assert residual_cutoff(short["s"], rate=RATE) is None


def test_both_forms_of_the_spline_are_the_same_spline():
    """In bands for long signals, and by kernels for samples at any times, where p is in units of half the range."""
    rng, n, cutoff, m = np.random.default_rng(3), 80, 0.07, 3
    y = np.sin(np.arange(n)[:, None] / 9) + 0.1 * rng.standard_normal((n, 2))
    seen = rng.random(n) < 0.8
    p = (np.sqrt(2) - 1) * (2 * np.pi * cutoff) ** (-2.0 * m) / ((n - 1) / 2) ** (2 * m - 1)
    t = np.arange(n, dtype=float)
    kernels = smoothing_spline(t[seen], y[seen], t, half_order=m, smoothing=p)
    banded = woltring(np.where(seen[:, None], y, np.nan), half_order=m, cutoff=cutoff)
    within = slice(np.flatnonzero(seen)[0], np.flatnonzero(seen)[-1] + 1)
    np.testing.assert_allclose(banded.values[within], kernels.values[within], atol=1e-6)


def test_the_moving_average_is_the_mean_about_each_sample_and_keeps_lines():
    y = np.random.default_rng(2).normal(1e6, 3.0, (40, 3))
    out = moving_average(y, 7)
    np.testing.assert_allclose(out[10], y[7:14].mean(0))
    np.testing.assert_allclose(out[1], y[:3].mean(0))
    np.testing.assert_array_equal(out[[0, -1]], y[[0, -1]])
    line = np.outer(np.arange(40.0), [1.0, -2.0, 0.5]) + 7
    np.testing.assert_allclose(moving_average(line, 9), line, atol=1e-9)
    np.testing.assert_array_equal(moving_average(y, 1), y)
    for wrong in (0, 4):
        with pytest.raises(ValueError, match="wanted an odd number"):
            moving_average(y, wrong)


def test_a_markers_cut_off_is_found_once_by_rate(monkeypatch):
    asked = []
    monkeypatch.setattr(
        import_module("kinemark.kinematics.smooth"),
        "residual_analysis",
        lambda y, *, rate, order: asked.append(rate) or residual_analysis(y, rate=rate, order=order),
    )
    xyz = np.random.default_rng(1).normal(size=(60, 3)).cumsum(0)
    path = MarkerTrajectory.measured("s", xyz)
    found = [residual_cutoff(path, rate=rate) for rate in (RATE, RATE, RATE / 2)]
    assert asked == [RATE, RATE / 2] and found[0] == found[1] == residual_analysis(xyz, rate=RATE)[0]
    assert found[2] == pytest.approx(found[0] / 2)
