"""What other paths show in one moment tells of a problem, and what many do at once is motion."""

import numpy as np
import pytest

from kinemark.edit.probable_errors import Moment, in_trial
from kinemark.edit.probable_errors.at_once import ONCE, at_once
from kinemark.edit.probable_errors.probability import COEFFICIENTS
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.problems import problems
from support.walked import clean, spiked


def moments(frames):
    """Each of a path of its own."""
    return [Moment(float(frame), frozenset({path})) for path, frame in enumerate(frames)]


def test_it_is_what_the_definition_says_of_all_pairs():
    rng = np.random.default_rng(7)
    wrong, frames, paths = rng.random(60), rng.integers(0, 40, 60) / 2, rng.integers(0, 9, (60, 2))
    some = [Moment(float(f), frozenset(map(int, own))) for f, own in zip(frames, paths, strict=True)]
    for a, value in zip(some, at_once(wrong, some), strict=True):
        others = [
            w for w, b in zip(wrong, some, strict=True) if abs(a.frame - b.frame) <= ONCE and not a.paths & b.paths
        ]
        assert value == pytest.approx(max(others, default=0.0) / (1 + sum(1 - w for w in others)))


def test_two_that_leave_their_ways_at_once_are_likelier_than_at_different_times():
    wrong = np.array([0.4, 0.7])
    apart, together = (in_trial(wrong, 100.0, moments(frames)) for frames in ((100, 150), (100, 101)))
    assert (together > apart).all() and together[0] - apart[0] > 0.1
    np.testing.assert_allclose(in_trial(wrong, 100.0), apart)


def test_what_many_show_at_once_is_motion():
    """A foot that strikes the floor."""
    wrong, rest = np.full(12, 0.4), np.arange(12) * 50
    apart, together = (in_trial(wrong, 100.0, moments(frames)) for frames in (rest, 0 * rest))
    assert (together - apart).max() < 0.02


def test_an_exchange_is_no_evidence_of_itself():
    """The path and its partner show the same."""
    both = [Moment(100.0, frozenset({1, 2})), Moment(100.0, frozenset({2})), Moment(100.0, frozenset({3}))]
    np.testing.assert_allclose(at_once(np.array([1.0, 1.0, 0.0]), both)[:2], 0.0)


def test_more_evidence_of_others_makes_nothing_less_likely():
    assert COEFFICIENTS["in_trial"][3] > 0
    some = moments([5, 5, 6, 7])
    told = [at_once(np.array([0.2, w, 0.4, 0.1]), some)[0] for w in np.linspace(0, 1, 21)]
    assert (np.diff(told) >= 0).all()


def test_the_list_counts_two_markers_that_jump_in_one_frame_as_likelier(tmp_path):
    one = spiked(clean(), 6, 160, 161, mm=10.0)

    def said(name, frame):
        trial = spiked(one, 15, frame, frame + 1, mm=60.0)
        found = problems(Editing(name, Journal.of(tmp_path, name), trial, by="EG"), one_by_one=True).items
        return max((p.wrong for p in found if trial.names[6] in p.tracks and p.first <= 161 <= p.last), default=0.0)

    assert said("at_once", 160) > said("apart", 230) + 0.1
