"""Names that were taken from a trial come back: shuffled, in pieces, among ghosts; and nothing is guessed."""

from dataclasses import replace

import numpy as np
import pytest
from labelling_shredded import shredded

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories
from kinemark.label import Distances, label, learn_template, named
from kinemark.label.arrange import arranged
from kinemark.label.evidence import Hands, PairScore
from kinemark.label.exchange import Exchanger, best_moves
from kinemark.label.pool import pooled
from kinemark.label.shape import Shapes
from kinemark.label.stretches import stretches_of
from kinemark.label.sweeps import places
from kinemark.synth import arm
from support.subject_walks import template, walk


def shares(tracks, truth, found):
    """Samples with a right name, and with a wrong one, of those that have a marker; samples of ghosts with a name."""
    n = np.isfinite(tracks.xyz[..., 0]).sum(1)
    sure = np.array([state == "sure" for state in found.state])
    right = np.array([a == b is not None for a, b in zip(found.names, truth, strict=True)])
    real = np.array([name is not None for name in truth])
    return n[right & sure].sum() / n[real].sum(), n[~right & sure & real].sum(), n[sure & ~real].sum()


@pytest.mark.parametrize(("n", "pieces", "seed"), [(15, 1, 1), (15, 15, 2), (39, 1, 3), (39, 6, 4)])
def test_another_walk_of_the_subject_is_named(n, pieces, seed):
    tracks, truth, _ = shredded(walk(7, n), pieces, 2.0, seed)
    found = label(tracks, template(n))
    right, wrong, ghosts = shares(tracks, truth, found)
    assert found.refused is None and wrong == 0 and ghosts == 0
    assert right > (0.999 if pieces == 1 else 0.97)


def test_left_is_told_from_right():
    """All distances of a mirror image agree: only quadruples tell, and in it left is right."""
    mirrored = replace(walk(7), paths=tuple(replace(p, xyz=p.xyz * [1, -1, 1]) for p in walk(7)))
    other = {"L": "R", "R": "L"}
    sides = tuple(other[n[0]] + n[1:] if other.get(n[0], "") + n[1:] in walk(7).names else n for n in walk(7).names)
    assert label(walk(7), template()).names == walk(7).names
    assert label(mirrored, template()).names == sides != walk(7).names


def test_the_answer_does_not_hang_on_the_order_of_tracks_or_their_names():
    tracks, _, _ = shredded(walk(7), 4, 2.0, 1)
    turned = Trajectories(tracks.paths[::-1], tracks.rate)
    assert label(tracks, template()).names == label(turned, template()).names[::-1]


def test_a_template_of_something_else_is_refused():
    other = arm().trajectories
    rng = np.random.default_rng(0)
    cloud = rng.normal(0, 400, (15, 1, 3)) + np.cumsum(rng.normal(0, 2, (15, 300, 3)), 1)
    chance = Trajectories(tuple(MarkerTrajectory.measured(f"*{k}", xyz) for k, xyz in enumerate(cloud)), 100.0)
    for trial in (other, chance):
        found = label(trial, template())
        assert found.refused is not None and found.refused.kind == "labels_refused"
        assert set(found.names) == {None} and set(found.state) == {"unknown"}


def test_ghosts_alone_and_single_tracks_do_not_raise():
    one = Trajectories((walk(7).paths[0],), 100.0)
    assert label(one, template()).refused is not None
    with pytest.raises(KinemarkError, match="no tracks"):
        label(Trajectories((), 100.0), template())


def test_a_marker_that_is_absent_stays_absent():
    gone = walk(7).names[4]
    rest = walk(7).select([name for name in walk(7).names if name != gone])
    assert label(rest, template()).names == rest.names


def test_exchanged_markers_are_found_by_moves_of_whole_labels():
    trial, pairs = walk(7, 39), PairScore.of_template(template(39))
    stretches = stretches_of(trial, template(39).size)
    index = np.array([template(39).names.index(name) for name in trial.names])
    d = template(39).distance + np.diag(np.full(39, np.inf))
    a, b = np.unravel_index(d.argmin(), d.shape)
    order = np.arange(39)
    order[[a, b]] = b, a
    y = places(stretches, order[index], 39)
    turn = best_moves(y, Exchanger.of(template(39), pairs), 1.0)
    assert np.array_equal(turn[order], np.arange(39))


def test_names_join_pieces_and_keep_the_others():
    tracks, _, _ = shredded(walk(7), 3, 2.0, 5)
    found = label(tracks, template())
    whole = named(tracks, found)
    taken = {name for name, state in zip(found.names, found.state, strict=True) if state == "sure"}
    assert set(whole.names) >= taken and len(whole.names) == len(set(whole.names))
    assert np.isfinite(whole.xyz[..., 0]).sum() == np.isfinite(tracks.xyz[..., 0]).sum()
    for name in taken:
        rows = np.isfinite(whole[name].xyz[:, 0])
        np.testing.assert_array_equal(whole[name].xyz[rows], walk(7)[name].xyz[rows])
    with pytest.raises(ValueError, match="wanted one each"):
        named(walk(7), found)


def test_probabilities_are_true_of_names_in_pieces():
    """Brier score against the names' own frequency; and those that are wrong have less than those that are right."""
    tracks, truth, _ = shredded(walk(7), 25, 4.0, 9)
    found = label(tracks, template(), method=Distances(least_track_fit=0.0))
    has = np.array([name is not None for name in found.names])
    right = np.array([a == b for a, b in zip(found.names, truth, strict=True)])[has]
    p = found.probability[has]
    assert ((p >= 0) & (p <= 1)).all() and (found.probability[~has] == 0).all()
    assert ((p - right) ** 2).mean() < 0.05
    assert right[p >= 0.95].mean() > 0.98


def test_a_trial_narrows_what_is_doubtful_of_another_subject_and_moves_it_to_the_truth():
    trial = walk(7)
    plain = template().of_another(1.0)
    off = replace(plain, distance=plain.distance * 1.02)
    own = np.array([off.names.index(name) for name in trial.names])
    new = pooled(off, places(stretches_of(trial, off.size), own, len(off)))
    truth = learn_template(trial).distance
    before, after = (np.abs(one.distance - truth)[np.triu_indices(len(off), 1)] for one in (off, new))
    assert np.median(after) < 0.3 * np.median(before)
    assert (new.doubt <= np.hypot(off.doubt, off.spread) + 1e-9).all() and np.any(new.doubt < 0.5 * off.doubt)


def test_places_foretold_from_neighbours_are_those_of_the_markers_and_turn_with_them():
    trial, shapes = walk(7, 39), Shapes.of(template(39))
    index = np.array([template(39).names.index(name) for name in trial.names])
    y = places(stretches_of(trial, template(39).size), index, 39)
    off = np.linalg.norm(shapes.foretold(y) - y, axis=-1)
    assert np.nanmedian(off[:, shapes.known]) < 0.03 * template(39).size
    mirrored = np.linalg.norm(shapes.foretold(y * np.float32([1, -1, 1])) - y * np.float32([1, -1, 1]), axis=-1)
    assert np.nanmedian(mirrored[:, shapes.known]) > 2 * np.nanmedian(off[:, shapes.known])


def test_a_chain_of_names_that_are_one_further_is_put_right():
    """Three neighbours each carry the next one's name, and the last is unnamed: single tracks cannot leave that."""
    trial = walk(7, 39)
    other = template(39).of_another(1.0)
    pairs, stretches = PairScore.of_template(other), stretches_of(trial, other.size)
    truth = np.array([other.names.index(name) for name in trial.names])
    near = np.argsort(other.distance[3] + np.where(np.arange(39) == 3, np.inf, 0))[:2]
    chain = [3, *near.tolist()]
    wrong = truth.copy()
    tracks = [int(np.flatnonzero(truth == a)[0]) for a in chain]
    wrong[tracks[0]], wrong[tracks[1]], wrong[tracks[2]] = chain[1], chain[2], -1
    np.testing.assert_array_equal(arranged(stretches, wrong, other, pairs), truth)


def test_names_that_nothing_changes_are_not_arranged_once_more(monkeypatch):
    asked = []

    def counted(stretches, label, *by):
        asked.append(label.tobytes())
        return arranged(stretches, label, *by)

    monkeypatch.setattr("kinemark.label.solve.arranged", counted)
    found = label(walk(7), template().of_another(1.0))
    assert found.names == walk(7).names and len(asked) == len(set(asked)) > 0


def test_ghosts_do_not_take_the_name_of_an_absent_marker():
    gone = walk(7).names[4]
    rest = walk(7).select([name for name in walk(7).names if name != gone])
    for seed in (1, 2, 3):
        tracks, truth, _ = shredded(rest, 1, 3.0, seed)
        found = label(tracks, template())
        taken = {n for n, t, s in zip(found.names, truth, found.state, strict=True) if t is None and s == "sure"}
        assert not taken


def test_quadruples_seen_from_their_members_agree_with_the_quadruples():
    rng = np.random.default_rng(1)
    y = rng.normal(size=(8, 3)).astype(np.float32)
    handed = np.array([[0, 1, 2, 3], [1, 2, 4, 5], [0, 3, 6, 7]])
    a = y[handed[:, 0]]
    sign = np.sign(((y[handed[:, 1]] - a) * np.cross(y[handed[:, 2]] - a, y[handed[:, 3]] - a)).sum(-1)).astype(int)
    right, wrong = Hands.of(handed, sign), Hands.of(handed, -sign)
    own = np.arange(8)
    assert not right.of_points(y, y)[own, own].any() and right.total(y) == 0
    np.testing.assert_array_equal(wrong.of_points(y, y)[own, own], -4.0 * np.bincount(handed.ravel(), minlength=8))
    assert wrong.total(y) == -12
