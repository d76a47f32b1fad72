"""EMG made of bursts: found where they are, and faults of the recording named."""

import numpy as np
import pytest
import scipy

from kinemark.data import KinemarkError
from kinemark.data.strides import Stride
from kinemark.gait.emg import EmgFilter, emg, normalised, peak_of
from kinemark.gait.gait_cycles import emg_curves
from support.plug_in_gait import trial

BURSTS = ((0.5, 0.9), (1.6, 2.0), (2.7, 3.1))


def recorded(rate=1000.0, seed=0, unit=1.0, offset=0.0):
    """Noise, ten times as strong in bursts, with movement artefacts below 10 Hz."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(4 * rate)) / rate
    strong = np.any([(t >= a) & (t < b) for a, b in BURSTS], axis=0)
    x = rng.normal(0, np.where(strong, 100.0, 8.0)) + 60 * np.sin(2 * np.pi * 2 * t)
    return t, strong, unit * x + offset


@pytest.mark.parametrize(("rate", "unit", "offset"), [(1000.0, 1.0, 0.0), (2000.0, 1e-6, 2e-3), (1500.0, 3.0, -500.0)])
def test_bursts_are_found(rate, unit, offset):
    for seed in range(3):
        _, strong, x = recorded(rate, seed, unit, offset)
        found = emg(x, rate=rate)
        assert (found.on == strong).mean() > 0.93
        assert found.hum_hz == 0 and found.saturated == 0
        assert np.median(found.envelope[strong]) > 6 * np.median(found.envelope[~strong])


def test_a_muscle_at_rest_beside_a_burst_is_off():
    t, _, x = recorded()
    on = emg(x, rate=1000.0).on
    assert not on[(t > 1.1) & (t < 1.4)].any()


@pytest.mark.parametrize("low_hz", [0.0, 100.0, 200.0])
@pytest.mark.parametrize("unit", [1.0, 1e-6])
def test_noise_alone_is_no_muscle_that_is_on(low_hz, unit):
    """White, or narrow as of an electrode that hangs on nothing."""
    for seed in range(5):
        x = np.random.default_rng(seed).normal(size=4000)
        if low_hz:
            x = scipy.signal.sosfiltfilt(scipy.signal.butter(1, low_hz, fs=1000.0, output="sos"), x)
        found = emg(unit * x + 3 * unit, rate=1000.0)
        assert not found.bursts and not found.on.any()


@pytest.mark.parametrize(("file", "channel"), [("HC033A10", "Voltage.L Rect"), ("HC032A03", "Voltage.R Rect")])
def test_a_channel_that_nobody_wore_is_no_muscle_that_is_on(file, channel):
    """Its noise grows and falls slowly; the muscles of the other leg are a hundred times as strong."""
    walk = trial(f"pig_gait_children/{file}.c3d")
    record = next(one for one in walk.analog if channel in one.names)
    assert not emg(record[channel], rate=record.rate).bursts


@pytest.mark.parametrize("times", [4.0, 8.0, 20.0])
@pytest.mark.parametrize("works", [0.2, 0.5])
def test_rest_is_not_on_however_weak_the_bursts(times, works):
    """Of the rest, which noise makes, hardly any is on; of the bursts nearly all."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        strong = np.mod(np.arange(6000) / 1000.0, 1.0) < works
        on = emg(rng.normal(0, np.where(strong, times, 1.0)), rate=1000.0).on
        assert on[strong].mean() > 0.95 and on[~strong].mean() < 0.1


@pytest.mark.parametrize("works", [0.1, 0.5, 0.85])
def test_a_muscle_that_works_has_bursts_however_long(works):
    rng = np.random.default_rng(1)
    strong = np.mod(np.arange(6000) / 1000.0, 1.0) < works
    found = emg(rng.normal(0, np.where(strong, 50.0, 6.0)), rate=1000.0)
    assert found.bursts and found.on[strong].mean() > 0.9


@pytest.mark.parametrize("mains", [50.0, 60.0])
def test_hum_is_named(mains):
    t, _, x = recorded()
    assert emg(x + 40 * np.sin(2 * np.pi * mains * t), rate=1000.0).hum_hz == mains


@pytest.mark.parametrize("times", [1.0, 3.0])
@pytest.mark.parametrize("rate", [500.0, 1000.0, 2000.0])
def test_hum_hides_no_burst_and_makes_none(rate, times):
    """However much stronger it is than the bursts, with multiples, and at a frequency that is off a little."""
    for seed in range(3):
        t, strong, x = recorded(rate, seed)
        hum = 100 * times * np.sin(2 * np.pi * 50.15 * t) + 60 * times * np.sin(2 * np.pi * 150.45 * t + 1)
        found = emg(x + hum, rate=rate)
        assert found.hum_hz == 50 and (found.on == strong).mean() > 0.93
        rest = np.random.default_rng(seed).normal(0, 8, len(t))
        assert not emg(rest + hum, rate=rate).bursts


SMOOTHED_HZ = (3.0, 6.0, 10.0, 20.0)


def smoothed(hz, rate, seed):
    """What is on, and the rectified EMG smoothed before it was recorded."""
    _, strong, x = recorded(rate, seed)
    x = scipy.signal.sosfiltfilt(scipy.signal.butter(4, 20, "high", fs=rate, output="sos"), x)
    return strong, scipy.signal.sosfiltfilt(scipy.signal.butter(2, hz, fs=rate, output="sos"), np.abs(x))


@pytest.mark.parametrize("unit", [1.0, 1e-6])
@pytest.mark.parametrize("rate", [500.0, 1000.0, 4000.0])
@pytest.mark.parametrize("hz", SMOOTHED_HZ)
def test_a_channel_that_is_an_envelope_is_drawn_as_it_is(hz, rate, unit):
    for seed in range(3):
        strong, x = smoothed(hz, rate, seed)
        found = emg(unit * x, rate=rate)
        assert found.smoothed and found.on[strong].mean() > 0.95 and found.on[~strong].mean() < 0.25
        np.testing.assert_allclose(found.envelope, np.maximum(unit * x, 0))


@pytest.mark.parametrize("rate", [60.0, 100.0])
def test_an_envelope_may_be_slow(rate):
    strong, x = smoothed(6.0, 1000.0, 0)
    step = int(1000 / rate)
    found = emg(x[::step], rate=1000 / step)
    assert found.smoothed and found.on[strong[::step]].mean() > 0.95


@pytest.mark.parametrize("rate", [500.0, 1000.0, 4000.0])
def test_raw_emg_is_no_envelope_where_it_is_rectified_or_drifts_above_zero(rate):
    for seed in range(3):
        t, strong, x = recorded(rate, seed)
        for raw in (np.abs(x), x + 5000 + 2000 * np.sin(2 * np.pi * 0.2 * t), np.where(t < 0.3, 0.0, np.abs(x))):
            found = emg(raw, rate=rate)
            assert not found.smoothed and found.on[strong].mean() > 0.9 and found.on[~strong].mean() < 0.2


@pytest.mark.parametrize("value", [0.0, -3000.0])
def test_an_end_at_which_nothing_was_recorded_is_no_rest(value):
    t, strong, x = recorded(offset=500.0)
    for dead in (t < 0.3, t > 3.5):
        on = emg(np.where(dead, value, x), rate=1000.0).on
        assert on[strong].mean() > 0.9 and on[~strong].mean() < 0.1


@pytest.mark.parametrize("value", [0.0, 40.0])
@pytest.mark.parametrize("rate", [1000.0, 2000.0])
def test_a_radio_that_fails_is_no_rest(rate, value):
    """In a burst, and at rest for longer than a tenth of the channel, beside which nothing else would count as rest."""
    t, strong, x = recorded(rate)
    dead = ((t > 1.7) & (t < 1.95)) | ((t > 2.1) & (t < 2.6))
    found = emg(np.where(dead, value, x), rate=rate)
    assert np.isnan(found.envelope[dead][1:-1]).all() and np.isfinite(found.envelope[~dead]).all()
    assert found.on[strong & ~dead].mean() > 0.9 and found.on[~strong & ~dead].mean() < 0.1
    (curves,) = emg_curves({"R Rect": found}, [Stride("right", 0.0, 3.9, {"foot_off": 60.0}, {})])
    on = curves.values[0, :, 1]
    assert np.isnan(on[[45, 58]]).all() and np.isfinite(on[[20, 35, 70, 90]]).all()


def test_rest_that_was_stored_coarsely_is_rest():
    """Noise below the steps of a channel keeps one value for long."""
    _, strong, x = recorded()
    x = scipy.signal.sosfiltfilt(scipy.signal.butter(4, 20, "high", fs=1000.0, output="sos"), x)
    found = emg(30 * np.round(x / 30), rate=1000.0)
    assert np.isfinite(found.envelope).all() and found.on[strong].mean() > 0.9 and found.on[~strong].mean() < 0.1


def test_rest_at_an_end_that_was_stored_coarsely_is_rest():
    """An envelope is drawn there: the device did send, and the muscle's strength grows over a tenth of a second."""
    t, strong, _ = recorded()
    rise = np.hanning(200) / np.hanning(200).sum()
    x = np.random.default_rng(0).normal(0, 4.0 + 96.0 * np.convolve(strong, rise, "same"))
    x = scipy.signal.sosfiltfilt(scipy.signal.butter(4, 20, "high", fs=1000.0, output="sos"), x)
    found = emg(60 * np.round(x / 60), rate=1000.0)
    rest = (t < 0.3) | (t > 3.4)
    assert np.isfinite(found.envelope).all() and not found.on[rest].any() and found.on[strong].mean() > 0.8


def test_a_loose_electrode_says_nothing_of_its_muscle():
    rng = np.random.default_rng(0)
    t = np.arange(4000) / 1000.0
    x = 5 * np.sin(2 * np.pi * 50 * t) * (1 + 0.5 * np.sin(2 * np.pi * t)) + rng.normal(0, 0.1, 4000)
    found = emg(np.clip(x, -1, 1), rate=1000.0)
    assert found.saturated > 0.5 and not found.bursts


def test_saturation_is_named():
    *_, x = recorded()
    assert emg(np.clip(x, -120, 120), rate=1000.0).saturated > 0.005


def test_gaps_stay_gaps():
    *_, x = recorded()
    x[100:130] = np.nan
    found = emg(x, rate=1000.0)
    assert np.isnan(found.envelope[100:130]).all() and np.isfinite(found.envelope[200:]).all()


def test_the_greatest_is_a_hundred_per_cent():
    *_, x = recorded()
    envelope = emg(x, rate=1000.0).envelope
    assert np.nanmax(normalised(envelope, peak_of(envelope))) == pytest.approx(100)
    assert np.isnan(normalised(np.zeros(5), peak_of(np.zeros(5)))).all()


@pytest.mark.parametrize(("x", "rate"), [(np.zeros(100), 60.0), (np.full(2000, np.nan), 1000.0)])
def test_what_is_no_emg_is_refused(x, rate):
    with pytest.raises(KinemarkError):
        emg(x, rate=rate)
    with pytest.raises(ValueError, match="lower first"):
        EmgFilter(low_hz=500.0)
