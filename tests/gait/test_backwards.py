"""Who walks backwards is told, and measured as who walks forwards: a walk with time turned is the nearest to it."""

import numpy as np
import pytest

from kinemark.data import Trajectories, Trial
from kinemark.data.strides import UNITS
from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.gait import clinical_angles, foot_events, lower_limbs, marker_points, standard_trial
from kinemark.gait.backwards import reversals, walks_backwards
from kinemark.gait.progression import way_walked
from kinemark.gait.time_distance import averages, strides
from kinemark.gait.treadmill import floor_velocity
from kinemark.gait.turning import with_counts, with_facing
from kinemark.gait.way_of_walking import way_of_walking
from kinemark.synth import walking
from support.plug_in_gait import trial

RATE = 100.0
LEG = LegMeasures(leg_mm=900.0, knee_mm=105.0, ankle_mm=75.0)
MEASURES = SubjectMeasures(LEG, LEG)


def walk(speed, *, belt=False, seed=3):
    """(F, 3) mm by name, on a belt that runs against the walk where there is one."""
    points = marker_points(Trial("walk", walking(duration_s=7.0, rate=RATE, speed_mm_s=speed, seed=seed).trajectories))
    back = np.arange(len(points["LHEE"]))[:, None] / RATE * [speed * belt, 0, 0]
    rng = np.random.default_rng(seed)
    return {name: xyz - back + rng.normal(0, 0.3, xyz.shape) for name, xyz in points.items()}


def turned(points):
    return {name: xyz[::-1].copy() for name, xyz in points.items()}


def measured(points, rate=RATE):
    events = foot_events(Trial("walk", Trajectories((), rate)), points)
    floor = floor_velocity(events, points, rate=rate)
    found = strides(events, points, rate=rate, floor=floor)
    return events, floor, averages(found, "left")


@pytest.mark.parametrize("belt", [False, True])
@pytest.mark.parametrize("speed", [700.0, 1300.0])
def test_backwards_over_ground_and_on_a_belt(speed, belt):
    forward = walk(speed, belt=belt)
    points = turned(forward)
    assert walks_backwards(points) and not walks_backwards(forward)
    events, floor, found = measured(points)
    assert way_of_walking(events, points, rate=RATE) == "backward"
    assert floor.moves == belt
    assert found["speed"][0] == pytest.approx(speed, rel=0.03)
    assert found["foot_off"][0] == pytest.approx(measured(forward)[2]["foot_off"][0], abs=2.0)
    assert all(abs(np.gradient(points["LHEE"][:, 2])[round(e.time * RATE)]) < 20 for e in events if e.side == "left")


@pytest.mark.parametrize(("belt", "first"), [(False, "there"), (False, "back"), (True, "there")])
def test_to_and_fro_in_one_trial(belt, first):
    """Without turning round; on a belt the same is a walk one way, whatever the subject drifts."""
    forward = walk(1100.0, belt=belt)
    drift = np.r_[0:700, 699:-1:-1][:, None] * [1.5 * belt, 0, 0]
    order = (1, -1) if first == "there" else (-1, 1)
    points = {
        name: np.concatenate([xyz[:: order[0]], xyz[:: 1 if belt else order[1]]]) + drift
        for name, xyz in forward.items()
    }
    events = foot_events(Trial("walk", Trajectories((), RATE)), points)
    assert way_of_walking(events, points, rate=RATE) == ("level" if belt else "to and fro")
    assert abs(reversals(points) - 700).max(initial=0) < 30 and len(reversals(points)) == (not belt)
    if belt:
        return
    steps = strides(events, points, rate=RATE)
    found = with_facing(steps, lower_limbs(points, MEASURES).pelvis.R[..., 0], rate=RATE, back=reversals(points))
    (counted,) = with_counts([found])
    straight = [one for one in counted if one.counts]
    assert len(straight) >= len(counted) - 4 and all(abs(one.turned_deg) == 180 for one in counted if not one.counts)
    alone = measured(forward)[2]
    for one in straight:
        assert one.values["speed"] == pytest.approx(1100, rel=0.03)
        assert one.values["foot_off"] == pytest.approx(alone["foot_off"][0], abs=2.0)


def test_a_recorded_walk_turned_in_time_keeps_its_parameters():
    walked = standard_trial(trial("pig_gait_child/HC030A05.c3d")).trial
    points, rate = marker_points(walked), walked.trajectories.rate
    there, back = (measured(one, rate)[2] for one in (points, turned(points)))
    for name in set(UNITS) - {"step_width", "step_length"}:  # of steps that begin elsewhere
        assert back[name][0] == pytest.approx(there[name][0], rel=0.06, abs=2.0 if "foot" in name else 0.02), name


def test_angles_are_seen_from_where_the_subject_faces():
    points = walk(1200.0)
    back = lower_limbs(turned(points), MEASURES)
    there = lower_limbs(points, MEASURES)
    seen = clinical_angles(back, lab=way_walked(back, rate=RATE))
    true = clinical_angles(there, lab=way_walked(there, rate=RATE))
    for name in ("LPelvisAngles", "RFootProgressAngles"):
        assert np.abs(seen[name][::-1] - true[name]).max() < 0.01, name


def test_nothing_is_known_of_who_stands_or_of_markers_that_are_not_there():
    points = walk(1200.0)
    assert not walks_backwards({name: np.repeat(xyz[:1], 50, 0) for name, xyz in points.items()})
    assert not walks_backwards({name: xyz for name, xyz in points.items() if name != "LASI"})
