"""The on-line phase follows a motion that repeats, and goes on while nothing is seen of it."""

import numpy as np
import pytest

from kinemark.signal.phase import CycleTemplate
from kinemark.signal.phase_filter import begin_phase, predict_phase, update_phase

CYCLE = 40.0
STEPS = 2 * np.pi * np.arange(100) / 100
TEMPLATE = CycleTemplate(np.stack([np.cos(STEPS), np.sin(STEPS) + 0.3 * np.sin(2 * STEPS)], -1))
SPREAD = np.full(2, 0.03)


@pytest.mark.parametrize("start", [0.0, 0.3, 0.71])
@pytest.mark.parametrize("cadence", [0.9, 1.0, 1.12])
def test_phase_and_cadence_are_found_and_outlive_a_gap(start, cadence):
    phase = start + cadence / CYCLE * np.arange(80)
    state = begin_phase(TEMPLATE(phase[:12]), TEMPLATE, SPREAD, cycle=CYCLE)
    spread = []
    for f in range(12, 80):
        state = predict_phase(state, cycle=CYCLE)
        seen = f < 40 or f >= 60
        y = TEMPLATE(phase[f]) if seen else np.full(2, np.nan)
        state = update_phase(state, y, TEMPLATE, SPREAD, cycle=CYCLE)
        spread.append(state.variance)
        off = (state.phase - phase[f] + 0.5) % 1.0 - 0.5
        assert abs(off) < (0.02 if seen else 0.05)
    assert np.all(np.diff(spread[28:48]) > 0)
    assert spread[-1] < spread[47]
