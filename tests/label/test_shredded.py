"""A shredded trial has every sample of the trial once, and ghosts; and a score that is told the truth says so."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from labelling_scores import LabelScore, reliability, score_labels
from labelling_shredded import GHOSTS, Change, shredded

from kinemark.data import MarkerTrajectory
from kinemark.label import Labels
from kinemark.synth import walking, with_markers


@cache
def walk():
    trial = with_markers(walking(duration_s=1.0, rate=100.0, seed=1, wobble_mm=1.0), 15, seed=1).trajectories
    xyz = trial.paths[3].xyz.copy()
    xyz[30:45] = np.nan
    return replace(trial, paths=(*trial.paths[:3], MarkerTrajectory.measured(trial.names[3], xyz), *trial.paths[4:]))


def named_as(truth, names, p=1.0):
    """Labels that say so, with this probability where there is a name."""
    n, has = len(names), np.array([name is not None for name in names])
    states = tuple("sure" if one and p >= 0.95 else "unsure" if one else "unknown" for one in has)
    return Labels(tuple(names), p * has, states, (None,) * n, np.where(has, 1.0, np.nan), 1.0, 1.0)


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"pieces": 7},
        {"pieces": 3, "exchanges": 3},
        {"at_gaps": True, "ghosts": 4.0},
        {"exchanges": 1, "returns": 2, "takeovers": 2},
    ],
)
def test_every_sample_is_there_once_under_its_own_name(how):
    parts = shredded(walk(), seed=4, **how)
    back = {name: np.full((100, 3), np.nan) for name in walk().names}
    for t, (path, first) in enumerate(zip(parts.tracks, parts.truth, strict=True)):
        marks = (Change(0, first), *parts.changes.get(t, ()), Change(100, None))
        for (start, name), (stop, _) in pairwise(marks):
            rows = slice(start, stop)
            if name is not None:
                seen = np.isfinite(path.xyz[rows, 0])
                assert np.isnan(back[name][rows][seen]).all()
                back[name][rows][seen] = path.xyz[rows][seen]
    for name in walk().names:
        np.testing.assert_array_equal(back[name], walk()[name].xyz)
    several = [how.get(kind, 0) for kind in ("exchanges", "returns", "takeovers")]
    assert sum(len(one) for one in parts.changes.values()) == np.dot(several, (2, 4, 1))


def test_the_same_seed_gives_the_same_tracks_and_another_others():
    one, same, other = (shredded(walk(), 5, 2.0, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.tracks.xyz, same.tracks.xyz)
    assert one.truth == same.truth != other.truth


@pytest.mark.parametrize("kind", GHOSTS)
def test_ghosts_are_as_many_as_wanted_and_of_their_kind(kind):
    parts = shredded(walk(), 1, 4.0, 2, kinds=(kind,))
    ghosts = np.array([path.xyz for path, name in zip(parts.tracks, parts.truth, strict=True) if name is None])
    assert np.isfinite(ghosts[..., 0]).sum() / 100 == pytest.approx(4.0, rel=0.35)
    for ghost in ghosts:
        rows = np.flatnonzero(np.isfinite(ghost[:, 0]))
        moved = np.ptp(ghost[rows], axis=0).max() if len(rows) > 1 else 0.0
        assert moved == 0 if kind == "reflection" else len(rows) < 2 or moved > 0
        if kind == "midpoint":
            xyz = walk().xyz[:, rows[0]]
            apart = np.linalg.norm(0.5 * (xyz[:, None] + xyz[None]) - ghost[rows[0]], axis=2)
            assert np.nanmin(apart) < 1e-9


def test_absent_markers_are_gone_and_extra_ones_are_no_markers_of_the_trial():
    parts = shredded(walk(), 1, 0.0, 3, absent=4, extra=2)
    assert sum(name in walk().names for name in parts.truth) == 11
    assert {name for name in parts.truth if name not in walk().names} == {"+1", "+2"}


def test_what_stands_still_does_so_all_through_and_a_twin_keeps_beside_a_marker():
    parts = shredded(walk(), 1, 2.0, 3, kinds=("twin",), still=2)
    ghosts = [path.xyz for path, name in zip(parts.tracks, parts.truth, strict=True) if name is None]
    whole = [xyz for xyz in ghosts if np.isfinite(xyz).all()]
    assert len(whole) == 2 and all(np.ptp(xyz, axis=0).max() == 0 for xyz in whole)
    for xyz in ghosts:
        rows = np.isfinite(xyz[:, 0])
        beside = np.ptp((walk().xyz - xyz)[:, rows], axis=1).max(1)
        assert rows.all() or np.nanmin(beside) < 1e-9


def test_too_many_pieces_or_markers_are_refused():
    for wrong in ({"pieces": 0}, {"pieces": 101}, {"ghosts": -1.0}, {"still": -1}, {"absent": 16}, {"exchanges": 8}):
        with pytest.raises(ValueError, match=r"wanted|too few"):
            shredded(walk(), **wrong)


def test_the_truth_scores_one_and_each_kind_of_error_is_counted_where_it_belongs():
    parts = shredded(walk(), 1, 4.0, 5)
    n = np.isfinite(parts.tracks.xyz[..., 0]).sum(1)
    marker = np.array([name is not None for name in parts.truth])
    best = score_labels(named_as(parts, parts.truth), parts, walk().names)
    assert best[:8] == (1, 0, 0, 0, 1, 0, 1, 0)
    unsure = score_labels(named_as(parts, parts.truth, 0.6), parts, walk().names)
    assert unsure[:8] == (0, 0, 1, 0, 1, 0, 0, 0)
    i, j = np.flatnonzero(marker)[:2]
    names = list(parts.truth)
    names[i], names[j] = names[j], names[i]
    wrong = score_labels(named_as(parts, names), parts, walk().names)
    assert wrong.wrong == pytest.approx((n[i] + n[j]) / n[marker].sum()) and wrong.frames == 0
    assert wrong.sure_wrong == pytest.approx(2 / marker.sum())
    ghost = np.flatnonzero(~marker)[0]
    names = [names[i] if t == ghost else None for t in range(len(names))]
    named = score_labels(named_as(parts, names), parts, walk().names)
    assert named.ghosts == pytest.approx(n[ghost] / n[~marker].sum()) and named.unsure == 1


def test_a_track_that_changes_its_marker_is_right_only_where_it_is():
    parts = shredded(walk(), 1, 0.0, 6, exchanges=1)
    first = score_labels(named_as(parts, parts.truth), parts, walk().names)
    after = sum(100 - one.frame for (one,) in parts.changes.values()) / np.isfinite(parts.tracks.xyz[..., 0]).sum()
    assert first.wrong == pytest.approx(after, rel=0.05) and first.sure_wrong == pytest.approx(2 / 15)
    assert 0 < first.frames < 1


def test_reliability_finds_probabilities_that_are_too_high():
    rng = np.random.default_rng(0)
    p = rng.uniform(0, 1, 40_000)
    for bias in (0.0, 0.1):
        good, zeros = rng.uniform(0, 1, len(p)) < p - bias, np.zeros(8)
        bins = reliability([LabelScore(*zeros, p, good, np.ones(len(p), int))])
        off = np.array([one.probability - one.right for one in bins])
        np.testing.assert_allclose(off[1:], bias, atol=0.02)
        assert sum(one.names for one in bins) == len(p)
