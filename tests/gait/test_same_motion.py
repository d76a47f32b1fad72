"""Two files of one recording are told from two recordings, however they number their frames."""

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from kinemark.gait.same_motion import motion_apart, same_motion
from kinemark.synth import walking

RATE = 100.0


def walk(seed, **how):
    return {p.name: np.asarray(p.xyz, float) for p in walking(duration_s=3.0, rate=RATE, seed=seed, **how).trajectories}


def gappy(points):
    kept = {name: xyz.copy() for name, xyz in points.items()}
    kept["LKNE"][40:120] = np.nan
    kept["RHEE"][:] = np.nan
    return kept


def filtered(points):
    b, a = butter(2, 6.0 / (RATE / 2))
    return {name: filtfilt(b, a, xyz, axis=0) for name, xyz in points.items()}


CHANGES = {
    "copied": lambda points: points,
    "cut": lambda points: {name: xyz[70:230] for name, xyz in points.items()},
    "with gaps": gappy,
    "filtered": filtered,
    "of some markers": lambda points: {name: points[name] for name in ("LASI", "RKNE", "LTOE")},
    "noisy": lambda points: {n: xyz + np.random.default_rng(3).normal(0, 1.0, xyz.shape) for n, xyz in points.items()},
}


@pytest.mark.parametrize("far", [0.0, 1e7])
@pytest.mark.parametrize("change", CHANGES)
def test_a_recording_is_known_again(change, far):
    points = {name: xyz + far for name, xyz in walk(1).items()}
    other = CHANGES[change](points)
    assert same_motion(points, other) and same_motion(other, points)


def test_two_walks_are_two():
    """Of one subject, of the same number of frames, through the same places."""
    one = walk(1)
    late = {name: xyz + np.array([0.0, 30.0, 0.0]) for name, xyz in one.items()}
    quick = {name: np.stack([np.interp(np.arange(300) * 1.05, np.arange(300), x) for x in xyz.T], 1)
             for name, xyz in one.items()}  # fmt: skip
    for other in (late, quick):
        assert not same_motion(one, other)


def standing(seed):
    """Of a person who sways by some millimetres, always in one place."""
    rng, t = np.random.default_rng(seed), np.arange(300)[:, None] / RATE
    sway = sum(rng.normal(0, 0.8, 3) * np.sin(2 * np.pi * hz * t + rng.uniform(0, 6)) for hz in (0.2, 0.35, 0.6))
    return {name: xyz[150] + sway + rng.normal(0, 0.2, xyz.shape) for name, xyz in walk(1).items()}


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_who_stands_twice_in_one_place_is_recorded_twice(seed):
    one, again = standing(seed), standing(seed + 10)
    assert motion_apart(one, again)[0] < 5.0 and not same_motion(one, again)
    assert same_motion(one, one)


def test_what_shares_nothing_is_not_compared():
    one = walk(1)
    assert np.isinf(motion_apart(one, {"other": one["LKNE"]})[0])
    assert np.isinf(motion_apart(one, {name: np.full_like(xyz, np.nan) for name, xyz in one.items()})[0])
    assert np.isinf(motion_apart(one, {name: xyz[:5] for name, xyz in one.items()})[0])
