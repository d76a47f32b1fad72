"""Gaps asked for one by one are filled as the trial is, and are told at once by quick methods."""

import numpy as np
import pytest

from kinemark.fill import Auto, Linear, fill, prepare
from support.filling import moving, trial
from support.walked import clean, spiked, without


def test_the_only_gap_of_a_trial_is_filled_as_fill_does():
    hidden = without(clean(), 5, 150, 171)
    marker, methods = hidden.names[5], Auto(candidates=("linear", "cubic", "rigid_body", "pca"))
    best, filled = prepare(hidden, method=methods).best(marker, 160), fill(hidden, method=methods)
    gap = filled.gaps[0]
    assert best.first == 151 and len(best.xyz) == 21 and best.gap.candidates == gap.candidates
    assert best.method == gap.method and best.expected_mm == gap.expected_mm
    assert np.array_equal(best.xyz, filled.trajectories[marker].xyz[150:171])
    assert np.array_equal(best.cov, filled.trajectories[marker].cov[150:171])


def test_samples_in_doubt_beside_a_gap_count_one_by_one_as_for_the_trial():
    """Else the page promises a tenth of the error that a run says of the same gap."""
    whole = clean()
    hidden = without(spiked(whole, 5, 149, 150, mm=35.0), 5, 150, 171)
    marker, methods = hidden.names[5], Auto(candidates=("linear", "cubic", "rigid_body", "pca"))
    prepared, gap = prepare(hidden, method=methods), fill(hidden, method=methods, limit_mm=np.inf).gaps[0]
    best, (among,) = prepared.best(marker, 160), prepared.all_best()
    off = np.linalg.norm(best.xyz - whole.paths[5].xyz[150:171], axis=1).mean()
    assert gap.suspicious == (149,) and gap.expected_mm > max(0.5 * off, gap.candidates[gap.method])
    for one in (best, among):
        assert (one.gap.suspicious, one.expected_mm) == (gap.suspicious, gap.expected_mm)
    for one in prepared.candidates(marker, 160):
        off = np.linalg.norm(one.xyz - whole.paths[5].xyz[150:171], axis=1).mean()
        assert one.gap.suspicious == (149,) and one.expected_mm > 0.3 * off


def test_candidates_come_in_the_order_of_their_expected_errors_which_the_true_ones_follow():
    whole = clean()
    prepared = prepare(without(whole, 5, 150, 190))
    found = prepared.candidates(whole.names[5], 151)
    expected = [one.expected_mm for one in found]
    off = {one.method: np.linalg.norm(one.xyz - whole.paths[5].xyz[150:190], axis=1).mean() for one in found}
    assert expected == sorted(expected) and len({one.method for one in found}) == len(found) == 4
    assert off[found[0].method] < off[found[-1].method] and found[0].sd.shape == (40, 3)
    assert prepared.candidates(whole.names[5], 180)[0].gap is not None, "any frame of the gap names it"


def test_all_gaps_are_filled_together_as_fill_does():
    """One by one the gaps of a recording took a hundred times as long."""
    hidden = clean().frames(0, 250)
    for k, (first, stop) in enumerate([(60, 70), (60, 70), (100, 130), (200, 203)]):
        hidden = without(hidden, k, first, stop)
    methods = Auto(candidates=("linear", "cubic", "rigid_body"))
    found, filled = prepare(hidden, method=methods).all_best(), fill(hidden, method=methods, limit_mm=np.inf)
    assert [(one.gap.marker, one.first, len(one.xyz)) for one in found] == [
        (hidden.names[k], first + 1, n) for k, (first, n) in enumerate([(60, 10), (60, 10), (100, 30), (200, 3)])
    ]
    for one, gap in zip(found, filled.gaps, strict=True):
        assert (one.method, one.expected_mm) == (gap.method, gap.expected_mm)
        assert np.array_equal(one.xyz, filled.trajectories[gap.marker].xyz[gap.start : gap.stop])
    away = prepare(hidden, method=methods).all_best([hidden.names[2]])
    assert [one.gap.marker for one in away] == [hidden.names[k] for k in (0, 1, 3)]


def test_other_gaps_do_not_change_an_answer_and_unknown_ones_are_refused():
    motion = trial(moving())
    one = without(motion, 0, 40, 60)
    with_other = without(one, 5, 200, 204)
    a, b = (prepare(t).candidates("M0", 45, methods=(Linear(),))[0] for t in (one, with_other))
    assert np.array_equal(a.xyz, b.xyz)
    with pytest.raises(KeyError, match="M0 has no gap at frame 100"):
        prepare(one).best("M0", 100)
