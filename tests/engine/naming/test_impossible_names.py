"""Labelled trials whose names cannot be are told to whoever names others by them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import MarkerTrajectory
from kinemark.engine.naming.impossible_names import impossible_names
from kinemark.engine.naming.subject_templates import Known, subject_template
from kinemark.io.c3d import write_c3d
from kinemark.io.trial import read_trial
from support.shared import shared_data

STATIC = "mocap3d/pig_gait_child/HC030A01.c3d"


def renamed(trajectories, names):
    return replace(trajectories, paths=tuple(replace(p, name=names.get(p.name, p.name)) for p in trajectories))


UPPER_BODY = [
    *(("L" + name, "R" + name) for name in ("FHD", "BHD", "SHO", "ELB", "WRA", "WRB", "FIN")),
    *(("LFHD", "LBHD"), ("C7", "CLAV"), ("C7", "T10"), ("CLAV", "STRN"), ("RSHO", "RELB"), ("RELB", "RWRA")),
    ("LWRA", "LFIN"),
]
FEET = [("LHEE", "RHEE"), ("LTOE", "RTOE")]


@pytest.mark.parametrize(("a", "b"), [("LKNE", "RKNE"), ("LHEE", "LTOE"), *FEET, *UPPER_BODY])
def test_exchanged_names_of_a_static_trial_are_told(tmp_path, a, b):
    """Walks were named by it surely and wrongly, without a word."""
    trial = read_trial(shared_data(STATIC))
    write_c3d(tmp_path / "stood.c3d", replace(trial, trajectories=renamed(trial.trajectories, {a: b, b: a})))
    said = []
    subject_template([tmp_path / "stood.c3d"], Known(static=True, say=said.append))
    assert len(said) == 1 and said[0].startswith("In stood.c3d, ") and a in said[0] and b in said[0]


@pytest.mark.parametrize("joint", ["KNE", "ANK"])
def test_exchanged_knees_do_not_make_a_walk_look_like_sitting(joint):
    """By the wrong knee the shank was so long that nobody seemed to stand, and nothing was told."""
    own = read_trial(shared_data("mocap3d/pig_gait_children/HC032A03.c3d")).trajectories
    names = {"L" + joint: "R" + joint, "R" + joint: "L" + joint}
    assert set(names) in [set(found.markers) for found in impossible_names([renamed(own, names)], ["walk"])]


def test_folded_arms_are_not_told():
    """Hands lie on the other side of the body, before the other elbow."""
    own = read_trial(shared_data(STATIC)).trajectories
    folded = {}
    for side, other in ("LR", "RL"):
        elbow, across = own[side + "ELB"].xyz, own[other + "ELB"].xyz - own[side + "ELB"].xyz
        reach = across / np.linalg.norm(across, axis=1, keepdims=True)
        forearm = np.linalg.norm(own[side + "WRA"].xyz - elbow, axis=1, keepdims=True)
        for name, mm in (("WRA", 0), ("WRB", 0), ("FIN", 60)):
            folded[side + name] = elbow + (forearm + mm) * reach
    paths = (MarkerTrajectory.measured(p.name, folded.get(p.name, p.xyz)) for p in own)
    assert not list(impossible_names([replace(own, paths=tuple(paths))], ["folded"]))


def test_right_names_are_not_told_wherever_they_are_and_whatever_they_are_called():
    for file in (STATIC, "mocap3d/pig_gait_child/HC030A22.c3d", "mocap3d/gait_emg_ccby/2014001_ST.c3d",
                 "mocap3d/fullbody_cmu/85_02.c3d", "mocap3d/pig_wholebody/Movement_trial.c3d"):  # fmt: skip
        own = read_trial(shared_data(file)).trajectories
        for shift in ((0, 0, 0), (3e6, -2e6, 0)):
            paths = tuple(MarkerTrajectory.measured(path.name, path.xyz + list(shift)) for path in own)
            assert not list(impossible_names([replace(own, paths=paths)], [file]))


def test_somebody_who_sits_is_not_judged():
    own = read_trial(shared_data(STATIC)).trajectories
    low = {
        name: path.xyz - [0, 0, 400.0] for path in own if (name := path.name)[1:] in ("ASI", "PSI") or name == "SACR"
    }
    paths = (
        MarkerTrajectory.measured(p.name, low.get(p.name, p.xyz))
        for p in renamed(own, {"LKNE": "RKNE", "RKNE": "LKNE"})
    )
    assert not list(impossible_names([replace(own, paths=tuple(paths))], ["sits"]))


def turned(own, names, about, degrees):
    """The trial with some markers turned about the hips, forwards, or about the upright line through one marker."""
    at = np.mean([own[name].xyz for name in about], axis=0)
    axis = np.array([0.0, 0, 1]) if len(about) == 1 else np.nanmedian(own["LASI"].xyz - own["RASI"].xyz, axis=0)
    turn = Rotation.from_rotvec(np.deg2rad(degrees) * axis / np.linalg.norm(axis))
    moved = {name: at + turn.apply(own[name].xyz - at) for name in names}
    return replace(own, paths=tuple(MarkerTrajectory.measured(p.name, moved.get(p.name, p.xyz)) for p in own))


HEAD = {side + name for side in "LR" for name in ("FHD", "BHD")}
TRUNK = HEAD | {"C7", "T10", "CLAV", "STRN", "LSHO", "RSHO", "LELB", "RELB"}
TRUNK |= {side + name for side in "LR" for name in ("WRA", "WRB", "FIN")}


@pytest.mark.parametrize("degrees", [60, 90, 120])
def test_somebody_who_bends_down_is_not_told(degrees):
    """The chest is then behind the neck, and the neck below the back."""
    own = read_trial(shared_data(STATIC)).trajectories
    bent = turned(own, TRUNK, ("LASI", "RASI"), degrees)
    assert bent["C7"].xyz[0, 2] < own["C7"].xyz[0, 2]
    assert not list(impossible_names([bent], ["bends"]))


def test_somebody_who_looks_over_the_shoulder_is_not_told():
    own = read_trial(shared_data(STATIC)).trajectories
    looks = turned(turned(own, TRUNK, ("C7",), 35), HEAD, ("C7",), 75)
    assert not list(impossible_names([looks], ["looks back"]))
