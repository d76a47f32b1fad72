"""Foot events: against force plates of real walks, and laws on simulated ones."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Trajectories, Trial
from kinemark.gait import marker_points, standard_trial
from kinemark.gait.foot_events import crossings, foot_events, greatest, plate_events
from kinemark.synth import walking
from support.plug_in_gait import CHILDREN, trial

WALKS = [f"{child}{n}.c3d" for child, (_, *walks) in CHILDREN.items() for n in walks]
WALKS += ["pig_gait_3plates_emg/PiG_Motion3_FF.c3d"]
OTHERS = {"qualisys_gait/Gait - CGM2 1.c3d": {}, "gait_emg_ccby/2014001_C1_01.c3d": {},
          "../cameras/gait9_bts/gait9.tdf": {"RHEE": "Mk19", "LHEE": "Mk23"}}  # fmt: skip
"""On which nothing was tuned, and the names of their heels."""


def errors(name):
    """s, by kind: events from markers alone less those of plates, and what was expected."""
    walk = standard_trial(trial(name), markers=OTHERS.get(name)).trial
    at, rate = marker_points(walk), walk.trajectories.rate
    known = plate_events(walk, at)
    found = {True: [], False: []}
    alone = foot_events(replace(walk, plates=()), at)
    for event in known:
        if not 0.12 < event.time < walk.trajectories.n_frames / rate - 0.12:
            continue  # the recording begins or ends within the step
        same = [e for e in alone if (e.side, e.strike) == (event.side, event.strike)]
        near = min(same, key=lambda e: abs(e.time - event.time))
        found[event.strike].append((near.time - event.time, near.sd))
    return found


def test_events_from_markers_are_those_of_the_plates():
    every = [errors(name) for name in (*WALKS, *OTHERS)]
    (strikes, strike_sd), (offs, off_sd) = (
        1000 * np.concatenate([one[kind] for one in every if one[kind]]).T for kind in (True, False)
    )
    assert len(strikes) > 20 and len(offs) > 20
    assert abs(np.median(strikes)) < 3 and (np.abs(strikes) < 15).mean() > 0.95
    for off, sd in ((strikes, strike_sd), (offs, off_sd)):
        assert 0.77 < np.sqrt(np.mean((off / sd) ** 2)) < 1.3, "expected errors are true within 30 %"
    assert abs(np.median(offs)) < 3 and (np.abs(offs) < 15).mean() > 0.9 and (np.abs(offs) < 25).all()


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
        assert np.abs([a.time - b.time for a, b in zip(plain, moved, strict=True)]).max() < 0.05


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
    np.testing.assert_allclose(crossings(t, t, 0.5037, upwards=True), [0.5037], atol=1e-9)
    np.testing.assert_allclose(crossings(-t, t, -0.5037, upwards=False), [0.5037], atol=1e-9)
