"""What a plate shows without a load is taken off, and nothing else is; forces are filtered where that is asked for."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Analog, ForcePlate, KinemarkError
from kinemark.findings.gait_doubts import of_plates
from kinemark.gait import reaction
from kinemark.gait.reaction import CHANNELS

RATE, SAMPLES = 100.0, 1000.0
CORNERS = np.array([[400.0, 0, 0], [0, 0, 0], [0, 600, 0], [400, 600, 0]])
VERTICAL = {1: (2,), 2: (2,), 3: (4, 5, 6, 7), 4: (2,), 5: (2,)}
WIDE = {4: np.eye(6), 5: np.eye(6, 8)}


def step(*, first=0.6, last=1.3, duration=2.0, newton=300.0):
    """(N) N of a step between two times, s, with two peaks."""
    t = np.arange(round(duration * SAMPLES)) / SAMPLES
    share = np.clip((t - first) / (last - first), 0, 1)
    return newton * (np.sin(np.pi * share) + 0.35 * np.sin(3 * np.pi * share))


def plate_of(kind):
    names = tuple(f"c{k}" for k in range(CHANNELS[kind]))
    origin = np.array([120.0, 200.0, -40.0]) if kind == 3 else np.array([0.0, 0.0, -40.0])
    return ForcePlate(kind, CORNERS, origin, names, WIDE.get(kind))


def channels_of(kind, force):
    """(K, N) of a load whose pressure stays in one place."""
    share = np.random.default_rng(kind).uniform(-0.2, 0.2, (CHANNELS[kind], 1))
    share[list(VERTICAL[kind])] = -1.0 / len(VERTICAL[kind])
    values = share * force
    if kind == 1:
        values[3:5] = [[30.0], [-80.0]]
    else:
        values[3 if kind != 3 else 8 :] *= 100.0
    return values


def found(kind, values, **how):
    plate = plate_of(kind)
    analog = Analog(plate.channels, ("",) * CHANNELS[kind], SAMPLES, values)
    n = round(values.shape[1] * RATE / SAMPLES)
    return reaction(plate, [analog], n_frames=n, rate=RATE, threshold_n=20.0, **how)


def drift(kind, newton=35.0):
    """(K, 1) of all channels, those of the vertical by `newton` together; a measured centre does not drift."""
    off = np.random.default_rng(10 + kind).uniform(-20.0, 20.0, (CHANNELS[kind], 1))
    off[list(VERTICAL[kind])] = newton / len(VERTICAL[kind])
    if kind == 1:
        off[3:5] = 0.0
    return off


@pytest.mark.parametrize("newton", [-60.0, 8.0, 35.0, 60.0])
@pytest.mark.parametrize("kind", [1, 2, 3, 4, 5])
def test_a_step_is_the_same_whatever_the_plate_shows_without_it(kind, newton):
    clean = channels_of(kind, step())
    noise = np.random.default_rng(3).normal(0, 1.0, clean.shape[1])
    drifted = clean + drift(kind, newton) + noise * np.isin(np.arange(CHANNELS[kind]), VERTICAL[kind][:1])[:, None]
    true, got = found(kind, clean), found(kind, drifted, zeroed=True)
    on = true.force[:, 2] > 60
    assert (got.loaded != true.loaded).sum() <= 2
    np.testing.assert_allclose(got.force[on], true.force[on], atol=1.0)
    np.testing.assert_allclose(got.centre[on], true.centre[on], atol=3.0)
    assert got.baseline_n >= 0.95 * abs(newton)
    assert not np.allclose(found(kind, drifted).force[on], true.force[on], atol=1.0)  # as it is without


@pytest.mark.parametrize(
    "force",
    [
        step(first=-0.3, last=1.0, duration=0.6),  # cut within a step
        np.full(2000, 350.0) + 5 * np.sin(np.arange(2000) / 300),  # somebody stands there
        np.full(2000, 75.0) + np.sin(np.arange(2000) / 300),  # a child with one of two feet
        500 + 200 * np.sin(np.arange(3000) / 80),  # a belt with both feet on it
        np.abs(300 * np.sin(np.pi * np.arange(3000) / 500)),  # one step after the other, without a pause
    ],
)
def test_what_carries_somebody_all_the_time_keeps_its_force(force):
    values = channels_of(2, force)
    as_it_is, zeroed = found(2, values), found(2, values, zeroed=True)
    np.testing.assert_array_equal(zeroed.force, as_it_is.force)
    assert zeroed.baseline_n == 0.0


def test_a_plate_that_writes_0_without_a_load_keeps_its_zeros():
    """By which its events are known to leap (`plate_events`)."""
    values = channels_of(2, np.where(step() > 50.0, step(), 0.0))
    values[2, 100] = 1.0
    np.testing.assert_array_equal(found(2, values, zeroed=True).force, found(2, values).force)


def test_a_plate_on_which_nobody_steps_is_not_loaded():
    assert found(2, np.full((6, 2000), 30.0)).loaded.all()
    assert not found(2, np.full((6, 2000), 30.0), zeroed=True).loaded.any()


@pytest.mark.parametrize("newton", [0.0, 200.0])
def test_noise_hides_no_drift(newton):
    """Of a plate that a child steps on, or nobody."""
    noise = np.random.default_rng(5).normal(0, 15.0, (6, 2000))
    got = found(2, channels_of(2, step(newton=newton)) + 35.0 + noise, zeroed=True)
    true = found(2, channels_of(2, step(newton=newton)))
    assert got.baseline_n == pytest.approx(35.0, abs=1.5)
    assert (got.loaded != true.loaded).sum() <= 4


def test_frames_that_the_file_states_do_not_count_while_somebody_stands_there():
    """Who stands on a plate when the recording begins is as steady as one that nobody stands on."""
    t = np.arange(2000)
    force = np.where(t < 900, 300 + 3 * np.sin(t / 100), step(newton=350.0, first=0.2, last=1.3) * (t < 1300))
    values = channels_of(2, np.where(t < 1300, force, 0.0))
    plate = replace(plate_of(2), zero_frames=np.array([0, 9]))
    analog = Analog(plate.channels, ("",) * 6, SAMPLES, values)
    for zeroed in (True, False):
        got = reaction(plate, [analog], n_frames=200, rate=RATE, zeroed=zeroed)
        assert got.baseline_n == 0.0
        assert got.loaded[:120].all() and not got.loaded[135:].any()


@pytest.mark.parametrize("newton", [-150.0, 150.0])
def test_frames_that_the_file_states_tell_a_drift_of_half_a_load(newton):
    """As a public file has it (TYPE-3 of c3d.org)."""
    noise = np.random.default_rng(6).normal(0, 0.2, (6, 2000))
    plate = replace(plate_of(2), zero_frames=np.array([0, 19]))
    analog = Analog(plate.channels, ("",) * 6, SAMPLES, channels_of(2, step()) + drift(2, newton) + noise)
    got, true = reaction(plate, [analog], n_frames=200, rate=RATE, threshold_n=20.0), found(2, channels_of(2, step()))
    assert got.baseline_n == pytest.approx(150.0, abs=1.0)
    assert (got.loaded != true.loaded).sum() <= 2


def test_frames_that_the_file_states_go_before():
    values = channels_of(2, step()) + 12.0
    values[:, :200] += 5.0  # what the data show is a mean of both
    plate = replace(plate_of(2), zero_frames=np.array([0, 15]))
    analog = Analog(plate.channels, ("",) * 6, SAMPLES, values)
    assert reaction(plate, [analog], n_frames=200, rate=RATE, zeroed=True).baseline_n == pytest.approx(17.0)


def test_what_was_taken_off_is_told():
    small, large = (found(2, channels_of(2, step()) + off, zeroed=True) for off in (3.0, 25.0))
    told = list(of_plates("walk", (), (small, large)))
    assert [(one.kind, one.values["plate"]) for one in told] == [("gait_plate_zeroed", 2)]
    assert told[0].values["baseline"] == pytest.approx(25.0, abs=0.5)


@pytest.mark.parametrize("kind", [1, 2, 3, 5])
def test_a_filtered_force_keeps_its_impulse_and_its_place_and_loses_its_impact(kind):
    force = step()
    t = np.arange(len(force)) / SAMPLES
    force = force + 250 * np.exp(-(((t - 0.63) / 0.006) ** 2))
    raw, low = found(kind, channels_of(kind, force)), found(kind, channels_of(kind, force), cutoff_hz=10.0)
    np.testing.assert_array_equal(low.loaded, raw.loaded)
    np.testing.assert_allclose(low.centre[low.loaded], raw.centre[low.loaded], atol=0.5)
    assert low.force[:, 2].sum() == pytest.approx(raw.force[:, 2].sum(), rel=0.02)
    assert raw.force[63, 2] - low.force[63, 2] > 50
    assert np.abs(raw.force - low.force)[80:110].max() < 6


def test_forces_too_slow_for_the_cut_off_are_refused():
    with pytest.raises(KinemarkError, match=r"cannot be filtered at 600 Hz.*Give a lower"):
        found(2, channels_of(2, step()), cutoff_hz=600.0)
