"""A template hangs on nothing but the body: not on origin, axes, unit, or the order of labels."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories
from kinemark.label import label, learn_template
from kinemark.label.template import between_subjects, triple_products
from kinemark.synth import walking, with_markers

TURN = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
TURN = TURN * np.sign(np.linalg.det(TURN))
PARTS = ("THI", "KNE", "TIB", "ANK", "HEE", "TOE")


def walk(seed=1, n=15):
    return with_markers(walking(duration_s=2.0, rate=100.0, seed=seed, wobble_mm=1.0), n, seed=1).trajectories


def changed(trial, change):
    return replace(trial, paths=tuple(replace(path, xyz=change(path.xyz)) for path in trial))


def assert_same(a, b, factor=1.0):
    assert a.names == b.names and np.array_equal(a.handed, b.handed) and np.array_equal(a.sign, b.sign)
    for name in ("distance", "spread", "short_spread"):
        np.testing.assert_allclose(factor * getattr(a, name), getattr(b, name), rtol=1e-6, atol=1e-6 * factor)


@pytest.mark.parametrize(
    ("change", "factor"),
    [(lambda x: x + np.array([1e5, -2e5, 3e4]), 1.0), (lambda x: x @ TURN, 1.0), (lambda x: 0.001 * x, 0.001)],
    ids=["shift", "rotation", "unit"],
)
def test_origin_axes_and_unit_do_not_matter(change, factor):
    assert_same(learn_template(walk()), learn_template(changed(walk(), change)), factor)


def test_the_order_of_markers_does_not_matter():
    trial = walk()
    assert_same(learn_template(trial), learn_template(replace(trial, paths=trial.paths[::-1])))


def test_a_mirror_image_has_the_same_distances_and_every_quadruple_turned():
    one, other = learn_template(walk()), learn_template(changed(walk(), lambda x: x * [1, -1, 1]))
    np.testing.assert_allclose(one.distance, other.distance)
    assert len(one.handed) > 10 and np.array_equal(one.sign, -other.sign)


def test_mean_and_spread_are_those_of_the_distances():
    trial = walk()
    template = learn_template(trial)
    a, b = template.names[2], template.names[7]
    d = np.linalg.norm(trial[a].xyz - trial[b].xyz, axis=1)
    assert template.distance[2, 7] == pytest.approx(d.mean()) and template.spread[2, 7] == pytest.approx(d.std())
    assert template.short_spread[2, 7] <= template.spread[2, 7]


def test_scaling_scales_and_a_relative_spread_widens_all_but_segments():
    names = learn_template(walk()).names
    plain = learn_template(walk())
    wide = learn_template(walk(), relative_spread=0.1, segments={"one": names[:2]})
    assert wide.spread[0, 1] == plain.spread[0, 1]
    assert wide.spread[0, 5] == pytest.approx(np.hypot(plain.spread[0, 5], 0.1 * plain.distance[0, 5]))
    assert plain.scaled(1.2).size == pytest.approx(1.2 * plain.size)


def test_unnamed_tracks_are_not_learnt_and_too_few_markers_are_refused():
    ghost = MarkerTrajectory.measured("*1", walk().paths[0].xyz)
    assert "*1" not in learn_template(replace(walk(), paths=(*walk().paths, ghost))).names
    with pytest.raises(KinemarkError, match="3 named markers"):
        learn_template(Trajectories(walk().paths[:3], 100.0))


def test_markers_at_one_place_are_no_template():
    """Naming by it ended in a `ValueError` of SciPy."""
    with pytest.raises(KinemarkError, match="at one place"):
        learn_template(changed(walk(), lambda xyz: np.full_like(xyz, 70.0)))


def test_several_trials_are_pooled():
    one, two = walk(1), walk(2)
    both = learn_template(one, two)
    parts = learn_template(one), learn_template(two)
    np.testing.assert_allclose(both.distance, np.mean([part.distance for part in parts], axis=0))


def test_another_subjects_distances_are_doubtful_the_more_the_longer_up_to_a_limb():
    one = learn_template(walk()).of_another(1.1)
    size = one.size
    assert one.doubt[0, 5] == pytest.approx(between_subjects(one.distance[0, 5], size))
    near, limb, body = (between_subjects(share * size, size) for share in (0.02, 0.2, 1.0))
    assert near < limb < body < 0.02 * size
    np.testing.assert_allclose(one.spread, 1.1 * learn_template(walk()).spread)


@pytest.mark.parametrize(("n", "seed"), [(39, 1), (53, 3), (60, 4)])
def test_orientations_of_a_single_posture_are_mostly_those_that_a_walk_keeps(n, seed):
    trial = with_markers(walking(duration_s=2.0, rate=50.0, seed=seed, wobble_mm=1.0), n, seed=seed).trajectories
    posture = learn_template(trial.frames(10, 11), relative_spread=0.14)
    triple = triple_products(trial.select(posture.names).xyz, posture.handed)
    assert len(triple) > 90 and (triple * posture.sign[:, None] < 0).mean() < 0.15


def test_a_static_trial_names_a_walk_though_what_it_shows_of_orientations_turns():
    names = ("LASI", "RASI", "SACR", *(side + part for side in "LR" for part in PARTS))
    standing, trial = (walking(duration_s=1.0, rate=50.0, seed=seed).trajectories.select(names) for seed in (1, 11))
    found = label(trial, learn_template(standing.frames(12, 15), relative_spread=0.18))
    assert found.refused is None and found.names == names


def test_static_trials_that_face_opposite_ways_show_the_same_orientations_as_one():
    standing = walk().frames(0, 5)
    turned = changed(standing, lambda x: x @ np.diag([-1.0, -1.0, 1.0]) + [3000.0, 100.0, 0.0])
    one, both = (learn_template(*trials, relative_spread=0.18) for trials in ((standing,), (standing, turned)))
    assert len(one.handed) > 10
    np.testing.assert_array_equal(both.handed, one.handed)
    np.testing.assert_array_equal(both.sign, one.sign)


def test_a_trial_whose_markers_are_seen_at_its_beginning_alone_is_learnt():
    """Leaving out the part with markers left nothing, and NumPy warned of it in the terminal."""
    begun = (np.r_[path.xyz[:20], np.full((180, 3), np.nan)] for path in walk())
    paths = tuple(MarkerTrajectory.measured(path.name, xyz) for path, xyz in zip(walk(), begun, strict=True))
    assert learn_template(replace(walk(), paths=paths)).own_fit == 1.0
