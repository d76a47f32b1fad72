"""Laws of the score: what it counts, on tracks whose faults are known."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Tracks
from kinemark.synth.score import score
from support.clouds import numbered, tracks


@pytest.fixture
def paths():
    t = np.arange(60) / 100
    return np.stack([np.stack([300.0 * i + 1000 * t, 0 * t, 0 * t], -1) for i in range(3)])


def test_perfect_tracks_have_a_perfect_score(paths):
    s = score(tracks(paths, numbered(paths)), paths)
    assert (s.recall, s.precision, s.extra_per_frame, s.rmse) == (1, 1, 0, 0)
    assert (s.swaps, s.handovers, list(s.fragments), list(s.best)) == (0, 0, [1, 1, 1], [1, 1, 1])


def test_only_what_was_seen_must_be_found_and_what_was_not_is_no_ghost(paths):
    seen = np.ones(paths.shape[:2], bool)
    seen[1, 20:] = False
    found = tracks(paths, numbered(paths))
    s = score(found, paths, seen=seen)
    assert (s.recall, s.extra_per_frame, s.precision) == (1, 0, 1)
    lost = paths.copy()
    lost[0, :30] = np.nan
    s = score(tracks(lost, numbered(paths)), paths, seen=seen)
    assert s.recall == pytest.approx((seen.sum() - 30) / seen.sum())
    assert s.best[0] == pytest.approx(0.5) and s.best[1] == 1


def test_a_point_far_from_all_is_a_ghost(paths):
    ghost = np.full((1, 60, 3), 5000.0)
    ghost[:, 30:] = np.nan
    everything = np.concatenate([paths, ghost])
    s = score(tracks(everything, numbered(everything)), paths)
    assert s.extra_per_frame == 0.5 and s.precision == pytest.approx(180 / 210) and s.recall == 1


def test_a_track_broken_in_two_is_a_handover_and_no_swap(paths):
    identity = numbered(paths)
    identity[2, 25:] = 7
    s = score(tracks(paths, identity), paths)
    assert (s.swaps, s.handovers, s.fragments[2]) == (0, 1, 2)
    assert s.best[2] == pytest.approx(35 / 60)


def test_two_tracks_that_change_places_are_two_swaps(paths):
    identity = numbered(paths)
    identity[:2, 40:] = identity[:2, 40:][::-1]
    s = score(tracks(paths, identity), paths)
    assert (s.swaps, s.handovers) == (2, 2)


def test_chi2_is_one_where_the_covariance_is_true(paths):
    rng = np.random.default_rng(3)
    long = np.tile(paths, (1, 40, 1))
    off = rng.normal(0, 2.0, long.shape)
    true, bold = (score(tracks(long + off, numbered(long), sd=sd), long) for sd in (2.0, 1.0))
    assert true.chi2 == pytest.approx(1, abs=0.06) and true.coverage == pytest.approx(0.95, abs=0.01)
    assert bold.chi2 == pytest.approx(4, rel=0.06) and bold.coverage < 0.6


def test_points_without_a_covariance_are_left_out_of_what_covariances_say(paths):
    found = tracks(paths + 1.0, numbered(paths))
    silent = found.cloud.cov.copy()
    silent[::2] = np.nan
    s, full = (score(Tracks(replace(found.cloud, cov=c), found.id), paths) for c in (silent, found.cloud.cov))
    assert (s.chi2, s.coverage, s.rmse) == pytest.approx((full.chi2, full.coverage, full.rmse)) and s.chi2 > 0
    none = score(Tracks(replace(found.cloud, cov=np.full_like(silent, np.nan)), found.id), paths)
    assert np.isnan(none.chi2) and np.isnan(none.coverage) and none.recall == 1


def test_what_does_not_fit_is_refused(paths):
    found = tracks(paths, numbered(paths))
    with pytest.raises(ValueError, match="truth has shape"):
        score(found, paths[:, :10])
    with pytest.raises(ValueError, match="seen has shape"):
        score(found, paths, seen=np.ones((3, 10), bool))
