"""A subject who walks there and back in one trial is measured on both ways as on one."""

import time
from functools import cache

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories, Trial
from kinemark.data.strides import Stride
from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.walks import KnownMeasures, Recorded, subject_gait
from kinemark.findings.gait import gait_figures
from kinemark.findings.gait_records import MeasuredSubject
from kinemark.gait import StandardTrial, clinical_angles, lower_limbs
from kinemark.gait.progression import way_walked
from kinemark.gait.straight_passes import straight_passes
from kinemark.gait.turning import ways, with_counts, with_facing
from kinemark.report.gait_page import ways_table
from kinemark.synth.gait_body import WalkingBody
from support.there_and_back import there_and_back

LEG = LegMeasures(leg_mm=900.0, knee_mm=105.0, ankle_mm=75.0)
MEASURES = SubjectMeasures(LEG, LEG, mass_kg=70.0)
RATE = 100.0
WALKS = {
    "there and back": (1150.0, {"duration_s": 9.0, "turn_s": (4.0, 5.2)}),
    "farther there than back, on one line": (1150.0, {"duration_s": 9.0, "turn_s": (6.0, 7.2), "on_the_spot": True}),
    "slowly, across the laboratory": (700.0, {"duration_s": 12.0, "turn_s": (4.5, 6.0), "heading_deg": 110.0}),
}


@cache
def walked(name):
    speed, how = WALKS[name]
    return there_and_back(WalkingBody(MEASURES, speed_mm_s=speed), rate=RATE, **how)


@pytest.mark.parametrize("name", WALKS)
def test_pelvis_and_feet_are_seen_from_the_way_there_and_from_the_way_back(name):
    true_limbs, straight_points, points = walked(name)
    limbs = lower_limbs(points, MEASURES)
    found, true = clinical_angles(limbs, lab=way_walked(limbs, rate=RATE)), clinical_angles(true_limbs)
    turn = WALKS[name][1]["turn_s"]
    t = np.arange(len(limbs.pelvis.origin)) / RATE
    straight = (t < turn[0] - 0.3) | (t > turn[1] + 0.3)
    for angle in ("LPelvisAngles", "RPelvisAngles"):
        assert np.abs(found[angle] - true[angle])[straight].max() < 2.0, angle
    foot = clinical_angles(lower_limbs(straight_points, MEASURES))
    for angle in ("LFootProgressAngles", "RFootProgressAngles"):
        assert np.abs(found[angle] - foot[angle])[straight].max() < 2.0, angle


@cache
def analysed(name):
    points = walked(name)[-1]
    paths = tuple(MarkerTrajectory.measured(marker, xyz) for marker, xyz in points.items())
    trial = Trial("walk", Trajectories(paths, RATE))
    own = Recorded("walk", trial, StandardTrial(trial, np.eye(3), {}))
    found = subject_gait([own], KnownMeasures(MEASURES), None, GaitSettings(uncertainty=False))
    return found, gait_figures(found.trials, found.curves, {}, subject=MeasuredSubject("", MEASURES), method={})


@pytest.mark.parametrize("name", WALKS)
def test_strides_that_turn_are_left_out_and_both_ways_are_told(name):
    found, figures = analysed(name)
    length = WalkingBody(MEASURES).path.length
    strides = found.trials[0].strides
    left_out = [one for one in strides if not one.counts]
    turn = WALKS[name][1]["turn_s"]
    assert left_out and all(one.last > turn[0] and one.first < turn[1] for one in left_out)
    for side in ("left", "right"):
        mean = figures["time_distance"][side]
        assert mean["stride_length"]["mean"] == pytest.approx(length, rel=0.01)
        assert mean["step_width"]["mean"] < 60.0
        assert mean["step_length"]["mean"] == pytest.approx(length / 2, rel=0.02)
        for way in figures["ways"]:
            assert way["time_distance"][side]["stride_length"]["mean"] == pytest.approx(length, rel=0.02)
    kinds = {one["kind"]: one for one in figures["findings"]}
    assert kinds["gait_turns_left_out"]["values"]["left_out"] == len(left_out)
    assert "gait_ways" in kinds and "gait_turns" not in kinds
    there, back = (way["facing_deg"] for way in figures["ways"])
    assert abs(abs(there - back) - 180.0) < 10.0
    assert len(ways_table(figures).head) == 5


def test_curves_of_both_ways_are_those_of_a_straight_walk():
    found, _ = analysed("there and back")
    pelvis = next(one for one in found.curves if one.name == "LPelvisAngles")
    assert np.nanmax(pelvis.spread) < 1.5


def test_who_turns_in_every_stride_keeps_all_of_them():
    strides = [Stride("left", k, k + 1.0, {}, {}) for k in range(4)]
    turning = [one._replace(turned_deg=40.0) for one in strides]
    assert all(one.counts for one in with_counts([turning])[0])
    assert [one.counts for one in with_counts([turning[:2], strides[2:]])[0]] == [False, False]


def test_ways_are_told_apart_also_across_half_a_turn():
    strides = [
        Stride("left", k, k + 1.0, {}, {}, facing_deg=deg) for k, deg in enumerate((178, 2, -177, -4, 181 - 360))
    ]
    assert [len(own) for own in ways(strides)] == [3, 2]
    unknown = Stride("left", 0.0, 1.0, {}, {})
    assert ways([unknown, *strides]) == [[*strides[::2], unknown], strides[1::2]]
    assert ways([unknown]) == [[unknown]] and ways([]) == []


def test_a_stride_faces_where_the_pelvis_does():
    angle = np.radians(np.linspace(170.0, 210.0, 101))
    x = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    x[40] = np.nan
    one = with_facing([Stride("left", 0.0, 1.0, {}, {})], x, rate=100.0)[0]
    assert one.turned_deg == pytest.approx(40.0) and one.facing_deg == pytest.approx(-170.0)


def test_straight_parts_of_a_way_are_found():
    leg = np.linspace(0, 3000, 300)
    there = np.column_stack([leg, 20 * np.sin(leg / 200), 0 * leg])
    corner = np.concatenate([there, there[-1] + np.column_stack([0 * leg, leg, 0 * leg])])
    corner[100] = np.nan
    found = straight_passes(corner, rate=100.0)
    assert len(found) == 2 and found[0].direction[0] > 0.999 and found[1].direction[1] > 0.999
    assert straight_passes(np.full((9, 3), np.nan), rate=100.0) == ()
    angle = np.linspace(0, 2 * np.pi, 900)
    assert straight_passes(1500 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]), rate=100.0) == ()


def test_long_recordings_are_cut_into_straight_parts_in_a_time_that_grows_as_they_do():
    t = np.arange(0, 600.0, 0.05)
    there_and_back = np.column_stack([4000 * np.abs((t / 8) % 2 - 1), 0 * t, 0 * t])
    begin = time.process_time()
    assert len(straight_passes(there_and_back, rate=20.0)) == 75
    assert time.process_time() - begin < 2.5


def test_who_stands_for_minutes_between_two_ways_takes_no_longer():
    leg, still = np.linspace(0, 3000, 60), np.zeros(16_000)
    x = np.concatenate([leg, 3000 + still, 3000 + 0 * leg])
    y = np.concatenate([0 * leg, 20 * np.sin(np.arange(len(still)) / 9), leg])
    begin = time.process_time()
    found = straight_passes(np.column_stack([x, y, 0 * x]), rate=20.0)
    assert time.process_time() - begin < 2.5
    assert [one.direction.round(1).tolist() for one in found] == [[1, 0, 0], [0, 1, 0]]
