"""Trials that contradict themselves are told by no template: distances are steadier with two names exchanged."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label.own_exchanges import find_own_exchanges, without_exchanged
from kinemark.synth import walking, with_markers


@cache
def walk(seed, n=39):
    return with_markers(walking(duration_s=4.0, rate=100.0, seed=seed, wobble_mm=2.0), n, seed=1).trajectories


def exchanged(trial, a, b, first, stop):
    """With the names of two exchanged in some frames."""
    i, j = trial.names.index(a), trial.names.index(b)
    xyz = trial.xyz.copy()
    xyz[[i, j], first:stop] = xyz[[j, i], first:stop]
    return replace(trial, paths=tuple(replace(p, xyz=one) for p, one in zip(trial, xyz, strict=True)))


def near_two(trial, seed):
    """A marker at random and one of the four nearest to it, 40 mm away at least."""
    rng, xyz = np.random.default_rng(seed), trial.xyz
    i = int(rng.integers(len(trial)))
    d = np.linalg.norm(xyz - xyz[i], axis=2).mean(1)
    near = [int(j) for j in np.argsort(d) if d[j] > 40.0][:4]
    return trial.names[i], trial.names[int(rng.choice(near))]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("n", [15, 39])
def test_a_trial_whose_names_are_right_contradicts_nothing(n, seed):
    assert find_own_exchanges(walk(seed, n)) == ((),)


@pytest.mark.parametrize("seed", range(6))
def test_two_names_exchanged_for_a_while_or_from_then_on_are_found_with_their_frames(seed):
    trial = walk(seed % 3)
    a, b = near_two(trial, seed)
    first, stop = (150, 260) if seed % 2 else (250, 400)
    ((found,),) = find_own_exchanges(exchanged(trial, a, b, first, stop))
    assert set(found.markers) == {a, b} and found.gain > 0
    assert abs(found.first - first) <= 2 and abs(found.stop - stop) <= 2


def test_of_two_parts_the_shorter_one_counts_and_is_left_out():
    trial = walk(1)
    a, b = near_two(trial, 2)
    ((found,),) = find_own_exchanges(exchanged(trial, a, b, 100, 400))
    assert (found.first, found.stop) == (0, 100)
    kept = without_exchanged(trial, [found])
    for path, own in zip(kept, trial, strict=True):
        left_out = np.isnan(path.xyz[:, 0])
        assert left_out[:100].all() == (path.name in (a, b)) and not left_out[100:].any()
        assert (path.xyz[100:] == own.xyz[100:]).all()


def test_a_trial_that_names_two_otherwise_than_the_subject_s_others_is_found():
    trials = [walk(1), walk(2), walk(3)]
    a, b = near_two(trials[0], 2)
    trials[1] = exchanged(trials[1], a, b, 0, 400)
    found = find_own_exchanges(*trials)
    assert [len(one) for one in found] == [0, 1, 0]
    assert found[1][0].first <= 2 and found[1][0].stop >= 398


@pytest.mark.parametrize("seed", [55, 66, 74, 136, 194, 200])
def test_right_names_of_less_than_a_second_with_long_gaps_are_not_called_exchanged(seed):
    """Few poses vary little, and by chance less the other way round."""
    rng = np.random.default_rng(seed)
    trial, first = walk(seed % 3, (15, 39)[seed // 3 % 2]), int(rng.integers(0, 300))
    trial = trial.frames(first, first + int(rng.integers(20, 100)))
    kept = np.ones((len(trial), trial.n_frames), bool)
    for row in kept:
        gap = int(rng.integers(0, trial.n_frames))
        row[gap : gap + int(rng.integers(1, trial.n_frames // 2))] = False
    paths = tuple(path.only(row) for path, row in zip(trial, kept, strict=True))
    assert find_own_exchanges(replace(trial, paths=paths)) == ((),)


def test_a_few_frames_few_markers_and_gaps_do_no_harm():
    trial = walk(1)
    assert find_own_exchanges(trial.frames(0, 1)) == ((),) == find_own_exchanges(trial.frames(0, 2))
    assert find_own_exchanges(trial.select(trial.names[:3])) == ((),)
    assert find_own_exchanges(Trajectories((), 100.0)) == ((),) and find_own_exchanges() == ()
    kept = np.random.default_rng(0).random((len(trial), trial.n_frames)) < 0.3
    assert find_own_exchanges(replace(trial, paths=tuple(map(lambda p, k: p.only(k), trial, kept)))) == ((),)
    nowhere = [p.only(np.zeros(trial.n_frames, bool)) for p in trial]
    assert find_own_exchanges(replace(trial, paths=tuple(nowhere))) == ((),)


def with_tool(trial, seed):
    """A symmetric tool of four markers beside, which turns slowly."""
    rng, n = np.random.default_rng(seed), trial.n_frames
    turn = gaussian_filter1d(rng.normal(size=(n, 3)), 50.0, axis=0)
    places = Rotation.from_rotvec(turn / turn.std())
    arms = 80.0 * np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    at = trial.xyz[0] + [300.0, 0.0, 0.0]
    tool = (MarkerTrajectory.measured(f"TOOL{k}", at + places.apply(arm)) for k, arm in enumerate(arms))
    return replace(trial, paths=(*trial.paths, *tool))


@pytest.mark.parametrize("seed", range(4))
def test_opposite_markers_of_a_tool_that_turns_are_not_called_exchanged(seed):
    """By chance some distances to the body are steadier the other way round, but names never change at once."""
    assert find_own_exchanges(with_tool(walk(seed % 3, 15), seed)) == ((),)


def test_names_that_are_exchanged_across_a_gap_are_found():
    trial = walk(2)
    a, b = near_two(trial, 3)
    wrong = exchanged(trial, a, b, 240, 400)
    kept = np.ones(400, bool)
    kept[220:255] = False
    paths = tuple(p.only(kept) if p.name in (a, b) else p for p in wrong)
    ((found,),) = find_own_exchanges(replace(wrong, paths=paths))
    assert set(found.markers) == {a, b} and 220 <= found.first <= 255 and found.stop == 400
