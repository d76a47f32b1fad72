"""Tracks exchanged while nobody saw them are told by their neighbours; where nothing tells, no name stays sure."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from labelling_scores import cut_truth, score_labels, score_switches
from labelling_shredded import shredded

from kinemark.data import MarkerTrajectory
from kinemark.label import CutLabels, Labels, label_switching, learn_template
from kinemark.label.beside_gaps import Beside, Parts
from kinemark.label.cutting import cut
from kinemark.label.hidden import find_hidden
from kinemark.label.switching import _kept
from kinemark.synth import walking, with_markers

SIZE = 1700.0


@cache
def walk(seed, n=39):
    return with_markers(walking(duration_s=3.0, rate=100.0, seed=seed, wobble_mm=1.0), n, seed=1).trajectories


def tracks(xyz, trial):
    return replace(trial, paths=tuple(MarkerTrajectory.measured(*one) for one in zip(trial.names, xyz, strict=True)))


def exchanged(trial, one, other, first, stop):
    """The trial with two markers hidden in these frames, and exchanged from there on."""
    a, b = trial.names.index(one), trial.names.index(other)
    xyz = trial.xyz.copy()
    xyz[[a, b], stop:] = xyz[[b, a], stop:]
    xyz[[a, b], first:stop] = np.nan
    return tracks(xyz, trial), {(a, stop), (b, stop)}


@pytest.mark.parametrize("kind", ["exchanges", "returns", "takeovers"])
@pytest.mark.parametrize(("frames", "seed"), [(10, 4), (20, 5), (40, 6)])
def test_tracks_that_went_over_to_another_marker_unseen_are_cut_there_and_named(kind, frames, seed):
    parts = shredded(walk(7, 15), 1, 2.0, seed, hidden=frames, **{kind: 1})
    loose = learn_template(walk(1, 15), relative_spread=0.14)
    found = label_switching(parts.tracks, loose)
    after = score_labels(found.labels, cut_truth(found, parts), loose.names)
    assert score_switches(found, parts)[::2] == (sum(map(len, parts.changes.values())), 0)
    assert after.best_right > 0.99 and after.wrong == 0


@pytest.mark.parametrize("hidden", [3, 10, 50, 100])
def test_an_exchange_is_told_and_its_absence_as_well(hidden):
    trial = walk(7)
    every = np.arange(len(trial))
    gone, where = exchanged(trial, "LKNE", "LTHI", 120, 120 + hidden)
    assert find_hidden(gone, SIZE, every) == (where, set())
    again = tracks(np.where(np.isfinite(gone.xyz), trial.xyz, np.nan), trial)
    assert find_hidden(again, SIZE, every) == (set(), set())


def test_tracks_of_which_a_name_was_stated_are_left_alone():
    gone, where = exchanged(walk(7), "LKNE", "LTHI", 120, 140)
    stated, other = sorted(where)
    free = np.setdiff1d(np.arange(len(gone)), [stated[0]])
    assert find_hidden(gone, SIZE, free).changed == {other}


def test_what_nobody_saw_and_no_neighbour_tells_is_open():
    trial = walk(7)
    a, b = (trial.names.index(name) for name in ("LKNE", "LTHI"))
    xyz = trial.xyz.copy()
    xyz[[a, b], 100:150] = np.nan
    others = np.setdiff1d(np.arange(len(trial)), [a, b])
    xyz[others, :160] = np.nan  # nobody is seen on both sides
    assert find_hidden(tracks(xyz, trial), SIZE, np.arange(len(trial))) == (set(), {(a, 150), (b, 150)})


def test_cuts_that_are_open_stay_unless_both_sides_are_sure_or_nobody():
    trial = walk(7)
    xyz = trial.xyz[:4].copy()
    xyz[:, 140:150] = np.nan
    pieces, of = cut(tracks(xyz, trial.select(trial.names[:4])), {(t, 150) for t in range(4)})
    names = ("a", "a", "b", "b", "c", "c", None, None)
    state = ("sure", "sure", "sure", "unsure", "unsure", "unsure", "unknown", "unknown")
    p = np.array([{"sure": 1.0, "unsure": 0.9, "unknown": 0.0}[one] for one in state])
    labels = Labels(names, p, state, (None,) * 8, np.where(p > 0, p, np.nan), 1.0, 1.0)
    open_ = {(t, 150) for t in range(4)}
    assert _kept(CutLabels(pieces, labels, of, ()), open_, set(), open_) == {(1, 150), (2, 150)}
    assert _kept(CutLabels(pieces, labels, of, ()), open_, open_, set()) == set()


def test_gaps_that_do_not_meet_are_no_exchange():
    trial = walk(7)
    xyz = trial.xyz.copy()
    for k in range(len(trial)):
        xyz[k, 5 + 7 * k : 11 + 7 * k] = np.nan
    assert find_hidden(tracks(xyz, trial), SIZE, np.arange(len(trial))) == (set(), set())


def test_windows_reach_over_gaps_that_are_shut_and_not_over_open_ones():
    trial = walk(7)
    xyz = trial.xyz.copy()
    xyz[0, 100:110] = xyz[0, 150:160] = np.nan
    parts = Parts.of(xyz, 100.0, SIZE)
    assert [(int(a), int(b)) for a, b in zip(parts.first[:3], parts.last[:3], strict=True)] == [
        (0, 99),
        (110, 149),
        (160, 299),
    ]
    open_ = Beside.of(xyz, parts, [1])
    assert (open_.first[:3].tolist(), open_.last[:3].tolist()) == ([0, 0, 160], [149, 149, 299])


def test_no_tracks_and_tracks_without_samples_have_no_gaps():
    trial = walk(7)
    empty = tracks(np.full_like(trial.xyz, np.nan), trial)
    assert find_hidden(empty, SIZE, np.arange(len(trial))) == (set(), set())
    assert find_hidden(replace(trial, paths=()), SIZE, np.arange(0)) == (set(), set())


def test_a_change_is_where_the_track_is_seen_again():
    parts = shredded(walk(7), 6, 0.0, 3, exchanges=2, takeovers=1, hidden=30)
    for t, changes in parts.changes.items():
        seen = np.isfinite(parts.tracks.paths[t].xyz[:, 0])
        for change in changes:
            assert seen[change.frame] and not seen[change.frame - 1] and seen[: change.frame].any()
