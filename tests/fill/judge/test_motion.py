"""Hold-out gaps are as hard in motion as the gap, and an error that none of them shows is expected all the same."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.fill import Gap, MarkerArray, Prediction, fill, find_gaps
from kinemark.fill.judge.expected_error import SLOPE, STEEPEST, MeasuredErrors, slope
from kinemark.fill.judge.hold_out import HoldOutGap, HoldOutResult, draw_hold_out_gaps
from kinemark.fill.judge.motion import PATH, TURN, PartMotion
from kinemark.synth import walking, with_markers
from support.filling import trial


def turning(rate_deg, speed, *, frames=200, rate=100.0):
    """Six markers of a rigid body that turns by so many degrees a second about its middle and moves in mm/s."""
    rng = np.random.default_rng(0)
    body, t = rng.normal(0, 100, (6, 3)), np.arange(frames) / rate
    R = Rotation.from_rotvec(np.radians(rate_deg) * t[:, None] * [0, 0, 1.0]).as_matrix()
    xyz = np.einsum("fij,mj->mfi", R, body * [1, 1, 0]) + speed * t[:, None] * [0, 0, 1.0]
    return MarkerArray(xyz, rate, tuple("ABCDEF"))


def rested(rest_s=4.0, walk_s=5.0, *, rate=50.0, markers=20, seed=1):
    """A walker who stands still at first."""
    subject = with_markers(walking(duration_s=walk_s, rate=rate, wobble_mm=1.0, seed=seed), markers, seed=seed)
    xyz = np.concatenate([np.repeat(subject.xyz[:, :1], round(rest_s * rate), 1), subject.xyz], 1)
    return MarkerArray(xyz + np.random.default_rng(seed).normal(0, 0.3, xyz.shape), rate, subject.names)


def lost_in_motion(motion, markers, first):
    """Gaps of these markers wherever they are fast, from a frame on."""
    gaps = []
    for k in markers:
        speed = np.linalg.norm(np.gradient(motion.xyz[k], axis=0), axis=1)
        speed = np.convolve(speed, np.ones(5) / 5, "same")
        fast = speed > np.quantile(speed[first:], 0.4)
        fast[:first] = fast[-4:] = False
        hidden = motion._replace(xyz=np.where(fast[None, :, None], np.nan, motion.xyz))
        gaps += [Gap(k, a, b) for _, a, b in find_gaps(hidden._replace(xyz=hidden.xyz[k : k + 1])) if b - a > 4]
    return gaps


class TestPartMotion:
    def test_it_is_the_path_and_how_far_the_part_turns(self):
        for deg, speed in ((0, 0), (90, 0), (0, 1000), (90, 1000)):
            found = PartMotion(turning(deg, speed)).of_gap(Gap(0, 51, 149))  # from frame 50 to 149: 0.99 s
            spin = 0.99 * np.radians(deg)
            least = (0.99 * speed + PATH) * (spin + TURN)
            assert found**2 >= 0.97 * least
            if not spin:  # else the path is longer: it is bent
                assert found**2 == pytest.approx(least, rel=0.02)

    def test_the_markers_own_samples_and_the_origin_of_the_world_play_no_part(self):
        motion = turning(120, 500)
        gap = Gap(2, 40, 90)
        far = motion._replace(xyz=motion.xyz + np.array([3e6, -2e6, 1e6]))
        own = PartMotion(motion.hidden([gap])).of_gap(gap)
        assert own == pytest.approx(PartMotion(motion).of_gap(gap), rel=0.02)
        assert own == pytest.approx(PartMotion(far.hidden([gap])).of_gap(gap), rel=1e-6)

    def test_odd_input_has_a_value(self):
        assert np.isfinite(PartMotion(turning(0, 0)._replace(xyz=np.full((6, 200, 3), np.nan))).of_gap(Gap(0, 5, 9)))
        one = turning(10, 10, frames=1)
        assert np.isfinite(PartMotion(one).of_gap(Gap(0, 0, 1)))


def test_a_gap_in_motion_is_tested_in_motion_and_one_at_rest_at_rest():
    motion = rested()
    for gap in (Gap(5, 300, 320), Gap(5, 100, 120)):
        moving = PartMotion(motion.hidden([gap])).of_gap(gap)
        tests = draw_hold_out_gaps(motion.hidden([gap]), [gap], per_gap=8, seed=0).tests
        own = np.array([test.motion for test in tests if test.own])
        assert len(own) and np.median(np.abs(np.log(own / moving))) < 0.5


@pytest.mark.parametrize("still", [True, False])
def test_where_all_windows_that_move_alike_overlap_other_markers_are_tested_too(still):
    """They are one pose, be they eight: what is seen of others in the gap's own frames tells of its pose."""
    motion, gap = turning(120, 500, frames=400), Gap(0, 160, 200)
    if still:  # but from frame 150 to 260
        motion = motion._replace(xyz=motion.xyz[:, np.clip(np.arange(400), 150, 260)])
    tests = draw_hold_out_gaps(motion.hidden([gap]), [gap], per_gap=8, seed=0).tests
    others = [test.window[1:] for test in tests if not test.own]
    assert sum(test.own for test in tests) == (4 if still else 8)
    assert others == [gap[1:]] * (5 if still else 0)


def test_a_marker_that_is_lost_whenever_it_moves_is_tested_on_others_that_are_missing_wherever_it_is():
    motion = rested()
    lost = [Gap(4, a, a + 18) for a in range(205, 440, 20)]  # it is never seen in motion
    hidden = motion.hidden(lost)
    drawn = draw_hold_out_gaps(hidden, lost, per_gap=4, seed=0)
    others = [test for test in drawn.tests if not test.own]
    assert len({test.of for test in others}) > 0.7 * len(lost)
    for test in others:
        copy = hidden.hidden(drawn.copies[test.copy])
        assert np.isnan(copy.xyz[test.window.marker][~hidden.seen[4]]).all()
        assert test.window[1:] == lost[test.of][1:]
    for test in others:  # and nothing else is hidden beside a window
        edges = [test.window.start - 1, test.window.stop]
        assert np.isfinite(hidden.hidden(drawn.copies[test.copy]).xyz[test.window.marker, edges]).all()


@pytest.mark.parametrize("seed", [1, 2])
def test_where_drop_out_goes_with_motion_the_expected_error_is_the_true_one(seed):
    """Judged by windows at rest, a quarter to a third of the true error was expected."""
    motion = rested(seed=seed)
    gaps = lost_in_motion(motion, range(0, 20, 3), 200)
    found = fill(trial(motion.hidden(gaps)), limit_mm=np.inf)
    error = np.linalg.norm(found.trajectories.xyz - motion.xyz, axis=-1)
    true = np.array([error[motion.names.index(g.marker), g.start : g.stop].mean() for g in found.gaps])
    expected = np.array([g.expected_mm for g in found.gaps])
    assert len(gaps) > 20 and np.nanmax([g.motion_ratio for g in found.gaps]) < 2
    assert 0.6 < np.exp(np.mean(np.log(expected / true))) < 1.7
    assert 0.5 < expected.mean() / true.mean() < 2


class TestSlope:
    def test_it_is_that_of_the_tests_where_they_differ_and_the_usual_one_where_not(self):
        x = np.linspace(-3, 3, 200)
        assert slope(x, 0.3 * x + 5) == pytest.approx(0.3, abs=0.01)
        assert slope(np.zeros(9), np.random.default_rng(0).normal(size=9)) == SLOPE
        assert slope(x, -x) == 0 and slope(x, 9 * x) == STEEPEST
        assert slope(np.full(3, np.nan), np.ones(3)) == SLOPE
        assert slope(np.append(x, np.nan), np.append(0.3 * x, 7.0)) == pytest.approx(0.3, abs=0.01)


def test_a_silent_method_is_expected_to_be_worse_in_more_motion():
    amount, nothing = np.geomspace(1, 30, 30), np.full((20, 3, 3), np.nan)
    tests = [HoldOutGap(0, k, Gap(0, 40 * k, 40 * k + 20), (0, 20), True, m) for k, m in enumerate(amount)]
    results = [
        HoldOutResult(t, np.full((20, 3), m / 3**0.5), nothing, np.ones(20)) for t, m in zip(tests, amount, strict=True)
    ]
    measured, gap = MeasuredErrors(results), Prediction(np.zeros((20, 3)), nothing)
    assert measured.expect(gap, np.ones(30), 60.0)[0] == pytest.approx(60.0, rel=0.15)
    assert measured.expect(gap, np.ones(30), 0.5)[0] == pytest.approx(0.5, rel=0.15)
