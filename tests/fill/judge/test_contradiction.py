"""A gap stays open where the fill's own deviation or a jump contradicts the error expected of it."""

import numpy as np
import pytest

from kinemark.fill import PCA, Body, Gap, MarkerArray, fill
from kinemark.fill.judge.contradiction import contradicts_jump, contradicts_sd, largest_jump, largest_sd
from support.filling import moving, trial

GAP = Gap(0, 100, 140)


def slipped():
    """A body whose first marker slides 60 mm aside and back, about its gap."""
    motion = moving(3000, noise=0.2)
    xyz = motion.xyz.copy()
    xyz[0, :, 0] += 60.0 * np.clip((60 - np.abs(np.arange(3000) - 120.0)) / 15, 0, 1)
    return motion._replace(xyz=xyz).hidden([GAP])


def struck(frames=400):
    """Markers at rest, but in the first one's gap each goes its own way by up to half a metre."""
    rng = np.random.default_rng(3)
    there = rng.normal(0, 100, (8, 1, 3)) + rng.normal(0, 0.2, (8, frames, 3))
    stroke = np.zeros((frames, 1))
    stroke[105:195, 0] = np.sin(np.linspace(0, np.pi, 90)) ** 2
    ways = rng.normal(0, 250, (8, 1, 3))
    xyz = there + stroke * ways
    return MarkerArray(xyz, 100.0, tuple(f"M{k}" for k in range(8))).hidden([Gap(0, 100, 200)])


class TestFigures:
    def test_a_jump_is_measured_whatever_the_speed(self):
        t = np.arange(200.0)[:, None]
        for speed in (0.0, 30.0):
            path = t * [speed, 0, 0]
            motion = MarkerArray(path[None], 100.0, ("a",))
            fill_ = path[100:140] + np.array([0, 25.0, 0])
            assert largest_jump(motion.hidden([GAP]), GAP, fill_, ()) == pytest.approx(25)
            assert largest_jump(motion.hidden([GAP]), GAP, path[100:140], ()) == pytest.approx(0)

    def test_a_movement_that_the_reference_markers_make_too_is_no_jump(self):
        path = np.zeros((2, 200, 3))
        path[:, 120:, 0] = 40.0
        motion = MarkerArray(path, 100.0, ("a", "b"))
        assert largest_jump(motion.hidden([GAP]), GAP, path[0, 100:140], (1,)) == pytest.approx(0)
        assert largest_jump(motion.hidden([GAP]), GAP, path[0, 100:140], ()) == pytest.approx(40)

    def test_at_the_ends_of_a_trial_and_with_nothing_known(self):
        path = np.zeros((1, 50, 3))
        motion = MarkerArray(path, 100.0, ("a",))
        for gap in (Gap(0, 0, 10), Gap(0, 40, 50), Gap(0, 0, 50)):
            assert largest_jump(motion.hidden([gap]), gap, path[0, gap.start : gap.stop], ()) == 0
        assert np.isnan(largest_sd(np.full((4, 3, 3), np.nan)))
        assert largest_sd(np.diag([1.0, 9.0, 4.0])[None]) == 3

    def test_a_contradiction_wants_both_a_ratio_and_a_size_and_an_infinite_limit_asks_for_none(self):
        assert contradicts_sd(716.0, 4.0, 20.0) and not contradicts_sd(19.0, 1.0, 20.0)
        assert not contradicts_sd(40.0, 15.0, 20.0) and not contradicts_sd(716.0, 4.0, np.inf)
        assert contradicts_jump(33.0, 4.0, 20.0, 20.0) and not contradicts_jump(4.0, 0.5, 20.0, 20.0)
        assert contradicts_jump(4.0, 0.5, 20.0, 2.0)  # of something small
        assert not contradicts_jump(33.0, 15.0, 20.0, 20.0) and not contradicts_jump(33.0, 4.0, np.inf, 20.0)
        assert not contradicts_sd(np.nan, 4.0, 20.0)


def test_a_fill_that_jumps_stays_open_with_its_reason():
    motion = slipped()
    (gap,) = fill(trial(motion), method=PCA(bridge_residuals=False)).gaps
    assert (gap.method, gap.state) == ("", "jump_contradicts")
    assert gap.jump_mm > 20 > gap.expected_mm
    (kept,) = fill(trial(motion), method=PCA(bridge_residuals=False), limit_mm=np.inf).gaps
    assert kept.state == "filled"


def test_a_fill_whose_deviation_is_far_above_its_expected_error_stays_open():
    (gap,) = fill(trial(struck()), method=Body()).gaps
    assert gap.method == "" and gap.state in ("sd_contradicts", "above_limit")


def test_a_good_fill_contradicts_nothing():
    motion = moving(300, soft=4.0, noise=0.2).hidden([GAP])
    (gap,) = fill(trial(motion), method=Body()).gaps
    assert gap.state == "filled" and gap.jump_mm < 3 and gap.sd_mm < 5 * gap.expected_mm
