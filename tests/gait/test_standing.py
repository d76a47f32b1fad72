"""Who stands, sways or steps on the spot does not walk; who shuffles does."""

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories, Trial
from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.walks import KnownMeasures, Recorded, subject_gait
from kinemark.findings.gait import gait_figures
from kinemark.findings.gait_records import MeasuredSubject
from kinemark.gait.foot_events import foot_events
from kinemark.gait.standard_trial import standard_trial
from kinemark.gait.standing import stands, with_standing
from kinemark.gait.time_distance import strides
from kinemark.gait.treadmill import floor_velocity
from kinemark.report.gait_page import time_distance_table
from kinemark.synth import WalkingBody

RATE = 100.0
LEG = LegMeasures(890.0, 105.0, 72.0)
BODY = WalkingBody(SubjectMeasures(LEG, LEG, mass_kg=70.0))
FEET = ("HEE", "TOE")


def walk(time):
    """Markers (F, 3) mm by name of a walk at times of its own (F) s."""
    return BODY.markers(BODY.limbs(time))


def trial_of(points, name="walk"):
    return Trial(name, Trajectories(tuple(MarkerTrajectory.measured(k, x) for k, x in points.items()), RATE))


def halting(*, at, for_s, duration_s=9.0):
    """A walk that halts with both feet on the floor, `at` strides after its beginning."""
    clock = np.arange(round(duration_s * RATE)) / RATE
    halt = at * BODY.period
    return walk(np.where(clock < halt, clock, np.maximum(halt, clock - for_s)))


def told(points):
    """Strides as they are told, and when the subject stands."""
    events = foot_events(trial_of(points), points)
    floor = floor_velocity(events, points, rate=RATE)
    found = stands(events, points, rate=RATE, floor=floor)
    return with_standing(strides(events, points, rate=RATE, floor=floor), found), found


@pytest.mark.parametrize("for_s", [1.0, 3.0])
def test_strides_in_which_the_subject_stands_are_left_out_and_told(for_s):
    points = halting(at=2.95, for_s=for_s)
    own = Recorded("walk", trial_of(points), standard_trial(trial_of(points)))
    found = subject_gait([own], KnownMeasures(BODY.measures), None, GaitSettings(uncertainty=False))
    figures = gait_figures(found.trials, found.curves, {}, subject=MeasuredSubject("", BODY.measures), method={})
    left_out = [one for one in found.trials[0].strides if not one.counts]
    halt = 2.95 * BODY.period
    assert len(left_out) >= 2 and all(one.first < halt + for_s and one.last > halt - 0.2 for one in left_out)
    for side in ("left", "right"):
        mean = figures["time_distance"][side]
        assert mean["stride_time"]["mean"] == pytest.approx(BODY.period, rel=0.02)
        assert mean["speed"]["mean"] == pytest.approx(BODY.speed_mm_s, rel=0.03)
    n = [figures["time_distance"][side]["speed"]["strides"] for side in ("left", "right")]
    assert [f"{side}: mean ± SD of {k} strides" for side, k in zip(("left", "right"), n, strict=True)] == (
        time_distance_table(figures).head[1:4:2]
    )
    lone = {name: one | {"strides": 1, "spread": None} for name, one in figures["time_distance"]["left"].items()}
    alone = figures | {"time_distance": figures["time_distance"] | {"left": lone}}
    assert time_distance_table(alone).head[1] == "left: 1 stride"
    kinds = {one["kind"]: one["values"] for one in figures["findings"]}
    assert kinds["gait_stands_left_out"]["left_out"] == len(left_out)


@pytest.mark.parametrize("for_s", [0.0, 0.3])
def test_who_walks_on_or_hesitates_does_not_stand(for_s):
    found, when = told(halting(at=2.95, for_s=for_s))
    assert len(found) > 5 and not when and not any(one.stands for one in found)


def moved(points, share, lift):
    """A walk whose feet and pelvis go a share of their way, and whose feet are lifted by a share."""
    still = BODY.markers(BODY.standing(1))
    out = {}
    for side in "LR":
        middle = (points[side + "HEE"] + points[side + "TOE"]) / 2
        way = (middle - middle[:1]) * (share, share, lift)
        out |= {name: still[name] + way for name in still if name[0] == side and name[1:] != "ASI"}
    pelvis = (points["SACR"] - points["SACR"][:1]) * (share, share, 0.0)
    return out | {name: still[name] + pelvis for name in ("LASI", "RASI", "SACR")}


def test_steps_of_five_centimetres_are_steps():
    found, _ = told(moved(walk(np.arange(800) / RATE), 100 / BODY.path.length, 0.1))
    assert len(found) >= 10 and not any(one.stands for one in found)
    assert np.median([one.values["stride_length"] for one in found]) == pytest.approx(100.0, abs=5.0)


@pytest.mark.parametrize("way", ["sways", "sits down"])
def test_a_pelvis_that_moves_over_feet_that_stay_makes_no_strides(way):
    points = {name: np.repeat(xyz, 1000, axis=0) for name, xyz in BODY.markers(BODY.standing(1)).items()}
    wave = np.sin(2 * np.pi * 0.3 * np.arange(1000) / RATE)
    for name in ("LASI", "RASI", "SACR"):
        points[name] = points[name] + wave[:, None] * ((80.0, 0, 0) if way == "sways" else (150.0, 0, 200.0))
    assert not foot_events(trial_of(points), points)


def test_steps_on_the_spot_are_no_strides():
    points = walk(np.arange(600) / RATE)
    there = {name: xyz - points["SACR"] * (1, 0, 0) for name, xyz in points.items()}  # feet go to and fro below it
    events = foot_events(trial_of(there), there)
    found = with_standing(strides(events, there, rate=RATE), ())
    assert len(found) > 4 and all(one.stands for one in found)
