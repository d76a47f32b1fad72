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


def test_what_shares_nothing_is_not_compared():
    one = walk(1)
    assert np.isinf(motion_apart(one, {"other": one["LKNE"]}))
    assert np.isinf(motion_apart(one, {name: np.full_like(xyz, np.nan) for name, xyz in one.items()}))
    assert np.isinf(motion_apart(one, {name: xyz[:5] for name, xyz in one.items()}))
