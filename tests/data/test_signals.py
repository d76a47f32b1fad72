"""Quantities: their record, and angles as quantities."""

import numpy as np
import pytest

from kinemark.data import Analog, Angles, MarkerTrajectory, Signal, Signals, Trajectories, Trial, same

KNEE = Signal.of("knee", "angle", "deg", np.arange(12.0).reshape(4, 3), rate=50.0, axes=("flexion", "abduction", "y"))


def test_a_signal_knows_its_axes_time_and_deviation():
    assert np.array_equal(KNEE["abduction"], [1, 4, 7, 10]) and np.allclose(KNEE.time, np.arange(4) / 50)
    assert np.isnan(KNEE.sd).all() and not KNEE.values.flags.writeable
    cov = np.diag([4.0, 9.0, 0.0]) * np.ones((4, 1, 1))
    known = Signal("knee", "angle", "deg", KNEE.axes, 50.0, KNEE.values, cov, 0.5)
    assert np.array_equal(known.sd[0], [2, 3, 0]) and known.time[0] == 0.5
    with pytest.raises(KeyError, match="no axis 'x'"):
        KNEE["x"]


def test_what_a_signal_cannot_be():
    with pytest.raises(ValueError, match="kind is 'torque'"):
        Signal.of("a", "torque", "N·m", np.zeros((2, 3)), rate=50.0)
    with pytest.raises(ValueError, match="values has shape"):
        Signal.of("a", "moment", "N·m", np.zeros((2, 3)), rate=50.0, axes=("x",))
    with pytest.raises(ValueError, match="rate"):
        Signal.of("a", "moment", "N·m", np.zeros((2, 3)), rate=0.0)
    with pytest.raises(ValueError, match="names of signals must differ"):
        Signals((KNEE, KNEE))
    with pytest.raises(ValueError, match="kind is"):
        Signals((KNEE,)).of_kind("angles")


def test_an_update_replaces_one_and_shares_the_rest():
    hip = Signal.of("hip", "angle", "deg", np.zeros((4, 3)), rate=50.0)
    power = Signal.of("power", "power", "W", np.ones((4, 1)), rate=50.0, axes=("z",))
    before = Signals((KNEE, hip))
    after = before.updated(Signals((power, Signal.of("hip", "angle", "deg", np.ones((4, 3)), rate=50.0))))
    assert after.names == ("knee", "hip", "power") and after["knee"] is KNEE and after["hip"].values.all()
    assert after.of_kind("power").names == ("power",) and not len(after.of_kind("emg"))
    assert same(before["hip"].values, np.zeros((4, 3)))


def test_joint_angles_are_signals_of_their_own_axes():
    rng = np.random.default_rng(0)
    angles = Angles(("knee", "hip"), ("zxy", "yxy"), rng.normal(size=(2, 5, 3)), rng.normal(size=(2, 5, 3, 3)), 100.0)
    signals = angles.signals()
    assert signals.names == ("knee", "hip") and signals["hip"].axes == ("y", "x", "y")
    assert np.array_equal(signals["knee"].values, angles["knee"]) and np.array_equal(signals["hip"].cov, angles.cov[1])
    named = angles.signals([("flexion", "adduction", "rotation")] * 2)
    assert {s.unit for s in named} == {"deg"} and np.array_equal(named["hip"]["adduction"], angles["hip"][:, 1])


def test_frames_of_a_trial_keep_all_samples_of_its_channels_at_their_time():
    path = MarkerTrajectory.measured("m", np.arange(30.0).reshape(10, 3))
    analog = Analog(("a",), ("V",), 333.0, np.arange(40.0)[None], 0.01)
    trial = Trial("t", Trajectories((path,), 100.0, 7), (analog,), signals=Signals((KNEE,)))
    part = trial.frames(4, 8)
    assert (part.trajectories.first_frame, part.trajectories.n_frames) == (11, 4)
    assert np.array_equal(part.trajectories["m"].xyz, path.xyz[4:8])
    assert part.analog[0].start == pytest.approx(0.01 - 0.04)
    assert np.shares_memory(part.analog[0].values, analog.values)
    assert np.allclose(part.signals["knee"].time, KNEE.time - 0.04)
    assert same(trial.frames(0, 10), trial)
