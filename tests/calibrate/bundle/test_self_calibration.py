"""Cameras from one waved marker: simulated, and real runs beside another program's calibration of them."""

import shutil

import numpy as np
import pytest

from kinemark.calibrate.bundle import Bundle, calibrate_points
from kinemark.calibrate.world_frame import fit_scaled, similarity
from kinemark.data import KinemarkError
from kinemark.geometry import project
from kinemark.io.selfcal import read_pmat, read_rad, read_selfcal
from kinemark.synth import ring
from support.shared import shared_data
from support.studies import figures, printed

MIDDLE = np.array([1200.0, 700.0, 1000.0])


def waved(rig, n, *, noise=0.1, wrong=0.0, hidden=0.0, seed=0):
    """Places of a marker (N, 3) and its pixels (C, N, 2)."""
    rng = np.random.default_rng(seed)
    xyz = MIDDLE + rng.uniform(-1, 1, (n, 3)) * [1000, 700, 800]
    uv = np.stack([project(camera, xyz) for camera in rig]) + noise * rng.normal(size=(len(rig), n, 2))
    uv[rng.random(uv.shape[:2]) < hidden] = np.nan
    bad = (rng.random(uv.shape[:2]) < wrong) & np.isfinite(uv[..., 0])
    uv[bad] = rng.uniform(0, 1000, (bad.sum(), 2))
    return xyz, uv, bad


def sizes(rig):
    return [camera.size for camera in rig]


def test_a_waved_marker_gives_cameras_up_to_scale():
    rig = ring(4, distortion=(-0.12, 0, 0, 0, 0))
    xyz, uv, bad = waved(rig, 250, wrong=0.02, hidden=0.2)
    fit = calibrate_points(rig.names, sizes(rig), uv)
    assert np.linalg.norm(fit.rig.centres[1] - fit.rig.centres[0]) == pytest.approx(1000)
    assert not (fit.kept & bad).any()
    used = np.isfinite(fit.xyz).all(1)
    A, b, s = similarity(fit.xyz[used], xyz[used], scale=True)
    assert np.sqrt(((s * fit.xyz[used] @ A.T + b - xyz[used]) ** 2).sum(1).mean()) < 0.6
    sd = np.sqrt([camera.cov[0, 0] for camera in fit.rig])
    assert np.abs([camera.K[0, 0] - 1300 for camera in fit.rig] / sd).max() < 4.5
    one, other = np.flatnonzero(used)[[0, -1]]
    true = np.linalg.norm(xyz[one] - xyz[other])
    in_mm = fit_scaled(fit, true / np.linalg.norm(fit.xyz[one] - fit.xyz[other]))
    A, b, _ = similarity(in_mm.xyz[used], xyz[used])
    assert np.sqrt(((in_mm.xyz[used] @ A.T + b - xyz[used]) ** 2).sum(1).mean()) < 1.5


def test_two_cameras_need_their_lenses():
    rig = ring(2, sweep_deg=70.0, distortion=(-0.1, 0, 0, 0, 0))
    xyz, uv, _ = waved(rig, 100)
    with pytest.raises(KinemarkError, match="three are needed"):
        calibrate_points(rig.names, sizes(rig), uv)
    fit = calibrate_points(rig.names, sizes(rig), uv, lenses=list(rig))
    assert np.array_equal(fit.rig[1].K, rig[1].K)
    A, b, s = similarity(fit.xyz, xyz, scale=True)
    assert np.sqrt(((s * fit.xyz @ A.T + b - xyz) ** 2).sum(1).mean()) < 1.5


def test_a_camera_that_shares_nothing_is_named():
    rig = ring(4)
    _, uv, _ = waved(rig, 80)
    uv[3, 20:] = np.nan
    with pytest.raises(KinemarkError, match=r"cam4 cannot be joined .* 20 places in common"):
        calibrate_points(rig.names, sizes(rig), uv)
    with pytest.raises(ValueError, match="uv has shape"):
        calibrate_points(rig.names, sizes(rig), uv[0])


def test_real_runs_are_as_good_as_the_program_made_for_them():
    """The run with a reference: our residual is no larger, and the cameras stand where it says."""
    shared_data("cameras/single_led_selfcal")
    text = printed("self_calibration", "20130726")
    theirs, ours = figures(text, "MultiCamSelfCal, lenses linearised")[0], figures(text, "from image sizes alone")
    assert ours[0] <= theirs
    assert ours[1] < 0.5  # % of the cameras' spread between camera centres
    assert figures(text, "with the same lenses")[1] < 0.6


def test_the_folders_are_read():
    folder = shared_data("cameras/single_led_selfcal/mcsc_output_20130726")
    found = read_selfcal(folder)
    assert found.names[0] == "Basler_21275576"
    assert found.uv.shape == (4, 464, 2)
    assert np.isfinite(found.uv).all(-1).sum(1).tolist() == [459, 376, 320, 444]
    assert found.sizes.tolist() == [[659, 494]] * 4
    assert found.lenses[0].K[0, 0] == 422.202325
    assert found.lenses[0].distortion.tolist() == [-0.280971, 0.074959, 0.000404, -0.000104, 0]
    assert found.P.shape == (4, 3, 4)
    bare = read_selfcal(folder.parent / "DATA20090709_111010")
    assert bare.lenses is None
    assert bare.P is None


@pytest.fixture
def folder(tmp_path):
    """A small folder of the kind."""
    (tmp_path / "Res.dat").write_text("640 480\n640 480\n")
    (tmp_path / "IdMat.dat").write_text("1 0 1\n1 1 1\n")
    (tmp_path / "points.dat").write_text("# name: x\n1 2 3\n4 5 6\n1 1 1\n7 8 NaN\n10 11 NaN\n1 1 1\n")
    (tmp_path / "a1.rad").write_text(
        "".join(f"K{i}{j} = {500 * (i == j < 3) + (i == j == 3)}\n" for i in (1, 2, 3) for j in (1, 2, 3))
        + "kc1 = -0.1\nkc2 = 0\nkc3 = 0\nkc4 = 0\n"
    )
    return tmp_path


def test_what_was_not_seen_is_missing(folder):
    shutil.copy(folder / "a1.rad", folder / "a2.rad")
    found = read_selfcal(folder)
    assert found.names == ("camera1", "camera2")
    assert np.array_equal(found.uv[0], [[1, 4], [np.nan, np.nan], [3, 6]], equal_nan=True)
    assert np.isnan(found.uv[1, 2]).all()
    assert found.lenses[1].distortion[0] == -0.1


def test_broken_folders_are_explained(folder):
    with pytest.raises(KinemarkError, match=r"cameras \[1\], and none for \[2\]"):
        read_selfcal(folder)
    (folder / "a1.rad").write_text("K11 = 500\nnonsense\n")
    with pytest.raises(KinemarkError, match="line 2: wanted NAME = NUMBER"):
        read_rad(folder / "a1.rad")
    (folder / "a1.rad").write_text("K11 = 500\n")
    with pytest.raises(KinemarkError, match="has no K12"):
        read_rad(folder / "a1.rad")
    (folder / "p.cal").write_text("1 2 3\n")
    with pytest.raises(KinemarkError, match="1 rows of 3 numbers"):
        read_pmat(folder / "p.cal")
    (folder / "a1.rad").unlink()
    (folder / "camera_order.txt").write_text("one\n")
    with pytest.raises(KinemarkError, match="1 names"):
        read_selfcal(folder)
    (folder / "IdMat.dat").write_text("1 0\n1 1\n")
    with pytest.raises(KinemarkError, match=r"points\.dat has 6 rows of 3, IdMat\.dat 2 of 2"):
        read_selfcal(folder)
    (folder / "points.dat").write_text("1 2 x\n")
    with pytest.raises(KinemarkError, match="line 1"):
        read_selfcal(folder)
    (folder / "Res.dat").write_text("640.5 480\n")
    with pytest.raises(KinemarkError, match="whole number"):
        read_selfcal(folder)
    with pytest.raises(KinemarkError, match="no folder"):
        read_selfcal(folder / "nowhere")


def test_more_lens_terms_fit_better_and_say_how_sure_they_are():
    rig = ring(3, distortion=(-0.15, 0.08, 0, 0, 0), focal_px=900.0)
    _, uv, _ = waved(rig, 150)
    few, more = (calibrate_points(rig.names, sizes(rig), uv, method=Bundle(radial=r, reject=np.inf)) for r in (1, 2))
    assert more.chi2 < few.chi2
    assert all(abs(c.distortion[1] - 0.08) < 4.5 * c.cov[5, 5] ** 0.5 for c in more.rig)
