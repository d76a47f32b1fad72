"""Time-distance parameters of a walk whose strides are known."""

import numpy as np
import pytest

from kinemark.data.strides import FootEvent
from kinemark.gait.time_distance import averages, strides

RATE = 100.0
SPEED, PERIOD, WIDTH = 1200.0, 1.1, 90.0


def walk(direction=0.0, sd=0.0, rng=None, heel_sd=0.0, width=WIDTH, stands=0.62):
    """Events and heels of a walk: each foot stands for a share of its stride."""
    t = np.arange(600) / RATE
    points, events = {}, []
    for side, letter, phase, y in (("left", "L", 0.0, width / 2), ("right", "R", 0.5, -width / 2)):
        strikes = (np.arange(6) + phase) * PERIOD
        place = SPEED * strikes  # where the heel stands from each strike on
        x = np.interp(t, np.sort(np.r_[strikes, strikes + stands * PERIOD]), np.repeat(place, 2))
        xyz = np.column_stack([x, np.full(len(t), y), np.full(len(t), 30.0)])
        c, s = np.cos(direction), np.sin(direction)
        points[letter + "HEE"] = xyz @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
        events += [FootEvent(side, True, float(k), sd, "plate") for k in strikes]
        events += [FootEvent(side, False, float(k + stands * PERIOD), sd, "plate") for k in strikes]
    if rng is not None:
        events = [e._replace(time=e.time + rng.normal(0, sd)) for e in events]
        points = {name: xyz + rng.normal(0, heel_sd, xyz.shape) for name, xyz in points.items()}
    return events, points


TRUE = {
    "stride_time": PERIOD, "stride_length": SPEED * PERIOD, "speed": SPEED, "cadence": 120 / PERIOD,
    "step_length": SPEED * PERIOD / 2, "step_width": WIDTH, "step_time": PERIOD / 2, "foot_off": 62.0,
    "opposite_foot_off": 12.0, "opposite_foot_strike": 50.0, "single_support": 0.38 * PERIOD,
    "double_support": 0.24 * PERIOD,
}  # fmt: skip


@pytest.mark.parametrize("direction", [0.0, 2.1, -1.0])
@pytest.mark.parametrize("side", ["left", "right"])
def test_a_known_walk(side, direction):
    events, points = walk(direction)
    found = averages(strides(events, points, rate=RATE), side)
    for name, true in TRUE.items():
        assert found[name][0] == pytest.approx(true, rel=2e-3), name
        assert found[name][2] >= 3


@pytest.mark.parametrize("stands", [0.25, 0.36, 0.48])
def test_a_runner_stands_on_one_foot_or_none(stands):
    events, points = walk(stands=stands)
    for one in strides(events, points, rate=RATE)[1:-1]:
        assert one.values["double_support"] == pytest.approx(0.0, abs=1e-9)
        assert one.values["single_support"] == pytest.approx(stands * PERIOD)


@pytest.mark.parametrize("direction", [0.0, 2.1, -1.0])
@pytest.mark.parametrize("width", [-40.0, 0.0, 25.0])
def test_a_step_in_which_the_feet_cross_has_a_width_below_zero(width, direction):
    events, points = walk(direction, width=width)
    for one in strides(events, points, rate=RATE)[1:-1]:
        assert one.values["step_width"] == pytest.approx(width, abs=0.1)


@pytest.mark.parametrize("direction", [0.0, 2.1, -1.0])
@pytest.mark.parametrize("backwards", [False, True])
def test_left_is_left_of_who_walks_backwards(direction, backwards):
    """Who walks backwards as this walk goes has the left foot on the way's right."""
    events, points = walk(direction, width=-WIDTH if backwards else WIDTH)
    forward = np.array([np.cos(direction), np.sin(direction), 0.0]) * (-150.0 if backwards else 150.0)
    points |= {name[0] + "TOE": xyz + forward for name, xyz in points.items()}
    for one in strides(events, points, rate=RATE)[1:-1]:
        assert one.values["step_width"] == pytest.approx(WIDTH, abs=0.1)


def test_what_is_said_of_the_errors_is_true():
    rng, z = np.random.default_rng(3), {name: [] for name in TRUE}
    for _ in range(60):
        events, points = walk(0.0, 0.01, rng, heel_sd=3.0)
        for one in strides(events, points, rate=RATE, heel_sd_mm=3.0):
            for name, true in TRUE.items():
                z[name].append((one.values[name] - true) / one.sd[name])
    for name, values in z.items():
        spread = np.sqrt(np.nanmean(np.square(values)))  # a heel that stops at the event moves on one side of it only
        assert 0.65 < spread < 1.3, name


def test_a_missing_event_leaves_what_hangs_on_it_missing():
    events, points = walk()
    without = [e for e in events if e.strike]
    one = strides(without, points, rate=RATE)[0]
    assert np.isnan(one.values["foot_off"]) and np.isnan(one.values["single_support"])
    assert one.values["stride_length"] == pytest.approx(TRUE["stride_length"], rel=1e-3)


def test_steps_end_where_feet_struck_though_the_other_heel_has_left_the_floor():
    """Heels go on by 60 mm from 45 % of the stride on, as they rise; steps of both sides make a stride all the same."""
    events, points = walk()
    t = np.arange(600) / RATE
    for letter, phase in (("L", 0.0), ("R", 0.5)):
        risen = ((t / PERIOD - phase) % 1.0 > 0.45) & ((t / PERIOD - phase) % 1.0 < 0.62)
        points[letter + "HEE"][risen, 0] += 60.0
    for side in ("left", "right"):
        found = averages(strides(events, points, rate=RATE), side)
        assert found["step_length"][0] == pytest.approx(TRUE["step_length"], rel=2e-3)


def test_a_strike_that_nobody_knows_leaves_its_step_open():
    events, points = walk()
    one = strides([e for e in events if e.side == "left"], points, rate=RATE)[0]
    assert np.isnan([one.values[name] for name in ("step_length", "step_width", "step_time")]).all()
    assert one.values["stride_length"] == pytest.approx(TRUE["stride_length"], rel=1e-3)
