"""A walk on a treadmill is one over ground, seen from the belt."""

from itertools import pairwise

import numpy as np
import pytest

from kinemark.data import Trajectories, Trial
from kinemark.findings.gait_events import of_way
from kinemark.gait import foot_events, marker_points
from kinemark.gait.time_distance import averages, strides
from kinemark.gait.treadmill import STILL, floor_velocity
from kinemark.synth import walking

RATE = 100.0
LENGTHS = ("stride_length", "step_length", "step_width", "speed", "cadence")


def walk(speed, *, seed=1, noise_mm=0.3):
    """(F, 3) mm by name of a walk over ground."""
    subject = walking(duration_s=7.0, rate=RATE, speed_mm_s=speed, seed=seed)
    rng = np.random.default_rng(seed)
    points = marker_points(Trial("walk", subject.trajectories))
    return {name: xyz + rng.normal(0, noise_mm, xyz.shape) for name, xyz in points.items()}


def on_belt(points, speed, direction):
    """The same on a treadmill whose belt runs against the walk, turned about the vertical by so many deg."""
    a = np.radians(direction)
    R = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    back = np.arange(len(points["LHEE"]))[:, None] / RATE * [speed, 0, 0]
    return {name: (xyz - back) @ R.T for name, xyz in points.items()}


def measured(points):
    """Events, floor, and means over the strides of both sides."""
    events = foot_events(Trial("walk", Trajectories((), RATE)), points)
    floor = floor_velocity(events, points, rate=RATE)
    found = strides(events, points, rate=RATE, floor=floor)
    return found, floor, {side: averages(found, side) for side in ("left", "right")}


@pytest.mark.parametrize(("speed", "direction"), [(600.0, 0.0), (1200.0, 130.0), (1500.0, -90.0)])
def test_lengths_and_speed_count_from_the_belt(speed, direction):
    ground = walk(speed)
    _, still, there = measured(ground)
    found, floor, here = measured(on_belt(ground, speed, direction))
    assert still is STILL and floor.moves
    assert np.linalg.norm(floor.velocity) == pytest.approx(speed, rel=0.02)
    for side in ("left", "right"):
        for name in LENGTHS:
            assert here[side][name][0] == pytest.approx(there[side][name][0], rel=0.02, abs=3), name
    errors = [(s.values["speed"] - speed) / s.sd["speed"] for s in found]
    assert np.sqrt(np.nanmean(np.square(errors))) < 1.6


@pytest.mark.parametrize("share", [-0.5, 0.5, 0.85])
def test_an_owner_may_move_over_a_belt(share):
    """One at half the belt's speed had strides of half their length, and one who fell back strides of twice it."""
    ground = walk(1200.0, seed=5)
    _, _, there = measured(ground)
    _, floor, here = measured(on_belt(ground, 1200.0 * (1 - share), 40.0))
    assert np.linalg.norm(floor.velocity) == pytest.approx(1200.0 * (1 - share), rel=0.03)
    for side in ("left", "right"):
        for name in LENGTHS:
            assert here[side][name][0] == pytest.approx(there[side][name][0], rel=0.01, abs=3), name


def test_toes_that_stand_are_on_no_belt():
    """Heels of one who lets them down go back, against the swing."""
    points = walk(600.0)
    events = foot_events(Trial("walk", Trajectories((), RATE)), points)
    assert floor_velocity(events, on_toes(points, events, -250.0), rate=RATE) is STILL


def split(points, factor):
    """The left foot goes to and fro by so much more: its belt is as much faster, strikes and offs are the same."""
    to_and_fro = (points["LHEE"] - points["LHEE"].mean(0)) * [1, 0, 0]
    return {n: xyz + (factor - 1) * to_and_fro * (n in ("LHEE", "LTOE", "LANK")) for n, xyz in points.items()}


@pytest.mark.parametrize(("speed", "factor", "seed"), [(600.0, 2.0, 1), (1200.0, 1.2, 2), (1200.0, 0.6, 3)])
def test_each_foot_has_the_speed_of_its_own_belt(speed, factor, seed):
    """Steps are from heel to heel at a strike, as the laboratory sees them, for then the other foot has not left."""
    points = split(on_belt(walk(speed, seed=seed), speed, 0.0), factor)
    found, floor, means = measured(points)
    told = next(of_way("walk", "level", floor)).values
    for side, own in (("left", factor * speed), ("right", speed)):
        assert np.linalg.norm(floor.below(side)) == pytest.approx(own, rel=0.03)
        assert told[f"{side}_speed"] == pytest.approx(own / 1000, rel=0.03)
        assert means[side]["speed"][0] == pytest.approx(own, rel=0.03)
        assert means[side]["stride_length"][0] == pytest.approx(own * means[side]["stride_time"][0], rel=0.03)
        struck = [round(s.last * RATE) for s in found if s.side == side]
        heel, other = (points[letter + "HEE"][struck, 0] for letter in (("L", "R") if side == "left" else ("R", "L")))
        assert means[side]["step_length"][0] == pytest.approx((heel - other).mean(), abs=60)
        assert max(s.sd["speed"] for s in found if s.side == side) < 0.1 * own


def test_one_belt_is_one():
    _, floor, _ = measured(on_belt(walk(1200.0), 1200.0, 0.0))
    assert not floor.belts and next(of_way("walk", "level", floor)).values["left_speed"] is None


def early_heel(points, mm):
    """The left heel goes forwards and up by so much from early stance on, as of a foot that comes onto its toes."""
    events = foot_events(Trial("walk", Trajectories((), RATE)), points)
    own = sorted((e for e in events if e.side == "left"), key=lambda e: e.time)
    heel, t = points["LHEE"].copy(), np.arange(len(points["LHEE"])) / RATE
    for strike, off in pairwise(own):
        if strike.strike and not off.strike:
            share = np.clip(((t - strike.time) / (off.time - strike.time) - 0.15) / 0.85, 0, 1)
            heel += (mm * share * np.clip(1 - (t - off.time) / 0.3, 0, 1))[:, None] * [1.0, 0.0, 0.6]
    return points | {"LHEE": heel}


@pytest.mark.parametrize(("speed", "seed"), [(500.0, 1), (1200.0, 2)])
def test_a_heel_that_rises_early_is_no_belt_of_its_own(speed, seed):
    ground = early_heel(walk(speed, seed=seed), 80.0)
    _, floor, _ = measured(on_belt(ground, speed, 0.0))
    assert floor.moves and not floor.belts
    without_toes = {n: xyz for n, xyz in on_belt(ground, speed, 0.0).items() if "TOE" not in n}
    events = foot_events(Trial("walk", Trajectories((), RATE)), on_belt(ground, speed, 0.0))
    assert floor_velocity(events, without_toes, rate=RATE).belts  # heels alone say two


def test_a_belt_that_is_sped_up_is_known_worse():
    ground = walk(1200.0)
    t = np.arange(len(ground["LHEE"]))[:, None] / RATE
    faster = {name: xyz - (1100 * t + 15 * t**2) * [1, 0, 0] for name, xyz in ground.items()}
    _, steady, _ = measured(on_belt(ground, 1200.0, 0.0))
    _, sped, _ = measured(faster)
    assert sped.sd > 40 > 2 * steady.sd


@pytest.mark.parametrize("forwards", [0.0, 200.0, 500.0])
def test_over_ground_a_heel_that_goes_forwards_on_the_toes_is_no_belt(forwards):
    points = walk(600.0)
    events = foot_events(Trial("walk", Trajectories((), RATE)), points)
    assert floor_velocity(events, on_toes(points, events, forwards), rate=RATE) is STILL


def test_a_foot_that_strikes_once_tells_no_belt():
    points = walk(600.0)
    events = foot_events(Trial("walk", Trajectories((), RATE)), points)
    once = [next(e for e in events if e.side == "left" and e.strike)]
    once += [next(e for e in events if e.side == "left" and not e.strike and e.time > once[0].time)]
    assert floor_velocity(once, on_toes(points, events, 500.0), rate=RATE) is STILL


def on_toes(points, events, forwards):
    """The same with heels that go forwards by so many mm/s in each stance, as they rise over the toes."""
    moved = dict(points)
    for side, heel in (("left", "LHEE"), ("right", "RHEE")):
        times = np.array(sorted(e.time for e in events if e.side == side))
        gone = [0.0 if e.strike else forwards for e in sorted(events, key=lambda e: e.time) if e.side == side]
        stance = np.r_[0.0, np.diff(times)] * gone
        off = np.interp(np.arange(len(points[heel])) / RATE, times, stance)
        moved[heel] = points[heel] + off[:, None] * [1.0, 0.0, 0.0]
    return moved


def test_without_events_the_floor_stands_still():
    assert floor_velocity((), walk(1200.0), rate=RATE) is STILL


def test_heels_that_sit_elsewhere_change_steps_and_no_stride():
    points = walk(1200.0)
    events = foot_events(Trial("walk", Trajectories((), RATE)), points)
    aside = {**points, "LHEE": points["LHEE"] + (5.0, -5.0, 0.0)}
    plain, sure, moved = (
        strides(events, at, rate=RATE, placement_mm=mm) for at, mm in ((points, 0.0), (points, 5.0), (aside, 0.0))
    )
    for a, b, c in zip(plain, sure, moved, strict=True):
        assert abs(c.values["step_width"] - a.values["step_width"]) == pytest.approx(5.0, abs=0.3)
        assert b.sd["step_width"] == pytest.approx(np.sqrt(50)) and a.sd["step_width"] == 0.0
        assert b.systematic["step_length"] == pytest.approx(np.sqrt(50))
        assert b.sd["stride_length"] == a.sd["stride_length"] and b.systematic["stride_length"] == 0.0
        assert c.values["stride_length"] == pytest.approx(a.values["stride_length"], abs=0.1)
        assert of_one_heel(b) == of_one_heel(a)


def of_one_heel(stride):
    """What does not hang on where heels sit."""
    return {name: sd for name, sd in stride.sd.items() if name not in ("step_length", "step_width")}
