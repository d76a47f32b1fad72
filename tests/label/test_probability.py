"""What is said of a name: how likely, by what, what else, and whether left and right can be told at all."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from labelling_shredded import Shredded, shredded

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import Distances, label, learn_template
from kinemark.label.calibration import UNKNOWN, Cases, calibrated_shift, cases_of, shift_of
from kinemark.label.decided_sides import _mirrored_world, decided_sides
from kinemark.label.distances import probability_of_all
from kinemark.label.evidence import PairScore
from kinemark.label.margin import (
    BETA_OTHER,
    BETA_TRACK,
    GAINED_OTHER,
    Margins,
    _second,
    label_probability,
    logistic,
    margins,
    probability,
    track_probability,
)
from kinemark.label.recalibration import OTHER, OWN, by_what_is_absent, recalibrated
from kinemark.label.side_pairs import mirrored
from kinemark.label.stretches import stretches_of
from kinemark.synth import walking
from support.subject_walks import template, walk


def known(trial, by):
    """Stretches, pairs, and the true labels."""
    true = np.array([by.names.index(name) for name in trial.names])
    return stretches_of(trial, by.size), PairScore.of_template(by), true


def flat(seed):
    """A body of eight markers that is its own mirror image, moving in space."""
    rng, t = np.random.default_rng(seed), np.linspace(0, 3, 150)
    y, z = np.array([300.0, 200, 150, 120]), np.array([1400.0, 1000, 500, 100])
    body = np.concatenate([np.stack([0 * y, s * y, z], 1) for s in (-1, 1)])
    angle = 0.5 * np.sin(t)
    turn = np.stack([np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)], 1).reshape(-1, 2, 2)
    xyz = np.broadcast_to(body[:, None], (8, 150, 3)).copy()
    xyz[..., :2] = np.einsum("tij,mtj->mti", turn, xyz[..., :2])
    xyz[..., 0] += 1000 * t
    names = [side + name for side in "LR" for name in ("SHO", "ASI", "KNE", "ANK")]
    noise = rng.normal(0, 1.0, xyz.shape)
    return Trajectories(tuple(MarkerTrajectory.measured(n, x) for n, x in zip(names, xyz + noise, strict=True)), 50.0)


def test_a_symmetric_body_is_named_but_its_sides_are_asked_for():
    found = label(flat(2), learn_template(flat(1)))
    assert found.refused is None and found.undecided.kind == "sides_undecided"
    assert set(found.undecided.markers) == set(flat(1).names)
    assert max(found.probability) <= 0.5 and set(found.state) == {"unsure"}
    assert [name[1:] for name in found.names] == [name[1:] for name in flat(2).names]


def test_a_whole_subject_with_its_sides_exchanged_is_turned():
    stretches, pairs, true = known(walk(7), template())
    other = mirrored(template().names)
    assert (other[other] == np.arange(15)).all() and (other != np.arange(15)).sum() == 14
    for given in (true, other[true]):
        sides = decided_sides(stretches, given, template(), pairs)
        np.testing.assert_array_equal(sides.label, true)
        assert sides.finding is None and not sides.undecided.any()


@pytest.mark.parametrize(
    ("name", "other"),
    [("LASI", "RASI"), ("Male:RFWT", "Male:LFWT"), ("L_IAS", "R_IAS"), ("R.Heel", "L.Heel"), ("ASISr", "ASISl")],
)
def test_the_other_side_of_a_name_is_found(name, other):
    names = ("CLAV", name, "SACR", other)
    assert mirrored(names).tolist() == [0, 3, 2, 1]
    assert mirrored(names[:3]).tolist() == [0, 1, 2]


def test_the_shift_is_the_most_probable_and_shrinks_to_none_without_cases():
    logit = np.full(400, 3.0)
    for share in (0.7, 0.95, 1.0):
        right = np.arange(400) < 400 * share
        shift = shift_of(Cases(logit, right, 1.0))

        def cost(d, right=right):
            return np.where(right, np.logaddexp(0, -logit - d), np.logaddexp(0, logit + d)).sum() + d * d / 2

        assert cost(shift) <= min(cost(shift + 0.01), cost(shift - 0.01))
    few = shift_of(Cases(logit[:4], np.zeros(4, bool), 1.0))
    many = shift_of(Cases(logit, np.arange(400) < 280, 1.0))
    assert shift_of(Cases(logit[:0], np.zeros(0, bool), 1.0)) == 0
    assert logistic(3.0 + many) == pytest.approx(0.7, abs=0.02) and -3 < few < 0
    assert abs(shift_of(Cases(logit, np.arange(400) < 280, 0.01))) < abs(many)


def test_pieces_of_the_trial_are_named_again_and_calibrate_it():
    parts = shredded(walk(7), 6, 2.0, 3)
    cases = cases_of(parts, template(), PairScore.of_template(template()), 0.3)
    assert 0.5 * 90 < len(cases.right) <= len(parts.tracks) and cases.right.mean() > 0.95 and 0 < cases.independent <= 1
    stretches = stretches_of(walk(7), template().size)
    true = np.array([template().names.index(name) for name in walk(7).names])
    pairs, p = PairScore.of_template(template()), np.full(15, 0.999)
    about = dict(sure=0.99, least_fit=0.3)
    assert len(stretches) == 15 and calibrated_shift(walk(7), template(), pairs, true, p, **about) == 0
    p[3] = 0.8
    assert abs(calibrated_shift(walk(7), template(), pairs, true, p, **about)) < 2


@pytest.mark.parametrize("n", [15, 39])
def test_markers_that_the_set_does_not_have_make_no_others_less_sure(n):
    """Twice as many as it has, all through: by as many ghosts of a few frames instead of them δ was −1.8 to −4.2."""
    parts = shredded(walk(7, n), extra=2 * n, seed=1)
    by = template(n)
    true = np.array([by.names.index(name) if name in by.names else -1 for name in parts.truth])
    p = np.where(true >= 0, 0.999, 0.0)
    p[np.flatnonzero(true >= 0)[:2]] = 0.8
    shift = calibrated_shift(parts.tracks, by, PairScore.of_template(by), true, p, sure=0.99, least_fit=0.3)
    assert abs(shift) < 0.5


def test_a_nameless_marker_seen_all_through_takes_no_name_from_the_pieces_that_calibrate_the_trial():
    """As one track it took the name of the heel beside it from that one's pieces: δ was −1.9."""
    trial, by = walk(7, 39), template(39)
    at, xyz = trial.names.index("LKNE"), dict(zip(trial.names, trial.xyz, strict=True))
    piece = np.arange(trial.n_frames) < trial.n_frames // 6
    heel = MarkerTrajectory.measured("+1", 0.8 * xyz["LHEE"] + 0.2 * xyz["LTOE"])
    paths = [*trial.paths, heel, replace(trial.paths[at].only(piece), name="piece")]
    paths[at] = paths[at].only(~piece)
    true = np.array([*(by.names.index(name) for name in trial.names), -1, by.names.index("LKNE")])
    p = np.where(true < 0, 0.0, np.where(np.arange(len(true)) < len(true) - 1, 0.999, 0.8))
    tracks = replace(trial, paths=tuple(paths))
    assert abs(calibrated_shift(tracks, by, PairScore.of_template(by), true, p, sure=0.99, least_fit=0.3)) < 0.5


def test_a_track_without_a_name_that_takes_a_confident_one_counts_as_wrong_unless_it_may_be_the_marker():
    """A twin of a knee, whose own track is rough; and the second half of its track, whose name the trial did not give,
    or gave without being sure."""
    names, whole = walk(7).names, walk(7)
    at, half = names.index("LKNE"), np.arange(whole.n_frames) < whole.n_frames // 2
    knee = whole.paths[at]
    rough = MarkerTrajectory.measured("LKNE", knee.xyz + np.random.default_rng(0).normal(0, 25, knee.xyz.shape))
    pairs = PairScore.of_template(template())

    def judged(own, other, of):
        paths = [*whole.paths, other]
        paths[at] = own
        tracks = Trajectories(tuple(replace(path, name=f"*{k}") for k, path in enumerate(paths)), whole.rate)
        return cases_of(Shredded(tracks, (*names, of)), template(), pairs, 0.3).right.tolist()

    assert judged(rough, knee, None) == [True] * 14 + [False]
    for of in (None, UNKNOWN):
        assert judged(knee.only(half), knee.only(~half), of) == [True] * 15
    assert judged(rough, knee, UNKNOWN) == [True] * 14


def test_pieces_beside_many_nameless_markers_are_less_sure_also_where_they_calibrate_the_trial():
    """Any of these may be where a piece is; by another subject's template this was not found."""
    parts = shredded(walk(7), 6, 2.0, 3)
    stretches, pairs = stretches_of(parts.tracks, template().size), PairScore.of_template(template())
    true = np.array([template().names.index(name) if name else -1 for name in parts.truth])
    alike = margins(stretches, true, template(), pairs)
    named = (true >= 0) & (alike.share < 0.5)
    few, many = (alike._replace(nameless=np.full(len(true), n)) for n in (0.0, 30.0))
    p = [track_probability(one, stretches.weight)[named] for one in (few, many)]
    assert (p[1] < p[0]).all() and np.median(1 - p[1]) > 3 * np.median(1 - p[0])
    other = [track_probability(one, stretches.weight, piece=BETA_TRACK)[named] for one in (few, many)]
    np.testing.assert_array_equal(*other)
    alone, beside = (cases_of(parts, template(), pairs, 0.3, n) for n in (0.0, 30.0))
    np.testing.assert_array_equal(alone.right, beside.right)
    change = alone.logit - beside.logit
    assert (change >= 0).all() and np.median(change) > 1


def test_a_piece_that_goes_on_in_a_posture_that_is_new_is_sure_and_beside_many_nameless_markers_much_less():
    """Margins of a lifted ankle's piece of four frames. Of such 0.9 to 0.99 was said: 294 of 294 were right, and beside
    four nameless markers and more 380 of 494."""
    values = dict(track=8.5, fit=0.3, beside=-0.8, link=44.7, frame_fit=1.0)
    piece = Margins(**{name: np.array([values.get(name, 0.0)]) for name in Margins._fields})
    alone, beside = (
        float(track_probability(piece._replace(nameless=np.array([n])), np.array([1.08]))[0]) for n in (0.0, 30.0)
    )
    assert alone > 0.99 and 1 - beside > 5 * (1 - alone)
    whole = piece._replace(share=np.ones(1))  # it is most of what its label is by, and right where its label is
    assert track_probability(whole, np.array([1.08]))[0] == track_probability(
        whole._replace(nameless=np.array([30.0])), np.array([1.08])
    )


def test_a_piece_of_few_markers_that_comes_back_after_an_occlusion_is_sure_where_no_marker_is_nameless():
    """Fifteen markers tell so much of a piece, and it goes on from none; nothing else is there that it could be."""
    values = dict(track=10.0, fit=1.1, frame_fit=1.0)
    piece = Margins(**{name: np.array([values.get(name, 0.0)]) for name in Margins._fields})
    alone, beside = (
        float(track_probability(piece._replace(nameless=np.array([n])), np.array([2.0]))[0]) for n in (0.0, 1.0)
    )
    assert alone > 0.99 > beside


def test_a_track_has_its_share_of_the_samples_of_its_label():
    parts = shredded(walk(7), 6, 2.0, 3)
    stretches, pairs = stretches_of(parts.tracks, template().size), PairScore.of_template(template())
    true = np.array([template().names.index(name) if name else -1 for name in parts.truth])
    share = margins(stretches, true, template(), pairs).share
    np.testing.assert_allclose(np.bincount(true[true >= 0], share[true >= 0]), 1.0)
    assert np.isnan(share[true < 0]).all() and (share[true >= 0] < 1).all()


@pytest.mark.parametrize(("frames", "least"), [(10, -8.0), (5, -1.0), (1, 4.6)])
def test_a_track_is_less_sure_where_another_gains_by_the_exchange_of_both(frames, least):
    """Of two wrists in pieces one hardly lost by it and was sure, though the other gained twice as much."""
    seen = np.ones((2, 10), bool)
    seen[1, frames:] = False
    nats, label = np.array([[30.0, 24.0], [24.0, 10.0]]), np.arange(2)
    margin, second = _second(SimpleNamespace(seen=seen), label, label, nats, label)
    assert margin[0] == pytest.approx(least) and second[0] == 1


def test_an_exchange_all_through_the_trial_makes_its_two_labels_improbable_and_no_other():
    stretches, pairs, true = known(walk(7, 39), template(39))
    d = template(39).distance + np.diag(np.full(39, np.inf))
    a, b = np.unravel_index(d.argmin(), d.shape)
    turn = np.arange(39)
    turn[[a, b]] = b, a
    right, wrong = (
        probability(margins(stretches, given, template(39), pairs), stretches.weight) for given in (true, turn[true])
    )
    off = np.isin(true, [a, b])
    assert right.min() > 0.99 and wrong[off].max() < 0.9 and np.median(wrong[~off]) > 0.99
    assert (wrong[off] < right[off]).all()


def test_who_speaks_for_the_runner_up_is_said_of_names_that_are_not_sure():
    """A knee that sits 10 cm beside where the template has it."""
    names = walk(7).names
    moved = [p.xyz + (60.0 if p.name == "LKNE" else 0.0) for p in walk(7)]
    trial = Trajectories(tuple(MarkerTrajectory.measured(n, x) for n, x in zip(names, moved, strict=True)), 100.0)
    found = label(trial, template())
    for state, against, runner_up in zip(found.state, found.against, found.runner_up, strict=True):
        assert state != "sure" or against == ()
        nats = [value for _, value in against]
        assert nats == sorted(nats, reverse=True) and all(value > 0 for value in nats)
        assert all(name in template().names and name != runner_up for name, _ in against)
    at = names.index("LKNE")
    assert found.state[at] != "sure"


def test_a_template_knows_what_it_scores_on_its_own_data():
    rng = np.random.default_rng(0)
    assert learn_template(walk(1)).own_fit > 0.95 and learn_template(walk(1).frames(0, 1)).own_fit == 1
    jump = np.repeat(rng.normal(0, 400, (12, 3, 3)), 40, axis=1) + rng.normal(0, 1.0, (12, 120, 3))
    odd = Trajectories(tuple(MarkerTrajectory.measured(f"m{k}", x) for k, x in enumerate(jump)), 100.0)
    assert learn_template(odd).own_fit == pytest.approx(0.7)


def test_a_name_is_surer_where_nothing_is_left_over_that_it_could_have_moved_up_to():
    """A label that no marker has, a marker that has no name, and both at once."""
    whole = walk(7, 39)
    by = learn_template(walk(1, 39)).of_another(1.0)
    stretches, pairs, true = known(whole, by)
    a, other = (by.names.index(name) for name in ("X3", "X21"))
    alike = margins(stretches, true, by, pairs)
    p = {}
    for shut in (0.0, 1.0, 2.0):
        about = alike._replace(shut=np.full(len(true), shut))
        p[shut] = probability(about, stretches.weight, label=BETA_OTHER)
    assert (p[0.0] < p[1.0]).all() and (p[1.0] < p[2.0]).all()
    assert (alike.shut == 2).all()
    without = np.where(np.isin(true, [a]), -1, true)  # its marker has no name, and its label is absent
    assert (margins(stretches, without, by, pairs).shut[without >= 0] == 0).all()
    kept = whole.select([name for name in whole.names if name != by.names[other]])
    stretches, pairs, true = known(kept, by)
    assert (margins(stretches, true, by, pairs).shut == 1).all()


def test_what_the_stiffest_distances_lack_counts_for_more_the_more_markers_have_no_name():
    """One of many may lie near where an absent one belongs; distances that hold are no such thing."""
    stretches, pairs, true = known(walk(7, 39), template(39))
    alike = margins(stretches, true, template(39), pairs)
    assert (alike.nameless == 0).all()
    p = {}
    for stiff in (0.4, 1.0):
        for n in (0.0, 3.0, 30.0):
            about = alike._replace(stiff=np.full(len(true), stiff), nameless=np.full(len(true), n))
            p[stiff, n] = label_probability(about)
    assert (p[0.4, 30.0] < p[0.4, 3.0]).all() and (p[0.4, 3.0] < p[0.4, 0.0]).all()
    assert (p[1.0, 30.0] == p[1.0, 0.0]).all()
    without = np.where(np.isin(true, [3, 8]), -1, true)
    assert (margins(stretches, without, template(39), pairs).nameless[without >= 0] == 2).all()


def test_a_name_by_which_nothing_is_told_is_not_likely_and_fits_nothing():
    """A ghost that is called as a marker of the other leg, which is absent: no distance to what is seen tells of it."""
    standing, trial = (walking(duration_s=1.0, rate=50.0, seed=seed).trajectories for seed in (1, 3))
    by = learn_template(standing.frames(12, 15), relative_spread=0.18)
    ghost = MarkerTrajectory.measured("RHEE", trial["RHEE"].xyz + np.array([150.0, -150.0, 120.0]))
    leg = [trial["L" + part] for part in ("THI", "KNE", "TIB", "ANK", "HEE", "TOE")]
    stretches, pairs, true = known(replace(trial, paths=(*leg, ghost)), by)
    about = margins(stretches, true, by, pairs)
    assert abs(about.told[-1]) < 0.1 and (about.told[:-1] > 1).all() and abs(about.fit[-1]) < 0.1
    p = {told: probability(about._replace(told=np.full(7, told)), stretches.weight)[:-1] for told in (0.0, 2.0, 5.2)}
    assert (p[0.0] < 0.01).all() and (p[2.0] < 0.51).all() and (p[5.2] > 1.99 * p[2.0]).all()


def test_an_exchange_that_gains_by_another_subjects_template_tells_nothing_more_than_one_that_neither_gains_nor_loses():
    stretches, pairs, true = known(walk(7, 39), template(39))
    about = margins(stretches, true, template(39), pairs)
    of = {"own": {}, "other": {"label": BETA_OTHER, "gained": GAINED_OTHER}}
    p = {
        (whose, x): probability(about._replace(exchange=np.full(len(true), x)), stretches.weight, **how)
        for whose, how in of.items()
        for x in (-30.0, -1.0, 0.0, 5.0)
    }
    assert (p["own", -30.0] < p["own", -1.0]).all()
    assert (p["other", -30.0] == p["other", 0.0]).all() and (p["other", 0.0] < p["other", 5.0]).all()


def test_a_mirrored_world_is_told_by_names_of_either_side_and_a_right_one_is_none():
    """Distances fit the names of the own side there, and orientation those of the other."""
    by = template(39)
    other = mirrored(by.names)
    stretches, pairs, true = known(walk(7, 39), by)
    assert not _mirrored_world(stretches, true, by, pairs, other)
    turned = replace(walk(7, 39), paths=tuple(replace(p, xyz=p.xyz * [1.0, -1.0, 1.0]) for p in walk(7, 39)))
    stretches, pairs, true = known(turned, by)
    assert _mirrored_world(stretches, true, by, pairs, other)
    assert _mirrored_world(stretches, other[true], by, pairs, other)


def test_probabilities_are_recalibrated_without_changing_which_names_are_sure():
    p = np.r_[0.0, np.geomspace(1e-6, 1, 200), 1 - np.geomspace(1e-6, 0.5, 200)]
    p.sort()
    for another, table in ((False, OWN), (True, OTHER)):
        found = recalibrated(p, another=another)
        assert (np.diff(found) >= 0).all() and found[0] == 0
        np.testing.assert_array_equal(found[p >= 0.99], p[p >= 0.99])
        assert ((found >= 0.99) == (p >= 0.99)).all()
        knots, to = np.array(table).T
        np.testing.assert_allclose(recalibrated(knots, another=another), to, rtol=1e-9)


@pytest.mark.parametrize("another", [False, True])
def test_the_probability_of_a_name_is_that_of_its_label_recalibrated_times_that_of_its_track(another):
    """A piece of one frame of a label that is certain is as sure as pieces are, which no map of labels makes less."""
    trial = walk(2)
    by = template().of_another(1.0) if another else template()
    parts = shredded(trial, 60, 2.0, 3)
    stretches, pairs = stretches_of(parts.tracks, by.size), PairScore.of_template(by)
    true = np.array([by.names.index(name) if name else -1 for name in parts.truth])
    about = margins(stretches, true, by, pairs)
    own = true >= 0  # beside so many, pieces of one frame that go on from none are not sure
    about = about._replace(nameless=np.where(own, 12.0, np.nan), link=np.where(own, 0.0, np.nan))
    beta = {"label": BETA_OTHER, "gained": GAINED_OTHER} if another else {}
    tracks = {"piece": BETA_TRACK} if another else {}
    of_label = recalibrated(label_probability(about, **beta), another=another)
    plain = np.nan_to_num(of_label * track_probability(about, stretches.weight, **tracks))
    how = {"sure": 0.99, "least_fit": 0.3, "nameless": 12.0, **tracks}
    shift = calibrated_shift(parts.tracks, by, pairs, true, plain, **how)
    wanted = np.nan_to_num(of_label * track_probability(about, stretches.weight, shift, **tracks))
    found = probability_of_all(parts.tracks, by, pairs, true, about, stretches.weight, Distances())
    assert ((found > 0) & (found < 0.99)).any() and (about.absent[true >= 0] == 0).all()
    np.testing.assert_array_equal(found, wanted)


def test_a_part_of_a_body_is_told_by_what_speaks_for_it_and_nothing_changes_where_all_is_there():
    """A limb can have the names of one that is absent: its own distances hold, and no exchange of two shows it."""
    stretches, pairs, true = known(walk(7, 39), template(39))
    about = margins(stretches, true, template(39), pairs)
    n, p = len(true), np.full(len(true), 0.995)
    np.testing.assert_array_equal(by_what_is_absent(p, about), p)

    def of(told=8.0, proofs=3.0, median=1.1, absent=20.0):
        kept = {"told": told, "proofs": proofs, "label_fit": median, "fit_beside": 0.0, "absent": absent}
        return by_what_is_absent(p, about._replace(**{key: np.full(n, value) for key, value in kept.items()}))[0]

    assert of(absent=0.0) == 0.995 and of(told=60.0) > 0.99
    assert of(told=3.0) < of(told=8.0) < of(told=60.0) and of(median=0.6) < 0.9 * of()
    assert of(median=2.0) == of(median=1.0) and of(proofs=0.0) > 0.999 and of(median=0.6, absent=2.0) > of(median=0.6)
    none = by_what_is_absent(np.full(n, np.nan), about._replace(absent=np.full(n, 3.0)))
    assert np.isnan(none).all()


def test_labels_that_are_absent_are_counted_and_those_whose_stiffest_neighbours_are():
    by, trial = template(39), walk(7, 39)
    D = np.where(by.keeps, by.spread, np.inf)
    np.fill_diagonal(D, np.inf)
    a = int(np.argmin(np.isfinite(D).sum(1)))
    gone = {by.names[b] for b in np.flatnonzero(np.isfinite(D[a]))}
    stretches, pairs, true = known(trial.select([name for name in trial.names if name not in gone]), by)
    about = margins(stretches, true, by, pairs)
    assert (about.absent == len(gone)).all()
    own = int(np.flatnonzero(true == a)[0])
    assert about.proofs[own] == 0 and about.stiff[own] == 0
    full_stretches, _, full = known(trial, by)
    full_about = margins(full_stretches, full, by, pairs)
    assert (full_about.absent == 0).all() and (full_about.proofs > 0).all()
