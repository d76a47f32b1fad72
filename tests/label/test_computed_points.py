"""Points that a program computed of markers are found by what they keep, and markers are not."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.io.trial import read_trial
from kinemark.label import computed_points, learn_template
from kinemark.label.template import names_in
from support.computed import computed, walker, with_computed
from support.shared import shared_data


@cache
def file(seed=1):
    return with_computed(walker(seed))


def changed(trial, change):
    return replace(trial, paths=tuple(replace(path, xyz=change(path.xyz)) for path in trial))


def renamed(trial, new):
    return replace(trial, paths=tuple(replace(path, name=new(path.name)) for path in trial))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_axes_joint_centres_midpoints_and_centres_of_mass_are_found_and_no_markers(seed):
    assert set(computed_points(file(seed))) == set(computed(walker(seed)))
    assert computed_points(walker(seed)) == ()


@pytest.mark.parametrize("how", [{"wobble_mm": 0.0}, {"duration_s": 0.02}, {"wobble_mm": 0.1, "rate": 50.0}])
def test_markers_alone_are_markers_however_still_their_skin_is(how):
    assert computed_points(walker(4, **how)) == ()


@pytest.mark.parametrize(
    "change",
    [
        lambda xyz: xyz.astype(np.float32).astype(float),
        lambda xyz: np.round(xyz, 1),  # as integers hold it
        lambda xyz: xyz / 10,  # a hand
        lambda xyz: (xyz + np.array([1e5, -2e5, 0.0]))[:, [1, 2, 0]],  # another floor, another axis upwards
    ],
)
def test_they_are_found_in_any_number_format_size_and_world(change):
    assert set(computed_points(changed(file(), change))) == set(computed(walker()))


def test_points_that_are_missing_for_a_while_are_found_too():
    missing = np.arange(file().n_frames) % 80 < 50
    parts = tuple(path.only(~missing) if k % 3 else path for k, path in enumerate(file()))
    found = set(computed_points(replace(file(), paths=parts)))
    assert found == set(computed(walker()))


def test_the_order_and_a_subject_before_the_names_change_nothing():
    turned = replace(file(), paths=file().paths[::-1])
    assert set(computed_points(turned)) == set(computed_points(file()))
    own = {f"L_Anna:{name}" for name in computed(walker())}
    assert set(computed_points(renamed(file(), lambda name: f"L_Anna:{name}"))) == own


def test_without_names_tips_of_one_length_are_found_still_and_markers_are_not():
    number = {name: f"*{k}" for k, name in enumerate(file().names)}
    found = set(computed_points(renamed(file(), number.get)))
    assert {number[f"{name}{tip}"] for name in ("LFE", "RTI", "TRX", "PEL") for tip in "ALP"} <= found
    assert not {number[name] for name in walker().names} & found


def test_what_nothing_is_left_of_is_a_thing_of_right_angles():
    frames = np.linspace(0, 900, 60)[:, None] * [1.0, 0.3, 0.0]
    corners = np.array([(x, y, z) for x in (0, 300) for y in (0, 300) for z in (0, 300)])
    cube = tuple(MarkerTrajectory.measured(f"c{k}", frames + corner) for k, corner in enumerate(corners))
    assert computed_points(Trajectories(cube, 100.0)) == ()


def test_a_template_does_not_learn_them_unless_they_are_named():
    assert set(names_in([walker(2), file()])) == set(walker().names) == set(learn_template(file()).names)
    assert "LFEO" in learn_template(file(), names=["LFEO", "LKNE", "LANK", "LHEE"]).names


CHILDREN = "pig_gait_children"
REAL = """LKNE RKNE LANK RANK LSHO RSHO LELB RELB LWRA RWRA LASI RASI SACR LHLX RHLX LTOE RTOE LHEE RHEE LTHI RTHI
LTIB RTIB LFHD RFHD C7 CLAV STRN LFIN RFIN LPSI RPSI"""


@pytest.mark.parametrize(
    ("path", "least"),
    [
        (f"{CHILDREN}/HC032A18.c3d", 112),
        (f"{CHILDREN}/HC033A01.c3d", 106),
        ("pig_gait_child/HC030A22.c3d", 112),
        ("pig_gait_3plates_emg/PiG_Motion3_FF.c3d", 36),
        ("pig_wholebody/Static_trial.c3d", 76),
        ("qualisys_gait/Gait - CGM2 1.c3d", 0),
        ("labelling/PronetoRun01.c3d", 0),
        ("c3d_six_formats/dec_int.c3d", 0),
        ("gait_emg_ccby/2014001_ST.c3d", 0),
    ],
)
def test_in_published_files_axes_are_found_and_markers_are_not(path, least):
    found = computed_points(read_trial(shared_data(f"mocap3d/{path}")).trajectories)
    assert len(found) >= least and not set(REAL.split()) & set(found)
    assert least or not found
