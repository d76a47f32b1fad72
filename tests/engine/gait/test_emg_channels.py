"""Which channels of a trial are EMG."""

import numpy as np
import pytest

from kinemark.data import Analog, Trajectories, Trial
from kinemark.data.strides import Stride
from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.engine.gait.emg import emg_of, greatest_contractions, left_out_of
from kinemark.findings.gait import gait_figures
from kinemark.findings.gait_muscles import of_contractions
from kinemark.findings.gait_records import MeasuredSubject
from kinemark.gait.gait_cycles import emg_curves

MUSCLES = ("Voltage.L Rect", "R_soleus", "Electric Potential.1", "EMG7", "L Pectoralis", "Voltage.MX left")
LEG = LegMeasures(leg_mm=900.0, knee_mm=105.0, ankle_mm=75.0)
BODY = SubjectMeasures(LEG, LEG)
OTHERS = (
    "Electric Potential.Fx",
    "Electric Potential.Fz [2]",
    "Mx1",
    "Raw.Pin 12",
    "LeftFootSwitch",
    "Sync",
    "Trigger A",
    "Voltage.L Spare",
    "EMG_unused_4",
    "Not connected",
)


@pytest.mark.parametrize("unit", ["V", "mV", "µV"])
def test_a_plates_volts_pins_and_switches_are_no_muscles(unit):
    names = MUSCLES + OTHERS
    values = np.random.default_rng(0).normal(size=(len(names), 2000))
    trial = Trial("walk", Trajectories((), 100.0), (Analog(names, (unit,) * len(names), 1000.0, values),))
    assert tuple(emg_of(trial)) == MUSCLES


def test_a_channel_that_cannot_be_emg_does_not_stop_the_trial():
    """Slow and about zero: read in volts at the cameras' rate."""
    values = np.random.default_rng(0).normal(size=(1, 300))
    trial = Trial("walk", Trajectories((), 60.0), (Analog(("L Rect",), ("V",), 60.0, values),))
    assert not emg_of(trial) and "1000 Hz or more" in left_out_of(trial, ())["L Rect"]


def test_muscles_of_a_file_without_units_are_emg():
    """They were left out of the report without a word."""
    muscles = ("Voltage.L Rect", "R Tib Ant", "LGast", "R_gluteus_medius", "Vastus lat", "semitendinosus R", "L Hams")
    others = ("Fx1", "L Spare", "Direct", "Angle", "Sync", "Stibitz", "Chamber")
    values = np.random.default_rng(0).normal(size=(len(muscles + others), 2000))
    trial = Trial("walk", Trajectories((), 100.0), (Analog(muscles + others, ("",) * len(values), 1000.0, values),))
    assert tuple(emg_of(trial)) == muscles


def test_letters_of_a_muscle_tell_a_channel_without_a_unit():
    muscles = ("LTA", "R_SOL", "GMED L", "rf", "VM")
    others = ("FX1", "CH3", "STEP", "GM2X", "A", "LR")
    values = np.random.default_rng(0).normal(size=(len(muscles + others), 3000))
    trial = Trial("walk", Trajectories((), 100.0), (Analog(muscles + others, ("",) * len(values), 1000.0, values),))
    assert tuple(emg_of(trial)) == muscles


def bursting(unit, gain, leap=0.0):
    """A muscle that is on for half of each second, in a unit; its first samples leap."""
    time = np.arange(4000) / 1000.0
    values = (0.02 + 0.5 * (time % 1.0 < 0.5)) * np.random.default_rng(1).normal(size=4000) * gain
    values[:5] += leap
    return Trial("walk", Trajectories((), 100.0), (Analog(("EMG LTA",), (unit,), 1000.0, values[None]),))


@pytest.mark.parametrize(("unit", "gain"), [("V", 1e-3), ("mV", 1.0), ("µV", 1e3), ("uV", 1e3)])
def test_a_contraction_in_another_unit_is_the_same_contraction(unit, gain):
    own = emg_of(bursting("mV", 1.0))["EMG LTA"]
    most = greatest_contractions(bursting(unit, gain), ("EMG LTA",))["EMG LTA"]
    assert most == pytest.approx(np.max(own.envelope))
    assert emg_of(bursting(unit, gain))["EMG LTA"].on.tolist() == own.on.tolist()


@pytest.mark.parametrize(("gain", "told"), [(1000.0, True), (1.0, False), (0.3, False), (1e-3, True)])
def test_a_contraction_with_another_gain_is_told(gain, told):
    most = greatest_contractions(bursting("mV", gain), ("EMG LTA",))
    steps = [Stride("left", k, k + 1.0, {"foot_off": 60.0}, {}) for k in range(3)]
    curves = emg_curves(emg_of(bursting("mV", 1.0)), steps, whole=most)
    found = [one.kind for one in of_contractions(curves)]
    assert found == ["emg_scale_doubtful"] * told


def test_without_a_trial_of_contractions_none_is_doubted():
    """A leap before the first stride is then 100 %, and the strides are far below it."""
    steps = [Stride("left", k, k + 1.0, {"foot_off": 60.0}, {}) for k in (1, 2)]
    curves = emg_curves(emg_of(bursting("mV", 1.0, leap=1e4)), steps)
    subject = MeasuredSubject("", BODY)
    for contractions in (False, True):
        figures = gait_figures((), curves, {}, subject=subject, method={}, contractions=contractions)
        assert ("emg_scale_doubtful" in {one["kind"] for one in figures["findings"]}) == contractions
