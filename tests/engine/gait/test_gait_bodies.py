"""A standing trial with wrong names, of another body or another unit, or that does not stand, is told."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory
from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.engine.gait.doubts import worn_points
from kinemark.engine.gait.files import gait_of_files
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.trial_files import SubjectFiles
from kinemark.gait import marker_points, standard_trial
from kinemark.gait.same_body import APART_MM, UNLIKE_MM, body_change, steps_mm
from kinemark.io.c3d import write_c3d
from kinemark.io.trial import read_trial
from kinemark.synth import WalkingBody, gait_laboratory
from support.shared import shared_data

QUICK = GaitSettings(uncertainty=False)
SURE = GaitSettings(uncertainty=False, smoothing="none", tissue_mm=0.5)
CHILD, OTHER = "mocap3d/pig_gait_child/HC030A", "mocap3d/pig_gait_children/HC032A"
KINDS = {"gait_markers_exchanged", "gait_bodies_differ", "gait_static_moves"}


def exchanged(trial, a, b):
    """The trial with two markers' names exchanged."""
    names = {a: b, b: a}
    paths = tuple(replace(path, name=names.get(path.name, path.name)) for path in trial.trajectories)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths))


def scaled(trial, factor):
    """The trial in another unit."""
    paths = tuple(MarkerTrajectory.measured(p.name, factor * p.xyz) for p in trial.trajectories)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths))


def said(tmp_path, change):
    """Findings of bodies with the child's standing trial so changed."""
    static = tmp_path / "stood.c3d"
    write_c3d(static, change(read_trial(shared_data(CHILD + "01.c3d"))))
    walk = shared_data(CHILD + "05.c3d")
    found = gait_of_files(SubjectFiles([walk], static=static), settings=QUICK, folder=tmp_path / "out")
    return {(f["kind"], f["severity"]): f for f in found.figures["findings"] if f["kind"] in KINDS}


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        (lambda trial: trial, None),
        (lambda trial: exchanged(trial, "LKNE", "RKNE"), ("gait_markers_exchanged", "red")),
        (lambda trial: exchanged(trial, "RHEE", "RTOE"), ("gait_markers_exchanged", "red")),
        (lambda trial: exchanged(trial, "RTIB", "RANK"), ("gait_markers_exchanged", "red")),
        (lambda trial: scaled(trial, 0.001), ("gait_bodies_differ", "amber")),
    ],
)
def test_what_a_standing_trial_calls_wrongly_is_told(tmp_path, change, kind):
    """The ankle was up to 72° off, without a word."""
    told = said(tmp_path, change)
    assert set(told) == ({kind} if kind else set())
    assert all(f["values"]["trial"] in ("stood", "HC030A05") for f in told.values())


def test_a_standing_trial_of_another_child_of_like_size_is_told(tmp_path):
    told = said(tmp_path, lambda _: read_trial(shared_data(OTHER + "01.c3d")))
    values = told["gait_bodies_differ", "amber"]["values"]
    assert values["other"] == "stood" and UNLIKE_MM < values["rms_mm"] < 12


def test_a_functional_trial_is_held_to_the_same_body(tmp_path):
    leg = LegMeasures(890.0, 105.0, 72.0)
    lab = gait_laboratory(WalkingBody(SubjectMeasures(leg, leg, mass_kg=70.0)), duration_s=3.0, rate=50.0)
    trials = {"walk": lab.walk, "static": lab.static, "swings": exchanged(lab.functional, "LHEE", "LTOE")}
    walk, static, swings = (tmp_path / f"{name}.c3d" for name in trials)
    for name, trial in trials.items():
        write_c3d(tmp_path / f"{name}.c3d", trial)
    found = gait_of_files(
        SubjectFiles([walk], static=static, functional=swings), settings=SURE, folder=tmp_path / "out"
    )
    told = [f["values"] for f in found.figures["findings"] if f["kind"] in KINDS]
    assert [one["trial"] for one in told] == ["swings"]


def test_a_walk_is_no_standing_trial(tmp_path):
    told = said(tmp_path, lambda _: read_trial(shared_data(CHILD + "05.c3d")))
    assert set(told) == {("gait_static_moves", "amber")}


def test_stairs_are_climbed_by_the_body_that_stands():
    """Knees that bend move skin by more than a centimetre in the median, and back in each step."""
    stands, climbs = (worn(f"mocap3d/pig_wholebody/{name}_trial.c3d") for name in ("Static", "Movement"))
    assert body_change(stands, climbs) is None


@pytest.mark.parametrize("seed", [11, 12, 13])
def test_a_marker_put_on_anew_is_told_and_wide_noise_is_not(seed):
    rng = np.random.default_rng(seed)
    stands, walks = (worn(CHILD + name) for name in ("01.c3d", "05.c3d"))
    noisy = {name: xyz + rng.normal(0, 4, xyz.shape) for name, xyz in walks.items()}
    assert body_change(stands, noisy) is None
    name = str(rng.choice(["LKNE", "RTIB", "RANK", "LTHI"]))
    anew = walks | {name: walks[name] + [0, 0, 30.0]}
    assert name in {marker for pair in body_change(stands, anew).pairs for marker in pair}


def worn(path):
    trial = standard_trial(read_trial(shared_data(path))).trial
    return worn_points(trial, marker_points(trial))


def test_a_body_is_like_itself_wherever_it_is_and_unlike_a_larger_one():
    rng = np.random.default_rng(3)
    body = {s + n: rng.normal(0, 200, 3) + np.zeros((9, 1)) for s in "LR" for n in ("ASI", "KNE", "TIB", "ANK", "TOE")}
    moved = {name: xyz + np.array([4e6, -2e6, 0]) for name, xyz in body.items()}
    assert body_change(body, moved) is None and steps_mm(body) == steps_mm(moved) == 0
    larger = body_change(body, {name: 1.2 * xyz for name, xyz in moved.items()})
    assert larger.rms_mm > UNLIKE_MM and larger.most_mm > APART_MM
    assert body_change(body, {}) is None and steps_mm({}) == 0
