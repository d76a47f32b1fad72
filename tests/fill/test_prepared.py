"""Gaps asked for one by one are filled as the trial is, and are told at once by quick methods."""

import numpy as np
import pytest

from kinemark.fill import Auto, Linear, fill, prepare
from support.filling import moving, trial
from support.walked import clean, without


def test_the_only_gap_of_a_trial_is_filled_as_fill_does():
    hidden = without(clean(), 5, 150, 171)
    marker, methods = hidden.names[5], Auto(candidates=("linear", "cubic", "rigid_body", "pca"))
    best, filled = prepare(hidden, method=methods).best(marker, 160), fill(hidden, method=methods)
    gap = filled.gaps[0]
    assert best.first == 151 and len(best.xyz) == 21 and best.gap.candidates == gap.candidates
    assert best.method == gap.method and best.expected_mm == gap.expected_mm
    assert np.array_equal(best.xyz, filled.trajectories[marker].xyz[150:171])
    assert np.array_equal(best.cov, filled.trajectories[marker].cov[150:171])


def test_candidates_come_in_the_order_of_their_expected_errors_which_the_true_ones_follow():
    whole = clean()
    prepared = prepare(without(whole, 5, 150, 190))
    found = prepared.candidates(whole.names[5], 151)
    expected = [one.expected_mm for one in found]
    off = {one.method: np.linalg.norm(one.xyz - whole.paths[5].xyz[150:190], axis=1).mean() for one in found}
    assert expected == sorted(expected) and len({one.method for one in found}) == len(found) == 4
    assert off[found[0].method] < off[found[-1].method] and found[0].sd.shape == (40, 3)
    assert prepared.candidates(whole.names[5], 180)[0].gap is not None, "any frame of the gap names it"


def test_gaps_of_most_markers_in_the_same_frames_are_judged_once(monkeypatch):
    """One by one they took a hundred times as long, and nothing tells them apart."""
    from kinemark.fill import prepared as module

    whole, asked = clean().frames(0, 250), []
    hidden = whole
    for k in range(len(whole)):
        hidden = without(hidden, k, 150, 155)
    real = module.evaluate_candidates

    def evaluate(motion, gaps, *rest, **kinds):
        asked.append(len(gaps))
        return real(motion, gaps, *rest, **kinds)

    monkeypatch.setattr(module, "evaluate_candidates", evaluate)
    methods = Auto(candidates=("linear", "cubic"))
    one, filled = prepare(hidden, method=methods), fill(hidden, method=methods)
    for name in whole.names:
        best = one.best(name, 152)
        assert np.array_equal(best.xyz, filled.trajectories[name].xyz[150:155]) and best.gap.marker == name
    assert asked == [len(whole)]


def test_other_gaps_do_not_change_an_answer_and_unknown_ones_are_refused():
    motion = trial(moving())
    one = without(motion, 0, 40, 60)
    with_other = without(one, 5, 200, 204)
    a, b = (prepare(t).candidates("M0", 45, methods=(Linear(),))[0] for t in (one, with_other))
    assert np.array_equal(a.xyz, b.xyz)
    with pytest.raises(KeyError, match="M0 has no gap at frame 100"):
        prepare(one).best("M0", 100)
