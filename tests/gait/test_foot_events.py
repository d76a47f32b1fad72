"""Foot events: against force plates of real walks, and laws on simulated ones."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinemark.data import Trajectories, Trial
from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.gait import marker_points, standard_trial
from kinemark.gait.foot_detectors import faster, greatest, slower
from kinemark.gait.foot_events import foot_events
from kinemark.gait.foot_motion import foot_motion
from kinemark.gait.plate_events import plate_events
from kinemark.synth import WalkingBody, gait_laboratory, walking
from support.plug_in_gait import CHILDREN, trial

WALKS = [f"{child}{n}.c3d" for child, (_, *walks) in CHILDREN.items() for n in walks]
WALKS += ["pig_gait_3plates_emg/PiG_Motion3_FF.c3d"]
OTHERS = {"qualisys_gait/Gait - CGM2 1.c3d": {}, "gait_emg_ccby/2014001_C1_01.c3d": {},
          "../cameras/gait9_bts/gait9.tdf": {"RHEE": "Mk19", "LHEE": "Mk23"},
          "force_plate_types/TYPE-3.c3d": {}}  # fmt: skip
"""Of other laboratories, two slow walkers among them, and the names of their heels."""


KNOWN_S = 0.010
"""To which a plate must know, or to a sample: one laboratory writes 0 below 50 N."""


def errors(name, step=1, noise_mm=0.0):
    """s, by kind: events from markers alone less those of plates, and what was expected."""
    walk = standard_trial(trial(name), markers=OTHERS.get(name)).trial
    at, rate = marker_points(walk), walk.trajectories.rate
    rng = np.random.default_rng(3)
    seen = {k: x[::step] + noise_mm * rng.normal(size=x[::step].shape) for k, x in at.items()}
    alone = foot_events(Trial("walk", Trajectories((), rate / step)), seen)
    found = {True: [], False: []}
    for event in plate_events(walk, at):
        if not 0.12 < event.time < walk.trajectories.n_frames / rate - 0.12:
            continue  # the recording begins or ends within the step
        if event.sd <= max(KNOWN_S, 1.01 / walk.analog[0].rate):
            same = [e for e in alone if (e.side, e.strike) == (event.side, event.strike)]
            near = min(same, key=lambda e: abs(e.time - event.time))
            found[event.strike].append((near.time - event.time, near.sd))
    return found


@pytest.mark.parametrize(("step", "noise_mm", "share"), [(1, 0.0, 0.95), (2, 0.0, 0.9), (1, 0.5, 0.88)])
def test_events_from_markers_are_those_of_the_plates(step, noise_mm, share):
    """Every recording as it is, at half its rate, and with noise of half a mm."""
    every = [errors(name, step, noise_mm) for name in (*WALKS, *OTHERS)]
    for kind in (True, False):
        off, sd = 1000 * np.concatenate([one[kind] for one in every if one[kind]]).T
        assert len(off) > 20
        assert (np.abs(off) < 15).mean() > share and (np.abs(off) < 40).all()
        least = (
            0.7 if step == 1 else 0.6
        )  # the biases are of all subjects; of the others, strikes of every 2nd frame: 0.68
        assert least < np.sqrt(np.mean((off / sd) ** 2)) < 1.3, "expected errors are true within 30 %"
        if step == 1 and not noise_mm:
            assert abs(np.median(off)) < 3 and np.sqrt(np.mean(off**2)) < 8


def test_a_plate_that_writes_nothing_below_a_threshold_of_its_own_says_how_little_it_knows():
    lab = laboratory()
    at = marker_points(lab.walk)
    true = plate_events(lab.walk, at)
    found = plate_events(replace(lab.walk, analog=tuple(map(gated, lab.walk.analog))), at)
    assert len(found) == len(true) > 2
    off, sd = np.array([(a.time - b.time, a.sd) for a, b in zip(found, true, strict=True)]).T
    assert (np.abs(off) < 2 * sd).all() and (sd > [1.4 * e.sd for e in true]).all()


def test_events_of_plates_are_at_one_time_whenever_the_channels_begin():
    """A part of a trial has channels that begin before its first frame, and its baseline may lie there."""
    whole = laboratory().walk
    plates = tuple(replace(plate, zero_frames=np.array([0.0, 20.0])) for plate in whole.plates)
    off = tuple(replace(a, values=a.values + 15.0) for a in whole.analog)
    part = replace(whole, plates=plates, analog=off).frames(15, 250)
    times = [[e.time for e in plate_events(trial, marker_points(trial))] for trial in (whole, part)]
    assert len(times[0]) > 2
    np.testing.assert_allclose(np.array(times[1]) + 0.15, times[0], atol=1e-9)
    np.testing.assert_array_equal(part.plates[0].zero_frames, [-15.0, 5.0])


LAB = SubjectMeasures(*[LegMeasures(850.0, 100.0, 70.0)] * 2, mass_kg=70.0)


@cache
def laboratory():
    return gait_laboratory(WalkingBody(LAB), duration_s=2.6)


def gated(record):
    """Channels of plates with nothing below 100 N."""
    values = record.values.copy()
    for k, name in enumerate(record.names):
        if name.lower().startswith("fz"):
            own = [j for j, other in enumerate(record.names) if other[2:] == name[2:]]
            values[np.ix_(own, np.flatnonzero(np.abs(record.values[k]) < 100))] = 0.0
    return replace(record, values=values)


def test_an_event_in_a_gap_is_known_worse():
    walk, at, _ = simulated()
    plain = foot_events(walk, at)
    one = next(e for e in plain if e.side == "left" and not e.strike and e.time > 2)
    gap = slice(round(100 * one.time) - 8, round(100 * one.time) + 8)
    at = at | {"LTOE": at["LTOE"].copy()}
    at["LTOE"][gap] = np.nan
    found = foot_events(walk, at)
    near = min((e for e in found if (e.side, e.strike) == ("left", False)), key=lambda e: abs(e.time - one.time))
    assert near.sd > 0.018 and abs(near.time - one.time) < 2 * near.sd
    assert all(e.sd < 0.015 for e in found if abs(e.time - one.time) > 0.3)


def test_an_event_has_the_same_time_at_every_rate():
    true = [(e.side, e.strike, e.time) for e in foot_events(*simulated(250.0)[:2])]
    for rate in (50.0, 100.0):
        found = foot_events(*simulated(rate)[:2])
        for side, strike, time in true:
            if 0.4 < time < 5.6:
                same = [e.time for e in found if (e.side, e.strike) == (side, strike)]
                assert min(abs(t - time) for t in same) < 0.006


def test_jerks_of_a_foot_have_no_steps_between_frames():
    """A cubic spline's third derivative has: the time of its greatest value then hangs on rounding."""
    rate, hz = 100.0, 3.0
    at = dict(simulated()[1])
    t = np.arange(len(at["LHEE"])) / rate
    at["LHEE"] = at["LHEE"] * [1, 1, 0] + 50 * np.sin(2 * np.pi * hz * t)[:, None] * [0, 0, 1]
    foot = foot_motion(at, "left", rate)
    true = -50 * (2 * np.pi * hz) ** 3 * np.cos(2 * np.pi * hz * foot.time)
    middle = slice(200, -200)
    assert np.abs(foot.heel_jerk_up - true)[middle].max() < 0.02 * np.abs(true).max()


def simulated(rate=100.0, speed=1200.0, seed=1, **options):
    subject = walking(duration_s=6.0, rate=rate, speed_mm_s=speed, seed=seed, **options)
    return Trial("walk", subject.trajectories), {p.name: p.xyz for p in subject.trajectories}, subject.events


@pytest.mark.parametrize(("rate", "speed"), [(50.0, 1100.0), (100.0, 700.0), (100.0, 1500.0), (250.0, 1200.0)])
def test_every_step_is_found_once(rate, speed):
    walk, at, true = simulated(rate, speed, wobble_mm=1.0)
    found = foot_events(walk, at)
    for side in ("left", "right"):
        mine = np.array([e.time for e in found if e.side == side and e.strike])
        theirs = true.time[
            [s == side.title() and name == "Foot Strike" for s, name in zip(true.side, true.label, strict=True)]
        ]
        inside = theirs[(theirs > 0.3) & (theirs < 5.7)]
        off = [np.abs(mine - t).min() for t in inside]
        assert max(off) < 0.06 * np.median(np.diff(theirs)), "of a foot that never slaps"
        assert len(mine) <= len(theirs) + 1
        assert (np.diff(mine) > 0.5).all()


def test_events_do_not_hang_on_the_direction_the_place_or_the_treadmill():
    walk, at, _ = simulated()
    plain = foot_events(walk, at)
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    belt = np.outer(np.arange(walk.trajectories.n_frames) * 12.0, [1.0, 0, 0])
    for other in ({k: x @ turn.T + 1e4 for k, x in at.items()}, {k: x - belt for k, x in at.items()}):
        moved = foot_events(walk, other)
        assert [e.side for e in moved] == [e.side for e in plain]
        assert np.abs([a.time - b.time for a, b in zip(plain, moved, strict=True)]).max() < 0.02


def test_a_person_who_stands_makes_no_step():
    still = walking(duration_s=0.01, rate=100.0).trajectories
    at = {p.name: np.repeat(p.xyz, 300, 0) + np.random.default_rng(0).normal(0, 1, (300, 3)) for p in still}
    walk = Trial("still", Trajectories((), 100.0))
    assert foot_events(walk, at) == ()


def test_peaks_and_crossings_are_found_between_frames():
    t = np.arange(200) / 100.0
    assert greatest(np.sin(2 * np.pi * t), t, slice(0, 60)) == pytest.approx(0.25, abs=1e-4)
    assert greatest(np.cos(2 * np.pi * (t - 0.303)), t, slice(5, 60)) == pytest.approx(0.303, abs=1e-4)
    assert np.isnan(greatest(t, t, slice(150, 200)))
    assert faster(t, t, slice(0, 101), 0.5037) == pytest.approx(0.5037)
    assert slower(2.0 - t, t, slice(100, 200), 0.4963) == pytest.approx(1.5037)
    bump = np.maximum(0.0, 1 - np.abs(t - 1.0)) + 0.1 * (np.abs(t - 0.15) < 0.045)
    assert faster(bump, t, slice(0, 200), 0.255) == pytest.approx(0.255), "the last time before the swing"
    assert np.isnan(faster(t, t, slice(150, 200), 0.5)), "it was faster all along"
