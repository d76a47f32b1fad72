"""Foot events from markers alone, against the force plates below the same feet: every public stride at hand.

Each subject is judged by the biases of the others. An error is the event from markers less that of the plate. Steps do
not count where the recording begins or ends within 0.12 s of them, where the foot is not alone and whole on the plate,
or where the plate does not know to 10 ms or a sample (one laboratory writes 0 below 50 N). Two recordings are said
apart: strikes on a treadmill whose forces were low-passed, so that they begin 10 to 20 ms early, and a walk on stairs.

Then the same by the biases of other laboratories, at half the rate, with noise, with other filters, and by each
detector alone, Zeni's among them. `of the stated` is the root mean square of error over stated deviation; 1 is right.

    python studies/gait_events.py [--each] [--constants]
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numpy as np
from gait_references import markers, model_points, storage, template

from kinemark.data.array_types import Bools, Floats
from kinemark.data.strides import FootEvent
from kinemark.data.subject_measures import SIDES
from kinemark.gait import marker_points, standard_trial
from kinemark.gait.foot_detectors import voted
from kinemark.gait.foot_events import BETWEEN_MS, WITHIN_MS, middle_half
from kinemark.gait.plate_contacts import contacts
from kinemark.gait.plate_events import PLATE_N, contact_events
from kinemark.gait.reaction import reaction
from kinemark.io.trial import read_trial
from kinemark.kinematics.pose import carry

DATA = Path(os.environ.get("KINEMARK_DATA", "data"))
EDGE_S = 0.12
"""From the ends of a recording within which a step does not count, s."""
KNOWN_S = 0.010
"""To which a plate must know, s, or to a sample."""
ALIKE = 0.35
"""r, (deviation between subjects / within them)²; measured here."""
FAR_S = 0.25
"""Beyond which an event from markers is another one, s."""


class Recording(NamedTuple):
    """A file, its subject and laboratory, names of its heels, and contacts that count though a foot is beside."""

    file: str
    subject: str
    laboratory: str
    heels: Mapping[str, str] = {}
    beside: bool = False


CHILDREN = {"HC030A": ("05", "22"), "HC002D": ("06", "25"), "HC031A": ("06", "23"), "HC032A": ("03", "18"),
            "HC033A": ("10", "22")}  # fmt: skip
RECORDINGS = (
    *(Recording(f"mocap3d/pig_gait_child{'' if child == 'HC030A' else 'ren'}/{child}{n}.c3d", child, "biomechzoo")
      for child, walks in CHILDREN.items() for n in walks),
    Recording("mocap3d/pig_gait_3plates_emg/PiG_Motion3_FF.c3d", "PiG_Motion3", "BTKData"),
    Recording("mocap3d/qualisys_gait/Gait - CGM2 1.c3d", "CGM2", "Qualisys"),
    Recording("mocap3d/gait_emg_ccby/2014001_C1_01.c3d", "2014001", "AnyBody"),
    Recording("cameras/gait9_bts/gait9.tdf", "gait9", "BTS", {"RHEE": "Mk19", "LHEE": "Mk23"}),
    # its plates are 0.1 m beside where the file says, so that heels or toes are too, but not the force
    Recording("mocap3d/force_plate_types/TYPE-3.c3d", "TYPE-3", "c3d.org", beside=True),
)  # fmt: skip
STAIRS = Recording("mocap3d/pig_wholebody/Movement_trial.c3d", "stairs", "pyCGM", beside=True)


class Walk(NamedTuple):
    """Markers (F, 3) mm by name at a rate, and what plates say of its events."""

    subject: str
    laboratory: str
    points: Mapping[str, Floats]
    rate: float
    known: tuple[FootEvent, ...]
    sample_s: float


def walk_of(one: Recording) -> Walk:
    """A recording with its plates."""
    trial = standard_trial(read_trial(DATA / one.file), markers=one.heels or None).trial
    points, rate, n = marker_points(trial), trial.trajectories.rate, trial.trajectories.n_frames
    loads = [reaction(p, trial.analog, n_frames=n, rate=rate, threshold_n=PLATE_N) for p in trial.plates]
    reasons = ("", "beside") if one.beside else ("",)
    found = [e for c in contacts(loads, points, rate=rate) if c.reason in reasons for e in contact_events(trial, c)]
    sample = 1 / trial.analog[0].rate
    return Walk(one.subject, one.laboratory, points, rate, tuple(found), sample)


def treadmill() -> Walk:
    """OpenSim's walk; its strikes are said apart."""
    static, _ = markers("subject01_static.trc")
    walk, rate = markers("subject01_walk.trc")
    points = model_points(walk, carry(walk, template(static)))
    table, known = storage("subject01_walk_grf.mot"), []
    for side, before in zip(reversed(SIDES), ("", "1_"), strict=True):
        force, time = table[before + "ground_force_vy"], table["time"]
        for k in np.flatnonzero(np.diff(force > PLATE_N)):
            at = time[k] + (PLATE_N - force[k]) / (force[k + 1] - force[k]) * (time[k + 1] - time[k])
            known.append(FootEvent(side, bool(force[k + 1] > force[k]), float(at), 0.004, "plate"))
    return Walk("treadmill", "OpenSim", points, rate, tuple(known), 1 / 600)


class Judged(NamedTuple):
    """Steps of one kind: times (n, D) of the detectors, (n) of Zeni's, less the plates', ms, λ, and whose they are."""

    off: Floats
    zeni: Floats
    slow: Floats
    subject: Floats
    laboratory: Floats
    at: Floats
    counts: Bools


def judged(walks: Sequence[Walk], strike: bool) -> Judged:
    """Of all walks; `counts` is false for those that are said apart."""
    rows: list[tuple[Any, ...]] = []
    for walk in walks:
        votes = [v for v in voted(walk.points, walk.rate) if v.event.strike == strike]
        last = len(walk.points["LHEE"]) / walk.rate
        for event in walk.known:
            same = [v for v in votes if v.event.side == event.side and abs(v.event.time - event.time) < FAR_S]
            if event.strike != strike or not EDGE_S < event.time < last - EDGE_S or not same:
                continue
            near = min(same, key=lambda v: abs(v.event.time - event.time))
            apart = (
                walk.subject == "stairs"
                or (strike and walk.subject == "treadmill")
                or event.sd > max(KNOWN_S, 1.01 * walk.sample_s)
            )
            off, zeni = 1000 * (near.times - event.time), 1000 * (near.event.time - event.time)
            rows.append((off, zeni, near.slow, walk.subject, walk.laboratory, event.time, not apart))
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    return Judged(*columns)


def fitted(steps: Judged, which: Bools, strike: bool) -> Floats:
    """(D, 2) bias and slope on λ, ms, of each detector; far ones weigh less (Huber, 10 ms).

    Steps of one subject are alike: of n each weighs 1 / (1 + n r).
    """
    which = which & steps.counts
    share = np.array([1 / (1 + ALIKE * np.sum(which & (steps.subject == name))) if w else 0.0
                      for name, w in zip(steps.subject, which, strict=True)])  # fmt: skip
    A = np.stack([np.ones(len(which)), np.zeros(len(which)) if strike else steps.slow], 1)
    found = []
    for y in steps.off.T:
        h = share * np.isfinite(y)
        y, weight = np.nan_to_num(y), h
        for _ in range(12):
            b = np.linalg.solve((A * weight[:, None]).T @ A + np.diag([1e-9, 0.05]), (A * weight[:, None]).T @ y)
            weight = h * np.minimum(1, 10 / np.maximum(np.abs(y - A @ b), 1e-6))
        found.append(b)
    return np.array(found)


def errors(steps: Judged, strike: bool, groups: Floats) -> Floats:
    """(n, 2) ms: errors, each group judged by the biases of the others, and what is stated."""
    out = np.full((len(groups), 2), np.nan)
    floor = np.hypot(BETWEEN_MS[strike], WITHIN_MS[strike])
    for name in np.unique(groups):
        own = groups == name
        b = fitted(steps, ~own, strike)
        left = steps.off[own] - b[:, 0] - b[:, 1] * steps.slow[own, None]
        time = np.array([middle_half(row) for row in left])
        out[own] = np.stack([time, np.maximum(floor, np.nanmean(np.abs(left - time[:, None]), axis=1) / 2)], 1)
    return out


def deviations(off: Floats, subject: Floats) -> tuple[float, float]:
    """ms between subjects and within them, by the analysis of variance."""
    names = np.unique(subject)
    n = np.array([np.sum(subject == name) for name in names])
    means = np.array([off[subject == name].mean() for name in names])
    inside = sum(((off[subject == name] - m) ** 2).sum() for name, m in zip(names, means, strict=True))
    within = inside / max(len(off) - len(names), 1)
    between = np.mean(means**2 - within / n)
    return float(np.sqrt(max(between, 0.0))), float(np.sqrt(within))


def summary(each: Floats) -> str:
    """A row of errors and stated deviations (n, 2), ms."""
    off, size = each[:, 0], np.sqrt(np.mean((each[:, 0] / each[:, 1]) ** 2))
    return (f"n {len(off):3d}   RMS {np.sqrt(np.mean(off**2)):5.1f}   mean size {np.abs(off).mean():5.1f}   "
            f"median {np.median(off):5.1f}   within 15 ms {np.sum(np.abs(off) < 15):3d} = "
            f"{100 * np.mean(np.abs(off) < 15):3.0f} %   largest {np.abs(off).max():4.0f}   "
            f"of the stated {size:.2f}")  # fmt: skip


def changed(walks: Sequence[Walk], step: int, noise_mm: float, seed: int) -> list[Walk]:
    """Each so many frames, with noise."""
    rng = np.random.default_rng(seed)
    return [
        w._replace(rate=w.rate / step, points={k: x[::step] + noise_mm * rng.normal(size=x[::step].shape)
                                               for k, x in w.points.items()})
        for w in walks
    ]  # fmt: skip


NAMES = {True: "strikes", False: "offs"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", action="store_true", help="every step")
    parser.add_argument("--constants", action="store_true", help="biases from all subjects, as they stand in the code")
    given = parser.parse_args()
    walks = [*map(walk_of, RECORDINGS), treadmill()]
    stairs = walk_of(STAIRS)
    for strike in (True, False):
        steps = judged(walks, strike)
        off = errors(steps, strike, steps.subject)
        own = off[steps.counts]
        print(f"{NAMES[strike]}, {len(np.unique(steps.subject[steps.counts]))} subjects")
        print("  each subject by the others    ", summary(own))
        print("  … by other laboratories       ", summary(errors(steps, strike, steps.laboratory)[steps.counts]))
        between, within = deviations(own[:, 0], steps.subject[steps.counts])
        print(f"  deviation between subjects {between:.1f} ms, within {within:.1f} ms")
        for step, noise in ((2, 0.0), (1, 0.5), (2, 0.3)):
            other = judged(changed(walks, step, noise, seed=1), strike)
            words = f"  every {step}. frame, {noise} mm noise"
            print(f"{words:32s}", summary(errors(other, strike, other.subject)[other.counts]))
        for cutoff in (10.0, 25.0):
            with mock.patch("kinemark.gait.foot_motion.CUTOFF_HZ", cutoff):
                other = judged(walks, strike)
            print(f"  markers at {cutoff:.0f} Hz             ",
                  summary(errors(other, strike, other.subject)[other.counts]))  # fmt: skip
        alone = [steps._replace(off=column[:, None]) for column in (steps.zeni, *steps.off.T)]
        size = [np.sqrt(np.nanmean(errors(one, strike, one.subject)[one.counts, 0] ** 2)) for one in alone]
        print("  RMS of Zeni's alone, of each detector alone:", *(f"{each:.1f}" for each in size))
        apart = [(s, round(float(e))) for s, e, c in zip(steps.subject, off[:, 0], steps.counts, strict=True) if not c]
        up = judged([stairs], strike)
        b = fitted(steps, steps.counts, strike)
        there = [middle_half(row) for row in up.off - b[:, 0] - b[:, 1] * up.slow[:, None]]
        print("  said apart:", ", ".join(f"{s} {e}" for s, e in apart), "; stairs", *np.round(there).astype(int))
        if given.each:
            for row in zip(steps.subject, np.round(steps.at, 3), np.round(off[:, 0], 1), steps.counts, strict=True):
                print("   ", *row)
        if given.constants:
            print("  biases, ms, and slopes on λ:", *(f"({a:.0f}, {c:.0f})" for a, c in b))
            print(f"  λ from {steps.slow.min():.2f} to {steps.slow.max():.2f}")


if __name__ == "__main__":
    main()
