"""Key values of strides whose curves are known."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Signal, Signals
from kinemark.data.strides import Stride
from kinemark.gait.key_values import KEYS, key_values

RATE = 100.0
OFF = 60.0
STRIDES = tuple(Stride("left", first, first + 1.0, {"foot_off": OFF}, {}) for first in (0.0, 1.0))
"""A second each, so that a frame is 1 % of the stride."""


def flexion(percent):
    """A bump of 18 at 15 % of the stride, one of 60 at 75 %, 5 between them and at both ends."""
    return 5 + 13 * np.exp(-(((percent - 15) / 5) ** 2)) + 55 * np.exp(-(((percent - 75) / 7) ** 2))


def found(name, *, strides=STRIDES, curve=flexion, missing=(), scale=(1.0, 1.0), signal="LKneeAngles", axes=3):
    """The value of that name of each stride."""
    percent = np.arange(201.0)
    y = np.where(percent < 100, scale[0], scale[1]) * curve(percent % 100)
    y[list(missing)] = np.nan
    cov = np.broadcast_to(np.eye(axes) * 4.0, (201, axes, axes))
    one = replace(Signal.of(signal, "angle", "deg", np.stack([y] * axes, -1), rate=RATE), cov=cov)
    return [v for v in key_values(Signals((one,)), strides) if v.name == name]


@pytest.mark.parametrize(
    ("name", "value", "at"),
    [
        ("knee flexion at strike", 5.0, 0.0),
        ("knee flexion, greatest in first half of stance", 18.0, 15.0),
        ("knee flexion, greatest in swing", 60.0, 75.0),
    ],
)
def test_a_peak_is_read_off_its_phase(name, value, at):
    first, second = found(name, scale=(1.0, 1.1))
    assert (first.value, first.at) == (pytest.approx(value, abs=0.01), at)
    assert (second.value, second.at) == (pytest.approx(1.1 * value, abs=0.01), at)
    assert (first.side, first.first, second.first) == ("left", 0.0, 1.0)
    assert first.sd == pytest.approx(2.0, rel=0.01)


def test_the_least_of_the_second_half_of_stance_lies_between_the_peaks():
    (one, _) = found("knee flexion, least in second half of stance")
    assert one.value == pytest.approx(5.0, abs=0.6) and 30 <= one.at <= 50


def test_a_range_has_no_place_and_no_deviation_of_its_own():
    (one, _) = found("knee flexion, range")
    assert one.value == pytest.approx(55.0, abs=0.02) and np.isnan(one.at) and np.isnan(one.sd)


def test_a_phase_with_a_missing_sample_has_no_value_and_the_others_have():
    (swing, whole) = found("knee flexion, greatest in swing", missing=[75])
    assert np.isnan(swing.value) and whole.value == pytest.approx(60.0, abs=0.01)
    (stance, _) = found("knee flexion, greatest in first half of stance", missing=[75])
    assert stance.value == pytest.approx(18.0, abs=0.01)


def test_without_foot_off_phases_are_unknown_and_strike_and_range_are_known():
    blind = tuple(s._replace(values={"foot_off": np.nan}) for s in STRIDES)
    assert np.isnan(found("knee flexion, greatest in swing", strides=blind)[0].value)
    assert found("knee flexion at strike", strides=blind)[0].value == pytest.approx(5.0, abs=0.01)
    assert found("knee flexion, range", strides=blind)[0].value == pytest.approx(55.0, abs=0.02)


def test_names_are_each_of_one_value():
    assert len({key.name for key in KEYS}) == len(KEYS)
