"""Level walking, running and stairs are told apart, and events outside of level walking are known worse."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from kinemark.data import Trajectories, Trial
from kinemark.data.strides import FootEvent
from kinemark.gait import marker_points, standard_trial
from kinemark.gait.foot_events import UNLIKE_MS, foot_events
from kinemark.gait.way_of_walking import way_of_walking
from kinemark.io.trial import read_trial
from kinemark.synth import walking
from support.plug_in_gait import trial
from support.shared import shared_data

FLAT = {f"{letter}HEE": np.zeros((600, 3)) for letter in "LR"}


def steps(stance, n=8, stride=1.0):
    """Events of feet that stand for a share of the stride."""
    out = []
    for k in range(n):
        side, at = ("left", "right")[k % 2], 0.1 + k * stride / 2
        out += [FootEvent(side, True, at, 0.006, "markers"), FootEvent(side, False, at + stance, 0.007, "markers")]
    return sorted(out, key=lambda e: e.time)


@pytest.mark.parametrize(("stance", "way"), [(0.75, "level"), (0.62, "level"), (0.45, "running"), (0.3, "running")])
def test_who_flies_runs(stance, way):
    assert way_of_walking(steps(stance), FLAT, rate=100.0) == way


def test_who_gets_higher_from_step_to_step_climbs():
    up = {name: np.linspace(0, 1, 600)[:, None] * [0, 0, 1000.0] for name in FLAT}
    assert way_of_walking(steps(0.6), up, rate=100.0) == "stairs"
    assert way_of_walking(steps(0.6), {k: x * 0.2 for k, x in up.items()}, rate=100.0) == "level"
    assert way_of_walking((), up, rate=100.0) == "level"


@pytest.mark.parametrize("speed", [400.0, 900.0, 1900.0])
def test_slow_and_fast_walks_are_level(speed):
    walk = walking(duration_s=8.0, rate=100.0, speed_mm_s=speed).trajectories
    at = {p.name: p.xyz for p in walk}
    events = foot_events(Trial("walk", walk), at)
    assert len(events) > 6 and way_of_walking(events, at, rate=100.0) == "level"
    assert np.median([e.sd for e in events]) < UNLIKE_MS / 1000


def test_a_walk_on_stairs_says_so_and_its_strikes_are_where_the_plates_have_them():
    walk = standard_trial(trial("pig_wholebody/Movement_trial.c3d")).trial
    at = marker_points(walk)
    events = foot_events(replace(walk, plates=()), at)
    assert way_of_walking(events, at, rate=120.0) == "stairs"
    assert all(e.sd >= UNLIKE_MS / 1000 for e in events)
    for true in (0.343, 0.874, 1.366):  # 20 N on the plates, whose steps feet overhang
        assert min(abs(e.time - true) for e in events if e.strike) < 2 * UNLIKE_MS / 1000


def test_a_run_says_so_and_its_feet_stand_between_the_events():
    """Whole-body markers of another set, with a pelvis of four at the back; the last second is a run."""
    run = read_trial(shared_data("mocap3d/labelling/PronetoRun01.c3d"))
    P, rate = {p.name: p.xyz for p in run.trajectories}, run.trajectories.rate
    left, right = (P["PVUL"] + P["PVLL"]) / 2, (P["PVUR"] + P["PVLR"]) / 2
    across, upwards = left - right, P["PVUL"] + P["PVUR"] - P["PVLL"] - P["PVLR"]
    forward = np.cross(across, upwards)
    forward *= 200 / np.linalg.norm(forward, axis=1)[:, None]
    points = {"LASI": left + forward, "RASI": right + forward, "SACR": (left + right) / 2}
    for side in "LR":
        points |= {side + "HEE": P[side + "HEE"], side + "TOE": P[side + "FTF"], side + "ANK": P[side + "ANL"]}
    late = {name: xyz[round(3.8 * rate) :] for name, xyz in points.items()}
    events = foot_events(Trial("run", Trajectories((), rate)), late)
    assert way_of_walking(events, late, rate=rate) == "running"
    stood = 0
    for side in ("left", "right"):
        own = [e for e in events if e.side == side]
        speed = np.linalg.norm(np.gradient(late[side[0].upper() + "TOE"], axis=0), axis=1) * rate
        for a, b in pairwise(own):
            if a.strike and a.time > 0.6:  # it gets up before
                stood += 1
                on = np.flatnonzero(speed < 1000) / rate
                on = on[(on > a.time - 0.1) & (on < b.time + 0.1)]
                assert max(abs(on[0] - a.time), abs(on[-1] - b.time)) < UNLIKE_MS / 1000
    assert stood == 2


def test_a_pelvis_that_is_highest_between_the_steps_is_a_runners():
    """Markers show offs of runners late, so that short flights are lost; the height of the pelvis tells them."""
    walk = walking(duration_s=8.0, rate=100.0, speed_mm_s=1900.0).trajectories
    at = {p.name: p.xyz for p in walk}
    events = foot_events(Trial("walk", walk), at)
    z = np.mean([at[name][:, 2] for name in ("LASI", "RASI", "SACR")], axis=0)
    for by, way in ((0.0, "level"), (-2.5, "running")):
        bouncing = {
            n: x + by * (z - z.mean())[:, None] * (0, 0, 1) if n[1:] in ("ASI", "ACR") else x for n, x in at.items()
        }
        assert way_of_walking(events, bouncing, rate=100.0) == way
        hardly = {n: at[n] + 0.2 * (x - at[n]) for n, x in bouncing.items()}
        assert way_of_walking(events, hardly, rate=100.0) == "level"
