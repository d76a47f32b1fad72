"""Labelled trials whose names cannot be are told to whoever names others by them."""

from dataclasses import replace

import pytest

from kinemark.data import MarkerTrajectory
from kinemark.engine.naming.impossible_names import impossible_names
from kinemark.engine.naming.subject_templates import Known, subject_template
from kinemark.io.c3d import write_c3d
from kinemark.io.trial import read_trial
from support.shared import shared_data

STATIC = "mocap3d/pig_gait_child/HC030A01.c3d"


def renamed(trajectories, names):
    return replace(trajectories, paths=tuple(replace(p, name=names.get(p.name, p.name)) for p in trajectories))


@pytest.mark.parametrize(("a", "b"), [("LKNE", "RKNE"), ("LHEE", "LTOE")])
def test_exchanged_names_of_a_static_trial_are_told(tmp_path, a, b):
    """Walks were named by it surely and wrongly, without a word."""
    trial = read_trial(shared_data(STATIC))
    write_c3d(tmp_path / "stood.c3d", replace(trial, trajectories=renamed(trial.trajectories, {a: b, b: a})))
    said = []
    subject_template([tmp_path / "stood.c3d"], Known(static=True, say=said.append))
    assert len(said) == 1 and said[0].startswith("In stood.c3d, ") and a in said[0] and b in said[0]


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
