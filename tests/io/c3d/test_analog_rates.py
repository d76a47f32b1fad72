"""C3D: channels of any rate and start go on the file's one clock, and what that changes is said."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Analog, ForcePlate, KinemarkError, MarkerTrajectory, Trajectories, Trial
from kinemark.io.c3d import on_frames, read_c3d, write_c3d

FAST = Analog(("a",), ("V",), 1000.0, np.arange(45.0)[None])
SLOW = Analog(("b",), ("N",), 500.0, np.arange(10.0)[None])


def kinds(notes):
    return [(note.kind, note.names) for note in notes]


def test_a_slower_channel_is_repeated_and_what_is_missing_is_nan():
    both, notes = on_frames((FAST, SLOW), 250.0, 10)
    assert (both.names, both.units, both.rate) == (("a", "b"), ("V", "N"), 1000.0)
    assert np.array_equal(both["a"], np.arange(40.0))
    assert np.array_equal(both["b"][:20], np.repeat(np.arange(10.0), 2)) and np.isnan(both["b"][20:]).all()
    assert kinds(notes) == [("cut", ("a",))] and notes[0].values["seconds"] == pytest.approx(0.005)


def test_a_rate_that_is_no_multiple_is_interpolated_and_said():
    """A straight line in time stays one, whatever the rates."""
    odd = Analog(("c", "d"), ("V", "V"), 333.0, np.array([[2.0], [-1.0]]) * np.arange(200) / 333.0)
    whole, notes = on_frames((odd,), 250.0, 100)
    assert whole.rate == 500.0  # the least multiple above
    time = np.arange(200) / 500.0
    assert np.allclose(whole.values, np.array([[2.0], [-1.0]]) * time, atol=1e-12)
    assert kinds(notes)[0] == ("resampled", ("c", "d"))
    assert notes[0].values == {"rate_hz": 333.0, "stored_rate_hz": 500.0}


@pytest.mark.parametrize("start", [0.5, -0.02, 0.0123])
def test_a_channel_keeps_its_time(start):
    """What a channel shows at a time it shows at that time in the file, wherever it begins."""
    late = Analog(("e",), ("V",), 1000.0, (start + np.arange(2000) / 1000.0)[None], start)
    (values,) = on_frames((late,), 250.0, 200)[0].values
    seen = np.isfinite(values)
    assert np.allclose(values[seen], np.flatnonzero(seen) / 1000.0, atol=1e-9)
    assert seen.sum() >= 800 - max(0, 1000 * start) - 1


def test_nothing_fits_and_nothing_is_lost(tmp_path):
    """Every channel of every record is in the file, with the force plate that names one of them."""
    path = MarkerTrajectory.measured("m", np.ones((100, 3)))
    records = (
        replace(FAST, values=np.arange(400.0)[None]),
        replace(SLOW, values=np.arange(200.0)[None], start=0.1),
        Analog(("odd",), ("N",), 310.0, np.arange(120.0)[None]),
        Analog(("beside",), ("mV",), 40.0, np.arange(16.0)[None], -0.0133),
    )
    plate = ForcePlate(2, np.zeros((4, 3)), np.zeros(3), ("odd",))
    notes = write_c3d(tmp_path / "t.c3d", Trial("t", Trajectories((path,), 250.0), records, (plate,)))
    (back,) = read_c3d(tmp_path / "t.c3d").analog
    assert back.names == ("a", "b", "odd", "beside") and back.rate == 1000.0
    assert read_c3d(tmp_path / "t.c3d").plates[0].channels == ("odd",)
    assert np.isnan(back["b"][:100]).all() and np.array_equal(back["b"][100:110:2], np.arange(5.0))
    assert ("resampled", ("odd",)) in kinds(notes) and ("resampled", ("beside",)) in kinds(notes)
    assert ("resampled", ("b",)) not in kinds(notes)


def test_rates_that_files_round_are_one():
    near = Analog(("x",), ("V",), 999.7, np.arange(400.0)[None])
    whole, notes = on_frames((near,), 249.92, 100)
    assert whole.rate == 999.7 and np.array_equal(whole.values, near.values) and not notes


def test_empty_channels_and_no_channels():
    assert on_frames((), 100.0, 5) == (None, ())
    whole, notes = on_frames((Analog(("x",), ("V",), 333.0, np.zeros((1, 0))),), 100.0, 5)
    assert whole.values.shape == (1, 20) and np.isnan(whole.values).all() and not notes


@pytest.mark.parametrize("rate", [59.94, 119.88, 23.976, 100 / 3, 66.6667])
@pytest.mark.parametrize("samples", [3, 5, 10, 20])
def test_stored_rates_have_a_whole_ratio_for_readers_that_round_it_down(tmp_path, rate, samples):
    """Rates are stored in single precision; ezc3d takes the whole part of their ratio as the samples of a frame."""
    channels = Analog(("a",), ("V",), rate * samples, np.zeros((1, 4 * samples)))
    marker = MarkerTrajectory.measured("m", np.ones((4, 3)))
    write_c3d(tmp_path / "a.c3d", Trial("a", Trajectories((marker,), rate), analog=(channels,)))
    doc = read_c3d(tmp_path / "a.c3d").source
    assert int(doc.number("ANALOG", "RATE", 0) / doc.number("POINT", "RATE", 1)) == samples == doc.samples


def test_more_samples_than_a_frame_holds_are_refused_before_they_take_memory():
    """A trial of 293 frames at 0.01 Hz with 34 channels at 1000 Hz took 14 GB."""
    with pytest.raises(KinemarkError, match="100000 samples"):
        on_frames((FAST,), 0.01, 10**9)


@pytest.mark.parametrize("floats", [True, False])
def test_writing_many_channels_takes_less_memory_than_they_do(tmp_path, floats):
    """It took six times that: 100 000 frames with 64 channels ended small computers."""
    values = np.random.default_rng(1).integers(-2000, 2000, (32, 80_000)).astype(float)
    fast = Analog(tuple(f"c{k}" for k in range(32)), ("V",) * 32, 200.0, values)
    path = MarkerTrajectory.measured("m", np.ones((40_000, 3)))
    write_c3d(tmp_path / "t.c3d", Trial("t", Trajectories((path,), 100.0), (fast,)), floats=floats)
    trial = read_c3d(tmp_path / "t.c3d")
    tracemalloc.start()
    write_c3d(tmp_path / "again.c3d", trial)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (tmp_path / "again.c3d").read_bytes() == (tmp_path / "t.c3d").read_bytes()
    assert most < 1.5 * values.nbytes, most / values.nbytes
