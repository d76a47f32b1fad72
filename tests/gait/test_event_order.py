"""Events of a foot that contradict each other are not kept together."""

import numpy as np
import pytest

from kinemark.data.strides import FootEvent
from kinemark.gait.event_order import ordered

STANCE = 0.62


def steps(stride=1.1, n=5, side="left", start=0.3):
    return [
        FootEvent(side, strike, start + k * stride + (0 if strike else STANCE * stride), 0.01, "markers")
        for k in range(n)
        for strike in (True, False)
    ]


@pytest.mark.parametrize("stride", [0.6, 1.1, 2.4])
def test_a_false_event_goes_and_the_others_stay(stride):
    rng = np.random.default_rng(3)
    true = steps(stride)
    for _ in range(60):
        at, strike = rng.uniform(0.0, 6 * stride), bool(rng.integers(2))
        near = min(abs(e.time - at) for e in true if e.strike == strike)
        if near < 0.1 * stride:
            continue  # nearly the true one
        found = ordered([*true, FootEvent("left", strike, at, 0.01, "markers")])
        lost = [e for e in true if e not in found]
        assert len(lost) <= 1 and len(found) >= len(true)
        if true[1].time < at < true[-2].time:
            assert not lost, (at, strike)


def test_missed_events_and_the_other_foot_do_no_harm():
    kept = [e for k, e in enumerate(steps()) if k not in (3, 6)]
    other = steps(side="right", start=0.85)
    assert ordered([*kept, *other]) == tuple(sorted([*kept, *other], key=lambda e: e.time))
    assert ordered([]) == () and ordered(steps(n=1)[:1]) == tuple(steps(n=1)[:1])


def test_an_event_from_a_plate_stays():
    true = steps()
    plate = FootEvent("left", True, true[4].time + 0.2, 0.001, "plate")
    found = ordered([*true, plate])
    assert plate in found and true[4] not in found


def test_a_limp_is_kept():
    times = np.cumsum([0.3, 0.5, 0.9, 0.55, 0.8, 0.7, 0.95, 0.6])
    limp = [FootEvent("left", k % 2 == 0, float(t), 0.01, "markers") for k, t in enumerate(times)]
    assert len(ordered(limp)) == len(limp)
