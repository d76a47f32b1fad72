"""Cycle length and phase of periodic motion."""

import numpy as np
import pytest

from kinemark.signal.periodic import cycle_length, mean_differences
from kinemark.signal.phase import CyclePhase, CycleTemplate, find_phase, phase_variance


def shape(phase):
    """Three sequences at phases, none of which alone tells the phase."""
    one, two = 2 * np.pi * phase, 4 * np.pi * phase
    return np.stack([np.cos(one), 0.4 * np.sin(two + 1) + np.sin(one), 0.3 * np.cos(two)], -1)


def unsteady(n, cycle, share, seed):
    """Phases (n) of a motion whose speed strays by a share."""
    rng = np.random.default_rng(seed)
    knots = np.arange(0, n + 3 * cycle, 3 * cycle)
    return 0.37 + np.cumsum((1 + share * np.interp(np.arange(n), knots, rng.normal(size=len(knots)))) / cycle)


TEMPLATE = CycleTemplate(shape(np.arange(100) / 100))


@pytest.mark.parametrize("cycle", [31.7, 64.0, 110.3])
def test_the_cycle_is_found_with_samples_missing(cycle):
    rng = np.random.default_rng(0)
    y = shape(np.arange(500) / cycle) + 0.05 * rng.normal(size=(500, 3))
    y[rng.random((500, 3)) < 0.2] = np.nan
    y[100:150] = np.nan
    assert cycle_length(y.T, shortest=10, longest=400) == pytest.approx(cycle, rel=0.01)


def test_a_step_is_no_stride():
    t = np.arange(600) / 100
    legs = np.stack(
        [np.sin(2 * np.pi * t) + 0.3 * np.sin(4 * np.pi * t), -np.sin(2 * np.pi * t) + 0.3 * np.sin(4 * np.pi * t)]
    )
    assert cycle_length(legs, shortest=30, longest=300) == pytest.approx(100, abs=0.5)


def test_what_never_comes_back_has_no_cycle():
    rng = np.random.default_rng(1)
    assert np.isnan(cycle_length(rng.normal(size=(3, 500)).cumsum(1), shortest=20, longest=400))
    assert np.isnan(cycle_length(rng.normal(size=(3, 500)), shortest=20, longest=400))
    assert np.isnan(cycle_length(np.ones((3, 500)), shortest=20, longest=400))
    assert np.isnan(cycle_length(np.full((3, 500), np.nan), shortest=20, longest=400))
    assert np.isnan(cycle_length(np.zeros((3, 1)), shortest=20, longest=400))


def test_differences_are_those_of_the_definition():
    rng = np.random.default_rng(2)
    y = rng.normal(size=(2, 40))
    y[rng.random((2, 40)) < 0.2] = np.nan
    D = mean_differences(y)
    there = ~np.isnan(y)
    centred = y - np.array([[row[own].mean()] for row, own in zip(y, there, strict=True)])
    scale = (centred[there] ** 2).mean()
    for tau in (1, 5, 12):
        square = (y[:, tau:] - y[:, :-tau]) ** 2
        assert D[tau] == pytest.approx(np.nanmean(square) / 2 / scale, rel=1e-9)
    y[1] = np.where(there[0], y[1], np.nan)  # of two sequences one mask
    y[0] = np.where(np.isnan(y[1]), np.nan, y[0])
    np.testing.assert_allclose(mean_differences(y, 15), mean_differences(y)[:15], rtol=1e-9, atol=1e-12)


def test_some_sequences_of_a_template_are_those_of_the_whole():
    phase = np.linspace(-1, 2, 50)
    some = TEMPLATE.select(np.array([2, 0]))
    np.testing.assert_array_equal(some(phase), TEMPLATE(phase)[:, [2, 0]])
    np.testing.assert_array_equal(some.slope(phase), TEMPLATE.slope(phase)[:, [2, 0]])


@pytest.mark.parametrize("seed", range(4))
def test_the_phase_is_found_within_two_percent(seed):
    true = unsteady(1500, 110, 0.15, seed)
    rng = np.random.default_rng(seed)
    y = shape(true) + 0.05 * rng.normal(size=(1500, 3))
    y[300:400, 0], y[350:450, 1:], y[800:900] = np.nan, np.nan, np.nan
    found = find_phase(y, TEMPLATE, np.full(3, 0.05), cycle=110)
    off = found.cycles - true
    off -= np.round(np.median(off))
    seen = np.ones(1500, bool)
    seen[790:910] = False
    assert np.abs(off[seen]).max() < 0.02
    assert np.abs(off).max() < 0.12
    frames = np.arange(800, 900)
    sd = np.sqrt(phase_variance(y, TEMPLATE, np.full(3, 0.05), found.cycles, frames, cycle=110))
    assert sd[50] > 1.5 * sd[0] and sd[50] > 1.5 * sd[-1]
    assert (np.abs(off[frames]) < 4 * sd).all()
    assert found.cost == pytest.approx(1, abs=0.2)


def test_a_cadence_a_third_off_is_found():
    true = np.arange(900) / 80 + 0.2
    found = find_phase(shape(true), TEMPLATE, np.full(3, 0.05), cycle=110)
    off = found.cycles - true
    assert np.abs(off - np.round(off)).max() < 0.02


def test_moments_of_a_percent():
    phase = CyclePhase(0.2 + np.arange(101) / 50, 0.0)
    np.testing.assert_allclose(phase.frames_at(50), [15, 65])
    np.testing.assert_allclose(phase.frames_at(20), [0, 50, 100], atol=1e-9)


def test_no_samples_are_refused():
    with pytest.raises(ValueError, match="wanted two frames and samples"):
        find_phase(np.full((10, 3), np.nan), TEMPLATE, np.ones(3), cycle=10)
    with pytest.raises(ValueError, match="wanted two frames and samples"):
        find_phase(np.zeros((1, 3)), TEMPLATE, np.ones(3), cycle=10)
