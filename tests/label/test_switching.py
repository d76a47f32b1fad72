"""Tracks that go over from one marker to another are found, cut at the frame, and named; whole ones are left alone."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from labelling_scores import cut_truth, score_labels, score_switches
from labelling_shredded import shredded

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import Distances, label, label_switching, learn_template
from kinemark.label.breaks import find_breaks
from kinemark.label.cutting import cut
from kinemark.label.switches import best_sequence
from kinemark.synth import walking, with_markers


@cache
def walk(seed, n=39):
    return with_markers(walking(duration_s=3.0, rate=100.0, seed=seed, wobble_mm=1.0), n, seed=1).trajectories


@cache
def template(n=39):
    return learn_template(walk(1, n))


@pytest.mark.parametrize(("kind", "seed"), [("exchanges", 4), ("returns", 5), ("takeovers", 6)])
def test_tracks_that_go_over_to_another_marker_are_cut_there_and_named(kind, seed):
    parts = shredded(walk(7), 1, 2.0, seed, **{kind: 2})
    found = label_switching(parts.tracks, template())
    assert score_switches(found, parts)[::2] == (sum(map(len, parts.changes.values())), 0)
    before = score_labels(label(parts.tracks, template()), parts, template().names)
    after = score_labels(found.labels, cut_truth(found, parts), template().names)
    assert after.right > 0.99 > before.right and after.wrong < 0.002
    for one in found.switches:
        names = [m for _, m in parts.changes[one.track]]
        assert {one.before, one.after} <= {parts.truth[one.track], *names}


@pytest.mark.parametrize("at", [80, 220])  # most of the track is none, or most is the marker
@pytest.mark.parametrize("again", [-8, 12])  # the marker's own track begins so many frames later
@pytest.mark.parametrize("backwards", [False, True])
def test_a_track_that_is_a_marker_in_a_part_alone_is_cut_where_its_own_begins(at, again, backwards):
    trial = walk(7)
    a, b = trial.names.index("LKNE"), trial.names.index("LTHI")
    xyz, frame = trial.xyz.copy(), np.arange(trial.n_frames)
    xyz[a, at:] = (0.4 * xyz[a] + 0.6 * xyz[b])[at:]  # merged
    xyz = np.concatenate([xyz, np.where(frame[:, None] >= at + again, trial.xyz[a], np.nan)[None]])
    stray = Trajectories(
        tuple(MarkerTrajectory.measured(f"*{k}", one[::-1] if backwards else one) for k, one in enumerate(xyz)),
        trial.rate,
    )
    found = label_switching(stray, template())
    own = [k for k, name in enumerate(found.labels.names) if name == "LKNE"]
    assert {found.of[k] for k in own} == {a, len(trial)} and {found.labels.state[k] for k in own} == {"sure"}
    part = found.tracks.xyz[next(k for k in own if found.of[k] == a), :, 0]
    assert min(at, at + again) - 7 <= np.isfinite(part).sum() <= at + 7  # a step of frames that are looked at
    assert found.switches == ()


@pytest.mark.parametrize("seed", [4, 5, 6])
def test_where_few_distances_are_known_well_motion_says_where_tracks_go_over(seed):
    loose = learn_template(walk(1, 15), relative_spread=0.14)
    parts = shredded(walk(7, 15), 1, 2.0, seed, exchanges=1, returns=1, takeovers=1)
    found = label_switching(parts.tracks, loose)
    after = score_labels(found.labels, cut_truth(found, parts), loose.names)
    assert score_switches(found, parts)[::2] == (sum(map(len, parts.changes.values())), 0)
    assert after.wrong == 0


def test_tracks_break_where_another_goes_on_and_not_at_bad_samples():
    trial = walk(7)
    every = np.arange(len(trial))
    assert find_breaks(trial, 1700.0, every) == set()
    a, b = trial.names.index("LKNE"), trial.names.index("LTHI")
    xyz = trial.xyz.copy()
    xyz[3, 80] += 60.0  # one bad sample
    xyz[4, 90:] += [0.0, 0.0, 60.0]  # a marker that slips
    xyz[[a, b], 150:] = xyz[[b, a], 150:]
    crossed = replace(trial, paths=tuple(MarkerTrajectory.measured(*one) for one in zip(trial.names, xyz, strict=True)))
    assert find_breaks(crossed, 1700.0, every) == {(a, 150), (b, 150)}
    assert find_breaks(crossed, 1700.0, np.setdiff1d(every, [a])) == set()  # where that one was stated to be whole


@pytest.mark.parametrize(("sure", "begins"), [(0.97, [0, 60]), (0.99, [0])])
def test_an_unsure_track_is_cut_where_it_steps_aside_if_a_part_of_it_is_sure_then(sure, begins):
    """Beside ten nameless markers: a knee's track that goes on 25 mm off, as where images become one, until its own
    begins anew. As a whole it is the knee at 0.955."""
    trial, frame = walk(7, 15), np.arange(300)
    knee, shank = (trial.xyz[trial.names.index(name)] for name in ("LKNE", "LTIB"))
    aside = 25.0 * (shank - knee) / np.linalg.norm(shank - knee, axis=1)[:, None]
    first = np.where((frame < 100)[:, None], knee, np.nan) + (frame >= 60)[:, None] * aside
    parts = shredded(trial, extra=10, seed=7)
    more = [path for path, name in zip(parts.tracks, parts.truth, strict=True) if name not in trial.names]
    paths = [*trial.paths, MarkerTrajectory.measured("aside", first), *more]
    paths[trial.names.index("LKNE")] = trial.paths[trial.names.index("LKNE")].only(frame >= 100)
    tracks = replace(trial, paths=tuple(replace(path, name=f"*{k}") for k, path in enumerate(paths)))
    found = label_switching(tracks, template(15), method=Distances(sure=sure))
    own = np.flatnonzero(found.of == 15)
    assert [int(np.isfinite(found.tracks.xyz[k, :, 0]).argmax()) for k in own] == begins
    assert (found.labels.state[own[0]] == "sure") == (len(begins) == 2)
    assert found.labels.names[own[0]] == "LKNE" and found.switches == ()


@pytest.mark.parametrize(("pieces", "seed"), [(1, 1), (6, 2)])
def test_tracks_of_one_marker_are_not_cut(pieces, seed):
    parts = shredded(walk(7), pieces, 3.0, seed, kinds=("walk", "midpoint", "reflection"))
    found = label_switching(parts.tracks, template())
    assert found.switches == () and found.tracks is parts.tracks
    assert found.labels.names == label(parts.tracks, template()).names


def test_where_no_cut_stays_nothing_is_named_a_second_time(monkeypatch):
    named = []
    monkeypatch.setattr("kinemark.label.switching.label", lambda *a, **more: named.append(1) or label(*a, **more))
    monkeypatch.setattr("kinemark.label.switching._turns", lambda *_: [(3, 150, False)])  # a marker's whole track
    assert label_switching(walk(7), template()).switches == ()
    assert len(named) == 2  # whole and cut


def test_a_track_of_which_a_name_was_stated_is_not_cut():
    parts = shredded(walk(7), 1, 0.0, 4, exchanges=1)
    stated = parts.tracks.names[min(parts.changes)]
    found = label_switching(parts.tracks, template(), stated={stated: "LKNE"})
    assert stated in found.tracks.names and found.labels.names[found.tracks.names.index(stated)] == "LKNE"


def test_pieces_have_every_sample_once_with_all_that_is_known_of_it():
    trial = walk(7)
    pieces, of = cut(trial, {(2, 100), (2, 200), (5, 0)})
    assert pieces.names[2:5] == tuple(f"{trial.names[2]} ({k})" for k in (1, 2, 3)) and len(pieces) == len(trial) + 2
    own = [piece for piece, t in zip(pieces, of, strict=True) if t == 2]
    np.testing.assert_array_equal(np.nansum([piece.xyz for piece in own], axis=0), trial.paths[2].xyz)
    assert [int(np.isfinite(piece.xyz[:, 0]).sum()) for piece in own] == [100, 100, 100]


def test_a_sequence_changes_where_it_gains_more_than_it_costs():
    nats = np.where(np.arange(20)[:, None] < 12, [3.0, 0.0, 1.0], [0.0, 3.0, 1.0])
    assert best_sequence(nats, 20.0).tolist() == [0] * 12 + [1] * 8
    assert best_sequence(nats, 30.0).tolist() == [0] * 20
