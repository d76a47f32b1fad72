"""What happens to all markers of a file at once is told by its cause, and hides nothing that happens to one."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.edit.probable_errors import Paths, breaks, spikes, unbroken
from support.walked import clean, every, spiked, trajectories, walk

F = 150


def with_all(xyz):
    return trajectories(xyz, clean().names)


def lost(xyz, n, f=F):
    return np.delete(xyz, slice(f + 1, f + 1 + n), axis=1)


def held(xyz, n, f=F):
    out = xyz.copy()
    out[:, f + 1 : f + 1 + n] = out[:, f : f + 1]
    return out


def doubled(xyz, n, f=F):
    return np.concatenate([xyz[:, : f + 1], np.repeat(xyz[:, f : f + 1], n, axis=1), xyz[:, f + 1 :]], axis=1)


def moved(xyz, first=F + 1, stop=None, degrees=1.0):
    out = xyz.copy()
    turn = Rotation.from_rotvec(np.radians(degrees) * np.array([0.6, 0.0, 0.8])).as_matrix()
    out[:, first:stop] = out[:, first:stop] @ turn.T + np.array([20.0, -15.0, 8.0])
    return out


def likely(trial, above=0.5):
    return [one for one in breaks(Paths.of(trial)) if one.wrong > above]


@pytest.mark.parametrize("seed", [3, 8])
@pytest.mark.parametrize("k", [1, 2, 4])
def test_a_clean_walk_has_none_worth_a_look(seed, k):
    assert not likely(every(clean(seed=seed), k), 0.05)


@pytest.mark.parametrize("n", [1, 3, 6])
def test_lost_frames_are_counted(n):
    (one,) = likely(with_all(lost(clean().xyz, n)))
    assert (one.kind, one.before, one.after, one.frames) == ("lost", F, F + 1, n)


@pytest.mark.parametrize(("make", "frames"), [(held, 0), (doubled, -3)])
def test_repeated_frames_are_told_with_whether_time_went_on(make, frames):
    (one,) = likely(with_all(make(clean().xyz, 3)))
    assert (one.kind, one.before, one.after, one.frames) == ("repeated", F, F + 4, frames)


def test_another_world_is_told_with_its_motion():
    (one,) = likely(with_all(moved(clean().xyz)))
    assert (one.kind, one.before, one.after) == ("moved", F, F + 1) and abs(one.motion.degrees - 1.0) < 0.1


@pytest.mark.parametrize("n", [1, 4, 40])
def test_a_world_that_comes_back_is_one_cause(n):
    (one,) = likely(with_all(moved(clean().xyz, stop=F + 1 + n)))
    assert (one.kind, one.before, one.after) == ("shaken", F, F + 1 + n)


@pytest.mark.parametrize("make", [lambda xyz: lost(xyz, 3), lambda xyz: doubled(xyz, 3), moved])
def test_what_one_marker_does_is_seen_without_the_cause(make):
    trial = with_all(make(spiked(clean(), 6, F - 20, F - 18).xyz))
    paths = Paths.of(trial)
    now, frame = unbroken(paths, trial.names, breaks(paths))
    (one,) = (one for one in spikes(Paths.of(now)) if one.wrong > 0.5)
    assert (one.path, frame[one.first], frame[one.last]) == (6, F - 20, F - 19)


@pytest.mark.parametrize("n", [1, 4])
def test_lost_frames_are_missing_and_a_moved_world_is_moved_back(n):
    xyz = clean().xyz
    trial = with_all(lost(xyz, n))
    now, frame = unbroken(Paths.of(trial), trial.names, likely(trial))
    assert now.n_frames == xyz.shape[1] and np.isnan(now.xyz[:, F + 1 : F + 1 + n]).all() and frame[F + n] == F
    np.testing.assert_array_equal(now.xyz[:, F + 1 + n :], xyz[:, F + 1 + n :])
    trial = with_all(moved(xyz))
    back, _ = unbroken(Paths.of(trial), trial.names, likely(trial))
    assert np.abs(back.xyz - xyz).max() < 3


def test_frames_that_were_put_in_are_taken_out():
    trial = with_all(doubled(clean().xyz, 3))
    now, frame = unbroken(Paths.of(trial), trial.names, likely(trial))
    np.testing.assert_array_equal(now.xyz, clean().xyz)
    assert frame[F] == F and frame[F + 1] == F + 4


def test_nothing_hangs_on_the_origin():
    xyz = lost(clean().xyz, 2)
    near, far = (likely(with_all(some)) for some in (xyz, xyz + np.array([2e6, -1e6, 0.0])))
    assert [one[:4] for one in near] == [one[:4] for one in far]


def test_a_gap_of_all_that_took_no_time_is_told_and_one_that_did_is_none():
    gone = doubled(walk()[1], 3)
    gone[:, F + 1 : F + 4] = np.nan
    (one,) = likely(with_all(gone))
    assert (one.kind, one.frames) == ("lost", -3)
    gap = clean().xyz.copy()
    gap[:, F + 1 : F + 4] = np.nan
    assert not likely(with_all(gap), 0.05)
