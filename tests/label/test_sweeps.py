"""Sweeps, in which all tracks take their names anew."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import learn_template
from kinemark.label.evidence import PairScore
from kinemark.label.stretches import stretches_of
from kinemark.label.sweeps import sweep
from kinemark.synth import walking


@pytest.fixture(scope="module")
def beside_a_gap():
    """Stretches, right labels (T, −1 of the ghost), pairs: a ghost in a gap of LTHI is still there when LTHI is back.

    Two others end before that, so that most tracks are seen in the gap.
    """
    template = learn_template(walking(duration_s=2.0, rate=50.0, seed=1, wobble_mm=8.0).trajectories)
    walk = walking(duration_s=2.0, rate=50.0, seed=2, wobble_mm=1.0).trajectories
    parts = [
        (path.xyz, 40 if path.name == "LTHI" else 0, 38 if path.name in ("RTHI", "RTOE") else 100, path.name)
        for path in walk
    ]
    own = next(path.xyz for path in walk if path.name == "LTHI")
    parts.append((own + np.array([0.0, 12.0, 6.0]), 20, 46, None))
    paths = []
    for xyz, first, stop, _ in parts:
        seen = np.full_like(xyz, np.nan)
        seen[first:stop] = xyz[first:stop]
        paths.append(MarkerTrajectory.measured(f"*{len(paths)}", seen))
    stretches = stretches_of(Trajectories(tuple(paths), walk.rate), template.size)
    truth = [template.names.index(name) if name else -1 for *_, name in parts]
    return stretches, np.array(truth), PairScore.of_template(template)


def test_what_scores_more_takes_the_name_of_a_ghost_that_had_begun(beside_a_gap):
    stretches, truth, pairs = beside_a_gap
    rest = np.where(stretches.start == 0, truth, -1)
    marker, ghost = np.flatnonzero(stretches.start > 0)
    before = sweep(stretches, rest, pairs, 0.3)
    assert (before[marker], before[ghost]) == (-1, truth[marker])  # what a frame in the gap leads to
    assert sweep(stretches, rest, pairs, 0.3, take_over=True).tolist() == truth.tolist()


def test_what_was_stated_is_taken_over_by_none(beside_a_gap):
    stretches, truth, pairs = beside_a_gap
    marker, ghost = np.flatnonzero(stretches.start > 0)
    fixed = stretches.fixed.copy()
    fixed[ghost] = truth[marker]
    stated = replace(stretches, fixed=fixed)
    found = sweep(stated, np.where(fixed >= 0, fixed, truth), pairs, 0.3, take_over=True)
    assert (found[marker], found[ghost]) == (-1, truth[marker])
