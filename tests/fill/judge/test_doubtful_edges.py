"""Fills beside suspicious samples: made without what they contradict; tied to others, and less sure."""

import numpy as np
import pytest

from kinemark.fill import Body, Gap, Linear, LocalRegression, fill, judged_fill
from kinemark.fill.edges import GapEdges
from kinemark.fill.fill import judged_together
from kinemark.fill.judge.choice import ChosenFill
from kinemark.fill.judge.contradicted_edges import ContradictedEdge
from kinemark.fill.judge.doubtful_edges import contradicted_mm
from support.filling import moving, trial
from support.walked import clean, spiked, without

GAP = Gap(2, 100, 125)


def filled_beside(wrong_mm, method=None, limit_mm=np.inf):
    """The gap filled where the sample before it is wrong by so much; what is said of it and how wrong it is, mm."""
    motion = moving(300, soft=3.0, noise=0.2)
    xyz = motion.hidden([GAP]).xyz
    xyz[GAP.marker, GAP.start - 1] += wrong_mm / np.sqrt(3)
    done = fill(trial(motion._replace(xyz=xyz)), method=method, limit_mm=limit_mm)
    (found,) = done.gaps
    d = done.trajectories.xyz[GAP.marker, GAP.start : GAP.stop] - motion.xyz[GAP.marker, GAP.start : GAP.stop]
    cov = done.trajectories[found.marker].cov[GAP.start : GAP.stop]
    return found, d, np.sqrt(np.diagonal(cov, axis1=1, axis2=2)), xyz, done


@pytest.mark.parametrize("method", [None, Body()], ids=["auto", "body"])
def test_a_fill_does_not_follow_a_sample_that_it_contradicts(method):
    found, d, sd, xyz, done = filled_beside(60.0, method)
    assert found.suspicious == (GAP.start - 1,) and found.off_mm == pytest.approx(60.0, abs=3.0)
    error = np.linalg.norm(d, axis=1).mean()
    assert error < 1.0 and 1 / 3 < error / found.expected_mm < 3
    assert (np.abs(d) < 2 * sd).mean() > 0.9
    assert_what_was_measured_stays(xyz, done)


def assert_what_was_measured_stays(xyz, done):
    seen = ~np.isnan(xyz)
    assert np.array_equal(done.trajectories.xyz[seen], xyz[seen])


@pytest.mark.parametrize("method", [Linear(), LocalRegression()], ids=["linear", "local_regression"])
def test_a_fill_by_another_method_alone_stays_tied_and_says_so(method):
    found, d, _, xyz, done = filled_beside(60.0, method)
    assert found.suspicious == (GAP.start - 1,) and found.off_mm == 0
    assert found.expected_mm > 0.5 * np.linalg.norm(d, axis=1).mean()
    assert_what_was_measured_stays(xyz, done)


@pytest.mark.parametrize("method", [None, Body()], ids=["auto", "body"])
def test_a_sample_that_may_be_one_of_a_rare_movement_is_followed_and_makes_the_fill_less_sure(method):
    """It stands out by 2.5 mm, six standard deviations of the fill without it; bad ones are mostly farther off."""
    found, d, sd, xyz, done = filled_beside(2.5, method)
    assert found.suspicious == (GAP.start - 1,) and found.off_mm == 0
    good, *_ = filled_beside(0.0, method)
    assert found.expected_mm > good.expected_mm and found.sd_mm > 2 * good.sd_mm and (np.abs(d) < 2 * sd).mean() > 0.9
    assert_what_was_measured_stays(xyz, done)


@pytest.mark.parametrize("method", [None, Body()], ids=["auto", "body"])
def test_a_sample_far_off_does_not_keep_a_gap_open_that_is_filled_without_it(method):
    found, d, _, _, _ = filled_beside(260.0, method, limit_mm=20.0)
    assert found.state == "filled" and found.suspicious == (GAP.start - 1,)
    assert np.linalg.norm(d, axis=1).mean() < 1.0 and found.expected_mm < 1.0


@pytest.mark.parametrize("method", [Linear(), LocalRegression()], ids=["linear", "local_regression"])
def test_a_fill_that_a_sample_far_off_pulls_away_stays_open(method):
    found, d, _, xyz, done = filled_beside(260.0, method, limit_mm=20.0)
    assert found.state == "above_limit" and found.suspicious == (GAP.start - 1,) and np.isnan(d).all()
    assert_what_was_measured_stays(xyz, done)


def test_a_fill_beside_good_samples_is_not_doubted():
    found, d, *_ = filled_beside(0.0)
    assert not found.suspicious and found.expected_mm < 1.0 and np.linalg.norm(d, axis=1).mean() < 1.0


@pytest.mark.parametrize("n", [10, 24])
def test_a_slow_drift_to_the_gap_is_told_by_the_other_markers_and_not_followed(n):
    """Its own motion shows nothing of a millimetre a frame; what is longer than the first look is found by the next."""
    motion = moving(300, soft=3.0, noise=0.2)
    xyz = motion.hidden([GAP]).xyz
    xyz[GAP.marker, GAP.start - n : GAP.start] += np.linspace(0.5, 10.0, n)[:, None] / np.sqrt(3)
    done = fill(trial(motion._replace(xyz=xyz)), limit_mm=np.inf)
    (found,) = done.gaps
    d = done.trajectories.xyz[GAP.marker, GAP.start : GAP.stop] - motion.xyz[GAP.marker, GAP.start : GAP.stop]
    assert len(found.suspicious) >= n / 2 and max(found.suspicious) == GAP.start - 1
    assert np.linalg.norm(d, axis=1).mean() < 1.0 and 8.0 < found.off_mm < 12.0
    assert_what_was_measured_stays(xyz, done)


@pytest.mark.parametrize("mm", [12.0, 35.0])
def test_a_sample_that_spoils_the_tests_of_a_short_trial_is_told_by_the_fill_without_it(mm):
    """With the sample in the trial little is expected to be exact; the fill without it has tests of its own."""
    truth = clean(markers=12).frames(0, 200)
    short = without(spiked(truth, 5, 99, 100, mm=mm), 5, 100, 106)
    done = fill(without(short, 2, 60, 80))
    (found,) = (gap for gap in done.gaps if gap.start == 100)
    error = np.linalg.norm(done.trajectories.xyz[5, 100:106] - truth.xyz[5, 100:106], axis=1).mean()
    assert found.suspicious == (99,) and found.off_mm == pytest.approx(mm, abs=3.0)
    assert error < 1.0 and 1 / 3 < error / found.expected_mm < 3


def test_good_samples_that_seem_to_be_contradicted_stay_what_the_fill_is_tied_to(monkeypatch):
    """The first look has no tests of its length: in real trials it suspected the samples beside one gap in twenty."""
    motion = moving(300, soft=3.0, noise=0.2).hidden([GAP])
    untouched = fill(trial(motion))
    seems = ContradictedEdge((GAP.start - 2, GAP.start - 1), Gap(GAP.marker, GAP.start - 10, GAP.stop + 10))
    monkeypatch.setattr(judged_fill, "contradicted_edges", lambda *_: {GAP: seems})
    again = fill(trial(motion))
    assert again.gaps == untouched.gaps and not again.gaps[0].suspicious
    np.testing.assert_array_equal(again.trajectories.xyz, untouched.trajectories.xyz)


@pytest.mark.parametrize("n", [1, 26])
def test_what_no_other_marker_tells_contradicts_no_sample(n):
    """Of more than 20 gaps `body` has hold-out errors, but is asked only about those that it fills."""
    motion = moving(300, soft=3.0, noise=0.2)
    gaps = [GAP, *(Gap(k % 8, 4 + 10 * k, 6 + 10 * k) for k in range(1, n) if k not in (9, 10, 11, 12))]
    answers = judged_together(motion.hidden(gaps), gaps, (Linear(), Body()))
    again = ChosenFill.of(motion, gaps, 0, answers)
    again = again._replace(prediction=again.prediction._replace(xyz=again.prediction.xyz + 60.0))
    frames, trimmed = range(GAP.start, GAP.stop), motion.hidden(gaps)
    assert contradicted_mm(motion, trimmed, again, frames, 1.0) > 60.0
    alone = trimmed.hidden([Gap(k, 0, 300) for k in range(8) if k != GAP.marker])
    assert np.isfinite(again.found.candidates["body"])
    assert contradicted_mm(motion, alone, again, frames, 1.0) == 0.0


def test_nobody_who_wants_no_check_gets_one():
    motion = moving(300, soft=3.0, noise=0.2)
    xyz = motion.hidden([GAP]).xyz
    xyz[GAP.marker, GAP.start - 10 : GAP.start] += np.linspace(1.0, 10.0, 10)[:, None]
    (found,) = fill(trial(motion._replace(xyz=xyz)), edges=GapEdges(most_trimmed=0)).gaps
    assert not found.suspicious
