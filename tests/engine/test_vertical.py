"""Trials are turned so that the axis goes up that the next program wants."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import ForcePlate, KinemarkError, MarkerTrajectory, Trajectories, Trial
from kinemark.engine.formats import convert
from kinemark.engine.vertical import with_axis_said, with_axis_up
from kinemark.io.c3d import read_c3d, write_c3d
from kinemark.io.trc import read_trc, write_trc
from kinemark.synth import walking
from support.shared import shared_data


def standing(names=("LASI", "RASI", "LANK", "RANK"), up="z"):
    """Pelvis and ankles of somebody who stands, in a world with that axis up."""
    places = np.array([[100.0, 120, 950], [100, -120, 950], [0, 100, 80], [0, -100, 80]])
    shift = {"x": 2, "y": 1, "z": 0}[up]
    xyz = np.roll(np.repeat(places[:, None], 5, 1), -shift, axis=2)
    cov = np.tile(np.diag(np.roll([1.0, 4.0, 9.0], -shift)), (5, 1, 1))
    paths = tuple(MarkerTrajectory.measured(name, x, cov=cov) for name, x in zip(names, xyz, strict=True))
    return Trial("stands", Trajectories(paths, 100.0))


@pytest.mark.parametrize("have", "xyz")
@pytest.mark.parametrize("want", "xyz")
def test_up_is_where_it_is_wanted_whatever_it_was(have, want):
    trial, notes = with_axis_up(standing(up=have), want)
    k = "xyz".index(want)
    assert trial.trajectories["LASI"].xyz[0, k] - trial.trajectories["LANK"].xyz[0, k] == pytest.approx(870)
    assert trial.trajectories["LASI"].cov[0, k, k] == pytest.approx(9)
    back, _ = with_axis_up(trial, have)
    assert np.allclose(back.trajectories.xyz, standing(up=have).trajectories.xyz)
    assert trial.about.get("up", "+Z") == f"+{want.upper()}" and "ankles" in notes[0].what


def test_nothing_is_mirrored_and_x_stays():
    """(x, y, z) with z up is (x, z, -y) with y up, as OpenSim has it."""
    trial, _ = with_axis_up(standing(), "y")
    assert trial.trajectories["LASI"].xyz[0].tolist() == [100, 950, -120]


def test_force_plates_go_with_the_markers():
    plate = ForcePlate(1, np.array([[0.0, 0, 0], [400, 0, 0], [400, 600, 0], [0, 600, 0]]), np.zeros(3), ())
    trial, _ = with_axis_up(replace(standing(), plates=(plate,)), "y")
    assert np.allclose(trial.plates[0].corners[:, 1], 0) and np.allclose(trial.plates[0].corners[2], [400, 0, -600])


def test_the_file_tells_where_markers_do_not(tmp_path):
    trial = replace(standing(names="ABCD", up="y"), about={"up": "+Y"})
    write_c3d(tmp_path / "y.c3d", trial)
    doc = read_c3d(tmp_path / "y.c3d")
    assert doc.about["up"] == "+Y" and doc.source.texts("POINT", "Y_SCREEN") == ("+Y",)
    convert(tmp_path / "y.c3d", tmp_path / "z.c3d", up="z")
    turned = read_c3d(tmp_path / "z.c3d")
    assert "up" not in turned.about and turned.source.texts("POINT", "Y_SCREEN") == ("+Z",)
    assert turned.trajectories["A"].xyz[0, 2] == 950
    write_trc(tmp_path / "silent.trc", standing(names="ABCD").trajectories)
    notes = convert(tmp_path / "silent.trc", tmp_path / "up.trc", up="y")
    assert "where a file does not say it" in notes[0].what
    assert read_trc(tmp_path / "up.trc")["A"].xyz[0, 1] == 950


def screen_of(path, target):
    """What a C3D file that is made of it says of the axis that goes up, and the notes."""
    notes = convert(path, target)
    return read_c3d(target).source.texts("POINT", "Y_SCREEN"), [note.what for note in notes]


def test_a_c3d_file_made_of_a_silent_one_claims_what_its_markers_show(tmp_path):
    write_trc(tmp_path / "y.trc", standing(up="y").trajectories)
    said, notes = screen_of(tmp_path / "y.trc", tmp_path / "y.c3d")
    assert said == ("+Y",) and "from the ankles to the pelvis" in notes[0]
    write_trc(tmp_path / "z.trc", standing().trajectories)
    assert screen_of(tmp_path / "z.trc", tmp_path / "z.c3d")[0] == ("+Z",)
    write_trc(tmp_path / "none.trc", standing(names="ABCD").trajectories)
    said, notes = screen_of(tmp_path / "none.trc", tmp_path / "none.c3d")
    assert said == () and "not shown by the markers" in notes[0]
    convert(tmp_path / "none.trc", tmp_path / "told.c3d", up="z")
    assert read_c3d(tmp_path / "told.c3d").source.texts("POINT", "Y_SCREEN") == ("+Z",)


@pytest.mark.parametrize("k", [0, 1, 2])
def test_markers_without_names_that_stand_on_the_floor_show_what_is_up(k):
    """Twelve on a body, 300 mm wide and 1700 high; where it lies high up or is a limb, nothing is claimed."""
    rng = np.random.default_rng(k)
    body = np.roll(
        rng.uniform([0, 0, 20], [300, 300, 40], (12, 3)) + np.outer(np.arange(12), [0, 0, 150]), k - 2, axis=1
    )

    def said(xyz):
        paths = tuple(MarkerTrajectory.measured(f"m{i}", np.tile(x, (4, 1))) for i, x in enumerate(xyz))
        return with_axis_said(Trial("body", Trajectories(paths, 100.0)))[0].about

    assert said(body) == {"up": f"+{'XYZ'[k]}"}
    assert said(body + 1500.0) == {} and said(0.3 * body) == {}


def test_what_has_no_vertical_is_refused():
    turn = Rotation.from_euler("x", 45, degrees=True).as_matrix()
    xyz = standing().trajectories.xyz @ turn
    askew = tuple(MarkerTrajectory.measured(n, x) for n, x in zip(("LASI", "RASI", "LANK", "RANK"), xyz, strict=True))
    with pytest.raises(KinemarkError, match="no axis is up"):
        with_axis_up(Trial("askew", Trajectories(askew, 100.0)), "z")


def test_a_bts_trial_has_y_up(tmp_path):
    convert(shared_data("cameras/gait9_bts/gait9.tdf"), tmp_path / "y.c3d")
    assert read_c3d(tmp_path / "y.c3d").about["up"] == "+Y"


def test_a_sign_of_the_screen_is_none_of_the_worlds():
    """Of three public files that say -Z each has z up."""
    assert "up" not in read_c3d(shared_data("mocap3d/qualisys_gait/Static - CGM2 1.c3d")).about


def test_a_walk_comes_back(tmp_path):
    write_trc(tmp_path / "z.trc", walking(duration_s=0.3, rate=50.0).trajectories)
    convert(tmp_path / "z.trc", tmp_path / "y.trc", up="y")
    convert(tmp_path / "y.trc", tmp_path / "again.trc", up="z")
    assert np.allclose(read_trc(tmp_path / "again.trc").xyz, read_trc(tmp_path / "z.trc").xyz)
