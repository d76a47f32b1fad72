"""A gap stays open where the marker is elsewhere on its body after it than before."""

import numpy as np
import pytest

from kinemark.fill import Gap, MarkerArray, RigidBody, fill
from kinemark.fill.judge.two_sides import apart_on_the_body
from kinemark.findings.gaps import filling_figures
from kinemark.report.words import text_of
from support.filling import swaying, trial
from support.findings import found

GAP = Gap(0, 300, 330)


def on_a_body(bend=2.0, markers=6, seed=1):
    """A body whose markers move on it by some mm, and (F, 3, 3) its turn."""
    motion, _ = swaying(markers, bend=bend, seed=seed)
    xyz = motion.xyz
    a, b = xyz[1] - xyz[2], xyz[3] - xyz[2]
    a, normal = a / np.linalg.norm(a, axis=1)[:, None], np.cross(a, b)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return motion, np.stack([a, normal, np.cross(normal, a)], axis=2)


def elsewhere(motion, turn, by, frames, marker=0):
    """The same with a marker that lies elsewhere on the body in some frames."""
    xyz = motion.xyz.copy()
    xyz[marker, frames] += turn[frames] @ np.asarray(by, float)
    return motion._replace(xyz=xyz)


def exchanged(motion, one, other, frames):
    xyz = motion.xyz.copy()
    xyz[[one, other], frames] = xyz[[other, one], frames]
    return motion._replace(xyz=xyz)


class TestApart:
    @pytest.mark.parametrize("seed", range(5))
    @pytest.mark.parametrize("by", [(30, 0, 0), (0, 60, 0), (0, 0, 150)])
    def test_a_marker_that_is_put_on_anew_is_told_by_how_much(self, by, seed):
        motion, turn = on_a_body(seed=seed)
        moved = elsewhere(motion, turn, by, slice(330, None)).hidden([GAP])
        assert apart_on_the_body(moved, GAP) == pytest.approx(np.linalg.norm(by), abs=8)

    @pytest.mark.parametrize("scale", [0.1, 10.0])
    def test_animals_of_any_size_and_lengths_in_any_unit_are_told_alike(self, scale):
        motion, turn = on_a_body()
        for by in (0, 12, 30):
            moved = elsewhere(motion, turn, (by, 0, 0), slice(330, None)).hidden([GAP])
            other = moved._replace(xyz=scale * moved.xyz)
            assert apart_on_the_body(other, GAP) == pytest.approx(scale * apart_on_the_body(moved, GAP))

    @pytest.mark.parametrize("seed", range(20))
    def test_a_marker_that_stays_is_not_however_long_the_gap(self, seed):
        motion, _ = on_a_body(bend=10.0, seed=seed)
        for gap in (Gap(0, 300, 302), GAP, Gap(0, 200, 400), Gap(0, 8, 60), Gap(0, 540, 590)):
            assert apart_on_the_body(motion.hidden([gap]), gap) == 0

    @pytest.mark.parametrize("seed", range(5))
    def test_another_marker_after_the_gap_is_told_also_where_it_is_a_reference(self, seed):
        motion, _ = on_a_body(seed=seed)
        assert apart_on_the_body(exchanged(motion, 0, 1, slice(330, None)).hidden([GAP]), GAP) > 30

    def test_a_marker_that_is_another_only_up_to_its_next_gap_is_told(self):
        motion, turn = on_a_body()
        moved = elsewhere(motion, turn, (100, 0, 0), slice(330, 370)).hidden([GAP, Gap(0, 370, 380)])
        assert apart_on_the_body(moved, GAP) == pytest.approx(100, abs=8)

    def test_a_reference_that_moves_in_the_gap_is_not_laid_on_the_marker(self):
        motion, turn = on_a_body()
        for other in range(1, 6):
            moved = elsewhere(motion, turn, (100, 50, 0), slice(310, None), other).hidden([GAP])
            assert apart_on_the_body(moved, GAP) == 0

    def test_two_others_on_a_line_at_rest_or_few_frames_tell_nothing(self):
        motion, turn = on_a_body()
        moved = elsewhere(motion, turn, (150, 0, 0), slice(330, None)).hidden([GAP])
        few = MarkerArray(moved.xyz[:3], moved.rate, moved.names[:3])
        ghost = moved.hidden([Gap(0, 332, 400)])
        line = moved._replace(xyz=np.concatenate([moved.xyz[:1], moved.xyz[1] + np.arange(5)[:, None, None] * 50.0]))
        still = moved._replace(xyz=np.where(np.arange(6)[:, None, None] > 0, moved.xyz[1], moved.xyz))
        assert [apart_on_the_body(one, GAP) for one in (few, ghost, line, still)] == [0, 0, 0, 0]

    def test_at_an_end_of_the_trial_there_is_one_side(self):
        motion, _ = on_a_body()
        for gap in (Gap(0, 0, 50), Gap(0, 500, 600), Gap(0, 0, 600)):
            assert apart_on_the_body(motion.hidden([gap]), gap) == 0


def two_segments(seed=1):
    """A trunk of five markers, 0 to 4, and two plates of four that swing to its front and back; and its turn."""
    motion, turn = on_a_body(bend=0.0, markers=13, seed=seed)
    xyz, t = motion.xyz.copy(), np.arange(600) / 100
    trunk = xyz[:5].mean(0)
    rng = np.random.default_rng(seed)
    for plate, side in ((LEFT, 150.0), (RIGHT, -150.0)):
        swing = np.stack([200 * np.sin(5 * t + side), side + 5 * np.sin(3 * t), -400 + 20 * np.cos(5 * t)], 1)
        local = swing + rng.normal(0, 40, (4, 1, 3))
        xyz[plate] = trunk + np.einsum("fij,mfj->mfi", turn, local) + rng.normal(0, 0.2, (4, 600, 3))
    return motion._replace(xyz=xyz), turn


LEFT, RIGHT = [5, 6, 7, 8], [9, 10, 11, 12]
AFTER = slice(GAP.stop, None)


class TestSegments:
    @pytest.mark.parametrize("seed", range(5))
    def test_plates_that_are_exchanged_in_a_common_gap_are_told_by_markers_seen_throughout(self, seed):
        motion, _ = two_segments(seed)
        swapped = exchanged(motion, LEFT, RIGHT, AFTER)
        lost = [GAP._replace(marker=k) for k in LEFT + RIGHT]
        told = [apart_on_the_body(swapped.hidden(lost), gap) > 0 for gap in lost]
        assert np.mean(told) > 0.7
        assert not any(apart_on_the_body(motion.hidden(lost), gap) for gap in lost)

    @pytest.mark.parametrize("seed", range(5))
    def test_so_is_a_plate_that_slips(self, seed):
        motion, turn = two_segments(seed)
        lost = [GAP._replace(marker=k) for k in LEFT]
        for k in LEFT:
            motion = elsewhere(motion, turn, (0, 120, 0), AFTER, k)
        assert np.mean([apart_on_the_body(motion.hidden(lost), gap) > 100 for gap in lost]) > 0.7

    @pytest.mark.parametrize("seed", range(5))
    def test_the_three_others_of_a_wand_that_are_seen_throughout_tell(self, seed):
        motion, turn = on_a_body(markers=4, seed=seed, bend=0.5)
        moved = elsewhere(motion, turn, (60, 0, 0), AFTER)
        assert apart_on_the_body(moved.hidden([GAP]), GAP) == pytest.approx(60, abs=8)
        assert apart_on_the_body(motion.hidden([GAP]), GAP) == 0


def test_the_gap_stays_open_and_is_told_and_an_infinite_limit_fills_it():
    motion, turn = on_a_body()
    moved = trial(elsewhere(motion, turn, (0, 0, 150), slice(330, None)).hidden([GAP, Gap(2, 100, 120)]))
    filled = fill(moved, method=RigidBody())
    states = {gap.marker: gap.state for gap in filled.gaps}
    assert states == {"M0": "sides_contradict", "M2": "filled"}
    (said,) = found(
        filling_figures(filled, moved, source="t", method="rigid_body", limit_mm=20.0), "gap_sides_contradict"
    )
    assert (said.markers, said.frames) == (("M0",), ((301, 330),))  # a trial counts from 1
    assert "M0 301–330, 15" in text_of(said) and "mm apart" in text_of(said)
    assert all(gap.method for gap in fill(moved, method=RigidBody(), limit_mm=np.inf).gaps)
