"""The flow of UM²AS from control balls to angles: functions and files."""

from datetime import date
from itertools import combinations

import numpy as np
import pytest
from um2as_equations import fit_parameters, project

from kinemark.data import KinemarkError, Rig
from kinemark.engine.formats import convert, describe
from kinemark.engine.um2as.flow import (
    angles_files,
    calibrate_file,
    calibrated,
    coordinates_files,
    limb_angles,
    placed,
    table,
)
from kinemark.geometry import from_dlt, project_all, to_dlt, triangulate
from kinemark.io.answers_csv import append_answer, read_answers, write_answers
from kinemark.io.c3d import read_c3d
from kinemark.io.um2as import read_angles, read_cp, read_tdc, trajectories_of_tdc, write_da, write_msr, write_tdc
from kinemark.reconstruct import LeastSquares
from kinemark.reconstruct.camera_pairs import agreeing
from kinemark.synth import look_at as aimed
from kinemark.synth import ring, truth
from support.boxed import BALLS, files, seen_balls, seen_meal
from support.eating import CENTRE, SIZE, laboratory, meal

# ---- Calibration ----


def test_parameters_without_noise_are_those_of_the_cameras():
    rig, uv = seen_balls(noise=0)
    found = calibrated(rig.names, BALLS, uv)
    np.testing.assert_allclose(to_dlt(found.P), to_dlt(rig.P), rtol=1e-6, atol=1e-9)


def test_parameters_see_the_balls_as_those_of_the_thesis_do():
    """Equation 2.4 in the raw coordinates weighs errors a little otherwise: by less than a tenth of the noise."""
    rig, uv = seen_balls(noise=0.3)
    found = project_all(calibrated(rig.names, BALLS, uv), BALLS)
    one = np.ones((8, 1))
    for c, own in enumerate(uv):
        u, v = own[:, :1], own[:, 1:]
        A = np.zeros((16, 11))
        A[::2] = np.hstack([BALLS, one, 0 * BALLS, 0 * one, -u * BALLS])
        A[1::2] = np.hstack([0 * BALLS, 0 * one, BALLS, one, -v * BALLS])
        L = np.linalg.lstsq(A, own.ravel(), rcond=None)[0]
        x = np.hstack([BALLS, one]) @ from_dlt(L).T
        assert np.abs(found[c] - x[:, :2] / x[:, 2:]).max() < 0.03


def test_a_camera_from_measured_places_to_its_file(tmp_path):
    write_msr(tmp_path / "box.msr", BALLS)
    rig, uv = seen_balls()
    made, off = calibrate_file(tmp_path / "box.msr", tmp_path / "box.cp2", uv[1])
    assert made.names == ("cam2",) and 0.01 < np.sqrt((off**2).mean()) < 0.2
    np.testing.assert_allclose(read_cp(tmp_path / "box.cp2").L, to_dlt(made.P)[0], atol=0.51e-7)
    moved = project_all(made, BALLS)[0] - project_all(rig, BALLS)[1]
    assert np.abs(moved).max() < 0.5
    with pytest.raises(KinemarkError, match="8 control balls, and 7 were digitised"):
        calibrate_file(tmp_path / "box.msr", tmp_path / "box.cp2", uv[1, :7])
    with pytest.raises(ValueError, match="date"):
        calibrate_file(tmp_path / "box.msr", tmp_path / "box.cp1", uv[0])


def test_no_ball_is_left_out():
    """UM²AS takes all, also one that was pointed at wrongly."""
    rig, uv = seen_balls(0.1)
    uv[0, 3] += (6.0, -4.0)
    mm = np.array([10.0, 10, 10, 1, 10, 10, 10, 1, 10, 10, 10])
    found = np.stack([to_dlt(P) for P in calibrated(rig.names, BALLS, uv).P])
    np.testing.assert_allclose(found * mm, fit_parameters(BALLS, uv) * mm, rtol=2e-2, atol=2e-3)
    without = fit_parameters(np.delete(BALLS, 3, 0), np.delete(uv[0], 3, 0)[None])[0]
    assert np.abs(project(found[0], BALLS) - project(without, BALLS)).max() > 1.0


def test_balls_that_make_no_camera_are_refused(tmp_path):
    rig, uv = seen_balls()
    with pytest.raises(KinemarkError, match="5 control points are seen"):
        calibrated(rig.names, BALLS[:5], uv[:, :5])
    flat = BALLS * (1, 1, 0)
    with pytest.raises(KinemarkError, match="plane"):
        calibrated(rig.names, flat, project_all(rig, flat))


# ---- Places ----


def test_places_are_right_and_those_of_one_camera_are_not_known():
    rig, subject, uv = seen_meal()
    uv[1:, 3, 5] = np.nan  # one camera left
    uv[:, 6] = np.nan  # none
    found = placed(rig, uv, names=subject.names)
    off = np.linalg.norm(found.xyz - subject.xyz, axis=-1)
    expected = np.isfinite(uv[..., 0]).sum(0) >= 2
    assert (np.isfinite(off) == expected).all()
    assert np.sqrt(np.nanmean(off**2)) < 0.5 and found.names == subject.names
    sd = np.sqrt(np.trace(np.array([p.cov for p in found.paths]), axis1=-2, axis2=-1))
    assert np.sqrt(np.nanmean((off / sd) ** 2)) == pytest.approx(1, abs=0.3)


@pytest.mark.parametrize("cameras", [(0, 1), (1, 2), (0, 2), (0, 1, 2)])
def test_two_and_three_cameras_from_files_to_a_file(tmp_path, cameras):
    cps, das, subject = files(tmp_path, cameras)
    found = coordinates_files(cps, das[::-1], tmp_path / "feed.tdc", markers=8)
    np.testing.assert_allclose(read_tdc(tmp_path / "feed.tdc"), found.xyz, atol=0.51e-6)
    off = np.linalg.norm(found.xyz - subject.xyz, axis=-1)
    assert np.sqrt(np.nanmean(off**2)) < 1.5


def test_a_pair_of_cameras_that_stand_side_by_side_is_outvoted():
    """2.8: its solution is far from the other two, which are close together; the mean is of these."""
    beside = np.array([2400.0 * np.cos(0.05), 2400.0 * np.sin(0.05), 0.0])
    rig = laboratory()
    rig = Rig((rig[0], rig[1], aimed("cam3", CENTRE + beside, CENTRE, focal_px=1080.0, size=SIZE)), "placed")
    uv = project_all(rig, CENTRE[None] + 20.0)[:, :, None]
    uv[2, 0, 0, 0] += 4.0
    each = {
        pair: triangulate(uv[list(pair), :, 0].swapaxes(0, 1), rig.P[list(pair)])[0]
        for pair in ((0, 1), (0, 2), (1, 2))
    }
    found = placed(rig, uv).xyz[0, 0]
    np.testing.assert_allclose(found, (each[0, 1] + each[1, 2]) / 2, atol=0.2)
    assert np.linalg.norm(each[0, 2] - found) > 50


def test_four_cameras(tmp_path):
    rig = ring(4, radius=2400.0, target=(420.0, 300.0, 400.0), focal_px=1080.0, size=SIZE)
    subject = meal(0.5)
    sight = truth(rig, subject)
    uv = sight.uv + np.random.default_rng(0).normal(0, 0.1, sight.uv.shape)
    write_msr(tmp_path / "box.msr", BALLS)
    for c, balls in enumerate(project_all(rig, BALLS)):
        calibrate_file(tmp_path / "box.msr", tmp_path / f"box.cp{c + 1}", balls, made=date(2026, 1, 2))
        write_da(tmp_path / f"feed.da{c + 1}", uv[c])
    cps, das = ([tmp_path / f"{n}{c}" for c in (1, 2, 3, 4)] for n in ("box.cp", "feed.da"))
    off = np.linalg.norm(coordinates_files(cps, das, tmp_path / "feed.tdc").xyz - subject.xyz, axis=-1)
    assert np.sqrt((off**2).mean()) < 0.5


def test_equation_2_5_weighs_a_little_otherwise():
    """By the scale of L instead of by depth, which moves places by a small part of their error."""
    rig, subject, uv = seen_meal(noise=0.2)
    ours = placed(rig, uv).xyz
    P = from_dlt(to_dlt(rig.P))
    seen = uv.reshape(3, -1, 2).transpose(1, 0, 2)
    pairs = list(combinations(range(3), 2))
    each = np.stack([triangulate(seen[:, pair], P[list(pair)]) for pair in pairs], 1)
    kept = agreeing(each, np.isfinite(seen[..., 0]).sum(1))
    thesis = (np.nansum(np.where(kept[..., None], each, 0), 1) / kept.sum(1)[:, None]).reshape(ours.shape)
    off = [np.sqrt(np.nanmean((xyz - subject.xyz) ** 2)) for xyz in (ours, thesis)]
    assert off[0] == pytest.approx(off[1], rel=0.1)
    assert np.sqrt(np.nanmean((ours - thesis) ** 2)) < off[0] / 2


def test_other_methods_of_reconstruction_do_as_well():
    rig, subject, uv = seen_meal(noise=0.3)
    pairs, least = (np.nanmean((placed(rig, uv, **m).xyz - subject.xyz) ** 2) for m in ({}, {"method": LeastSquares()}))
    assert least < pairs


def test_sets_that_do_not_fit_are_refused(tmp_path):
    cps, das, _ = files(tmp_path)
    out = tmp_path / "feed.tdc"
    for some_cps, some_das, message in (
        (cps[:2], das, "calibration is of cam1, cam2 and the motion of cam1, cam2, cam3"),
        (cps[:2], das[::2], "files of the same cameras"),
        (cps[:1], das[:1], "needs two"),
        ([cps[0], cps[0]], das[:2], "both of camera 1"),
        (cps[1:], das[1:], "does not say how many markers"),
    ):
        with pytest.raises(KinemarkError, match=message):
            coordinates_files(some_cps, some_das, out)
        assert not out.exists()
    with pytest.raises(ValueError, match="names"):
        placed(laboratory(), np.zeros((3, 2, 4, 2)), names=["a"])


# ---- Angles ----


def test_angles_from_files_are_those_that_made_the_motion(tmp_path):
    cps, das, subject = files(tmp_path)
    coordinates_files(cps, das, tmp_path / "feed.tdc")
    angles_files(tmp_path / "feed.tdc")
    for j, ending in enumerate((".shd", ".elb", ".wst")):
        off = read_angles(tmp_path / f"feed{ending}") - subject.angles.deg[j]
        assert np.sqrt(np.nanmean(off**2)) < 1.0


def test_inverse_cosines_have_no_sign(tmp_path):
    subject = meal(1.0)
    paths = placed(laboratory(), truth(laboratory(), subject).uv)
    signed, plain = limb_angles(paths), limb_angles(paths, signed=False)
    np.testing.assert_allclose(plain.deg[:, :, 0], np.abs(signed.deg[:, :, 0]), atol=0.5)
    assert (signed.deg[2, :, 0] < -1).any()


def test_named_outputs_and_wrong_ones(tmp_path):
    cps, das, _ = files(tmp_path)
    tdc = tmp_path / "feed.tdc"
    coordinates_files(cps, das, tdc)
    angles_files(tdc, [tmp_path / "only.elb"])
    assert {p.name for p in tmp_path.glob("*.elb")} == {"only.elb"} and not list(tmp_path.glob("*.shd"))
    with pytest.raises(KinemarkError, match="does not end in"):
        angles_files(tdc, [tmp_path / "feed.txt"])
    with pytest.raises(KinemarkError, match="names are given"):
        trajectories_of_tdc(tdc, rate=30.0, names=["a"])


def test_places_become_a_c3d_file(tmp_path):
    xyz = np.random.default_rng(0).normal(0, 500, (3, 5, 3)).round(1)
    write_tdc(tmp_path / "feed.tdc", xyz)
    convert(tmp_path / "feed.tdc", tmp_path / "feed.c3d", rate_hz=60.0)
    back = read_c3d(tmp_path / "feed.c3d").trajectories
    np.testing.assert_allclose(back.xyz, xyz, atol=1e-3)
    assert back.rate == 60.0 and back.names == ("1", "2", "3")
    assert describe(tmp_path / "feed.tdc")["rate_hz"] == 30.0


def test_every_file_can_be_looked_at(tmp_path):
    cps, das, _ = files(tmp_path)
    coordinates_files(cps, das, tmp_path / "feed.tdc")
    angles_files(tmp_path / "feed.tdc")
    for name, rows in (("box.msr", 8), ("box.cp1", 11), ("feed.da1", 360), ("feed.tdc", 360), ("feed.wst", 45)):
        assert len(table(tmp_path / name)[1]) == rows
    assert table(tmp_path / "box.msr")[1][0] == pytest.approx((1, 72.2, 40.5, -6.4))
    with pytest.raises(KinemarkError, match="none of UM²AS's files"):
        table(tmp_path / "feed.c3d")


# ---- The answers' file ----


def test_answers_are_kept_as_they_were_given(tmp_path):
    path = tmp_path / "a" / "cam1.csv"
    assert read_answers(path) == []
    path.parent.mkdir()
    path.write_text("frame,marker,answer\n1,ELB4,312 204\n1,MC37,-\n1,,save\n")
    given = read_answers(path)
    assert [g.frame for g in given] == [0, 0, 0] and given[2].marker == ""
    append_answer(path, given[0])
    assert read_answers(path) == [*given, given[0]]
    write_answers(tmp_path / "b.csv", given)
    assert read_answers(tmp_path / "b.csv") == given


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("marker,frame,answer\n", "line 1: wanted the heading"),
        ("frame,marker,answer\n1,a\n", "line 2: has 2 cells"),
        ("frame,marker,answer\n0,a,-\n", "frame is '0'"),
        ("frame,marker,answer\n1,a,maybe\n", "line 2: 'maybe' is not understood"),
    ],
)
def test_wrong_answers_are_refused(tmp_path, text, message):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(KinemarkError, match=message):
        read_answers(tmp_path / "a.csv")
