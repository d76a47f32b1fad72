"""The predictor, filter and smoother, and the fillers made of them."""

import numpy as np
import pytest

from kinemark.fill import Gap, MarkerArray
from kinemark.fill.methods.kalman_predictor import Kalman, fill_kalman
from kinemark.signal.kalman import F, KalmanState, predict, update, update_position
from kinemark.signal.smoother import (
    filter_positions,
    measurement_sd_of,
    predict_gaps,
    process_sd_of,
    smooth_gaps,
    smooth_positions,
)

MODES = ("forward", "forward_backward", "smoother")
METHODS = [Kalman(mode) for mode in MODES] + [Kalman(mode, differences=True) for mode in MODES[:2]]


def walk(n, n_frames, sd, process_sd, seed):
    """Positions (n, W) of sequences with accelerations that walk at random, and measurements of them."""
    rng = np.random.default_rng(seed)
    x = np.zeros((n_frames, n, 3))
    x[0] = rng.normal(size=(n, 3)) * (50, 2, 0.1)
    for k in range(1, n_frames):
        x[k] = x[k - 1] @ F.T
        x[k, :, 2] += process_sd * rng.normal(size=n)
    true = x[:, :, 0].T
    return true, true + sd * rng.normal(size=true.shape)


@pytest.mark.parametrize("method", METHODS, ids=str)
def test_constant_acceleration_is_exact(method):
    t = np.arange(150.0)
    xyz = np.stack([3 + 2 * t + 0.05 * t**2, 400 - t + 0.01 * t**2, 0 * t + 5], -1)
    motion, gaps = MarkerArray(xyz[None], 100.0, ("a",)), [Gap(0, 60, 100), Gap(0, 20, 30)]
    for gap, found in zip(gaps, fill_kalman(motion.hidden(gaps), gaps, method=method), strict=True):
        np.testing.assert_allclose(found.xyz, xyz[gap.start : gap.stop], atol=1e-4)
        assert (np.linalg.eigvalsh(found.cov) > 0).all()


def test_the_smoother_is_the_same_with_time_reversed():
    _, y = walk(4, 80, 0.5, 0.02, 1)
    y[:, 30:50] = np.nan
    sd, process_sd = np.full(4, 0.5), np.full(4, 0.02)
    one, other = (
        smooth_positions(y, sd=sd, process_sd=process_sd),
        smooth_positions(y[:, ::-1], sd=sd, process_sd=process_sd),
    )
    np.testing.assert_allclose(one.x[:, :, 0], other.x[:, ::-1, 0], atol=1e-3)
    np.testing.assert_allclose(one.P[..., 0, 0], other.P[:, ::-1, 0, 0], rtol=1e-3)


def test_a_gap_in_one_step_is_what_frame_by_frame_makes_of_it():
    _, y = walk(6, 140, 0.5, 0.02, 4)
    sd, process_sd, length = np.full(6, 0.5), np.geomspace(0.005, 0.1, 6), np.array([1, 2, 10, 40, 60, 80])
    y[:, ::7] = np.nan  # samples beside the gap may be missing too
    for k, n in enumerate(length):
        y[k, 30 : 30 + n] = np.nan
    y[2, 40:] = y[3, :10] = np.nan  # nothing after the gap; a late beginning
    one_by_one, filtered = (
        smooth_positions(y, sd=sd, process_sd=process_sd),
        filter_positions(y, sd=sd, process_sd=process_sd),
    )
    after = np.stack([np.pad(y[k, 30 + n :], (0, n), constant_values=np.nan) for k, n in enumerate(length)])
    smoothed = smooth_gaps(y[:, :30], after, length, sd=sd, process_sd=process_sd)
    predicted = predict_gaps(y[:, :30], length, sd=sd, process_sd=process_sd)
    for k, n in enumerate(length):
        gap = slice(30, 30 + n)
        np.testing.assert_allclose(smoothed[k].x, one_by_one.x[k, gap, 0], atol=1e-6)
        np.testing.assert_allclose(smoothed[k].variance, one_by_one.P[k, gap, 0, 0], rtol=1e-6)
        np.testing.assert_allclose(predicted[k].variance, filtered.P[k, gap, 0, 0], rtol=1e-4)
        np.testing.assert_allclose(predicted[k].x, filtered.x[k, gap, 0], atol=1e-2)


def test_the_smoother_solves_the_least_squares_problem():
    _, y = walk(1, 25, 0.5, 0.05, 2)
    y[:, 8:14] = np.nan
    sd, process_sd = 0.5, 0.05
    found = smooth_positions(y, sd=np.array([sd]), process_sd=np.array([process_sd]))
    seen = np.flatnonzero(~np.isnan(y[0]))
    # Written out: samples, and states that follow from each other; position and velocity without noise of their own.
    rows, right = [], []
    for k in seen:
        row = np.zeros(75)
        row[3 * k] = 1 / sd
        rows.append(row)
        right.append(y[0, k] / sd)
    for k in range(24):
        for i, weight in enumerate((1e5, 1e5, 1 / process_sd)):
            row = np.zeros(75)
            row[3 * (k + 1) + i] = weight
            row[3 * k : 3 * k + 3] -= weight * F[i]
            rows.append(row)
            right.append(0.0)
    x = np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)[0].reshape(25, 3)
    np.testing.assert_allclose(found.x[0], x, atol=2e-3)


def test_the_filters_covariance_is_honest():
    true, y = walk(400, 90, 0.4, 0.03, 3)
    y[:, 50:70] = np.nan
    sd, process_sd = np.full(400, 0.4), np.full(400, 0.03)
    filtered, smoothed = (
        filter_positions(y, sd=sd, process_sd=process_sd),
        smooth_positions(y, sd=sd, process_sd=process_sd),
    )
    for found in (filtered, smoothed):
        z = (found.x[..., 0] - true) / np.sqrt(found.P[..., 0, 0])
        for frames in (slice(20, 50), slice(50, 60), slice(60, 70)):
            assert 0.92 < (np.abs(z[:, frames]) < 1.96).mean() < 0.975
    assert (smoothed.P[:, 60, 0, 0] < filtered.P[:, 60, 0, 0]).all()


@pytest.mark.parametrize("mode", MODES)
def test_intervals_hold_with_noise_and_jerk_found(mode):
    true, xyz = (np.stack(a, -1) for a in zip(*(walk(12, 400, 0.4, 0.03, seed) for seed in (4, 5, 6)), strict=True))
    gaps = [Gap(m, 50 + 60 * i, 65 + 60 * i) for m in range(12) for i in range(5)]
    motion = MarkerArray(xyz, 100.0, tuple(map(str, range(12))))
    found = fill_kalman(motion.hidden(gaps), gaps, method=Kalman(mode))
    z = [
        (f.xyz - true[g.marker, g.start : g.stop]) / np.sqrt(f.cov[:, 0, 0])[:, None]
        for f, g in zip(found, gaps, strict=True)
    ]
    assert 0.88 < (np.abs(np.array(z)) < 1.96).mean() < 0.99


def test_noise_and_jump_are_found():
    _, y = walk(60, 2000, 0.4, 0.02, 7)
    np.testing.assert_allclose(np.median(measurement_sd_of(y)), 0.4, rtol=0.05)
    np.testing.assert_allclose(np.median(process_sd_of(y, 15, np.full(60, 0.4))), 0.02, rtol=0.15)


def test_meeting_in_the_middle_beats_forward_and_the_smoother_beats_both():
    t = np.arange(400) / 100
    xyz = np.stack([200 * np.sin(2 * np.pi * t), 100 * np.cos(4 * np.pi * t), 800 * t], -1)[None]
    gaps = [Gap(0, a, a + 30) for a in range(60, 300, 60)]
    hidden = MarkerArray(xyz, 100.0, ("a",)).hidden(gaps)
    errors = [
        np.mean(
            [
                np.abs(f.xyz - xyz[0, g.start : g.stop]).mean()
                for f, g in zip(fill_kalman(hidden, gaps, method=Kalman(mode)), gaps, strict=True)
            ]
        )
        for mode in MODES
    ]
    assert errors[0] > 2 * errors[1] > 4 * errors[2]


def test_one_position_pulls_as_the_filter_says():
    state = KalmanState(np.zeros((1, 3, 3)), np.diag([4.0, 1.0, 1.0])[None])
    xyz, after = update_position(state, np.array([[5.0, 0, -5.0]]), np.array([4.0]), 0.0)
    np.testing.assert_allclose(xyz, [[2.5, 0, -2.5]])
    same = update(state, np.array([[[5.0, 0, -5.0], [0, 0, 0], [0, 0, 0]]]), np.array([False]), 2.0, 0.0)
    np.testing.assert_allclose(after.x, same.x)
    np.testing.assert_allclose(after.P, same.P)
    assert predict(state, 0.0).P[0, 0, 0] > state.P[0, 0, 0]


@pytest.mark.parametrize("mode", MODES)
def test_degenerate_input(mode):
    method = Kalman(mode)
    assert fill_kalman(MarkerArray(np.zeros((1, 1, 3)), 100.0, ("a",)), [], method=method) == []
    nothing = MarkerArray(np.full((1, 20, 3), np.nan), 100.0, ("a",))
    found = fill_kalman(nothing, [Gap(0, 5, 10)], method=method)[0]
    assert "fewer than 3 samples" in found.reason and np.isnan(found.xyz).all()
    constant = MarkerArray(np.ones((1, 60, 3)), 100.0, ("a",)).hidden([Gap(0, 30, 40)])
    np.testing.assert_allclose(fill_kalman(constant, [Gap(0, 30, 40)], method=method)[0].xyz, 1.0, atol=1e-9)
    wild = np.random.default_rng(0).choice([-1e9, 1e9], (1, 60, 3))
    gap = [Gap(0, 30, 40)]
    found = fill_kalman(MarkerArray(wild, 100.0, ("a",)).hidden(gap), gap, method=method)[0]
    assert np.isfinite(found.xyz).all() and np.isfinite(found.cov).all()
    end = [Gap(0, 55, 60)]
    assert not fill_kalman(MarkerArray(wild, 100.0, ("a",)).hidden(end), end, method=method)[0].reason


def test_wrong_parameters_are_named():
    with pytest.raises(ValueError, match="mode is 'backward', wanted"):
        Kalman("backward")
    with pytest.raises(ValueError, match="jerk is -1, wanted"):
        Kalman(jerk=-1)
    with pytest.raises(ValueError, match="differences"):
        Kalman("smoother", differences=True)
