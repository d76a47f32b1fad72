"""A whole segment is lost while the rest of the body stands still: how its gaps are tested, and what is expected."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.fill import Gap, MarkerArray, fill
from kinemark.fill.judge.hold_out import draw_hold_out_gaps
from kinemark.fill.judge.motion import PartMotion
from support.filling import trial

ARM = range(6, 10)
"""Markers of the forearm; the six before it are of a trunk at rest."""
RATE = 100.0


def reaching(seed, *, noise=0.3, strokes=2):
    """A forearm of four markers that rests for 4 s, and then goes up and down about the elbow, a second each way."""
    rng = np.random.default_rng(seed)
    t = np.arange(round((4 + 2 * strokes) * RATE)) / RATE
    up = np.where(t < 4, 0.0, (1 - np.cos(np.pi * (t - 4))) / 2)
    turn = Rotation.from_rotvec(np.outer(up * np.radians(110), [0, 1.0, 0]) + np.outer(up**2 * 0.5, [1.0, 0, 0]))
    trunk = rng.normal(0, 150, (6, 1, 3)) + 2 * np.sin(1.5 * t)[:, None]
    arm = np.stack([turn.apply(place) for place in rng.normal([250, 0, 0], [60, 30, 30], (4, 3))])
    xyz = np.concatenate([trunk + 0 * arm[:1], arm])
    return MarkerArray(xyz + rng.normal(0, noise, xyz.shape), RATE, tuple(f"M{k}" for k in range(10)))


def lost(start, stop):
    """The whole forearm is not seen."""
    return [Gap(k, start, stop) for k in ARM]


def test_its_gap_is_more_motion_than_a_window_at_rest():
    motion = reaching(0)
    moving, (gap, *_) = PartMotion(motion.hidden(lost(420, 480))), lost(420, 480)
    by = moving.references(gap)
    assert not set(by) & set(ARM), "none of the segment is seen"
    assert moving.of_gap(gap) > 4 * moving.of(gap.marker, 100, 60, by)
    assert moving.of_gap(gap) == pytest.approx(moving.of_gap(gap._replace(start=620, stop=680), by), rel=0.1)


def test_its_gaps_are_tested_where_it_moves():
    motion = reaching(0)
    hidden, gaps = motion.hidden(lost(420, 480)), lost(420, 480)
    tests = [test for test in draw_hold_out_gaps(hidden, gaps, per_gap=6, seed=0).tests if test.own]
    assert len(tests) > 12 and np.mean([test.window.stop > 400 for test in tests]) > 0.9


@pytest.mark.parametrize("seed", [1, 2])
def test_the_error_said_is_the_true_one(seed):
    """By windows at rest a straight line was the best, half a millimetre expected and 20 to 60 true."""
    motion, gaps = reaching(seed), lost(425, 490)
    found = fill(trial(motion.hidden(gaps)), limit_mm=np.inf)
    off = np.linalg.norm(found.trajectories.xyz - motion.xyz, axis=-1)
    true = np.array([off[gap.marker, gap.start : gap.stop].mean() for gap in gaps])
    expected = np.array([gap.expected_mm for gap in found.gaps])
    assert (true < 3 * expected).all() and expected.mean() > 0.5 * true.mean()
