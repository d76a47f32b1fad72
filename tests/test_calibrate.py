"""Control points: exact data give the exact camera, noisy data a true error bar, bad data a clear refusal."""

from dataclasses import replace

import numpy as np
import pytest
from shared import shared_data

from kinemark.calibrate import ControlPoints, calibrate_control_points
from kinemark.calibrate.control_points import fit_camera, free_parameters
from kinemark.data import PARAMETERS, KinemarkError
from kinemark.geometry import (
    fit_dlt,
    from_dlt,
    parameter_jacobian,
    project,
    project_all,
    triangulate,
    undistort,
)
from kinemark.synth import ring
from kinemark.synth.targets import calibration_box, control_frame

FRAME = control_frame().xyz.reshape(-1, 3)
BOX = calibration_box(1400.0).xyz[:, 0]
INSIDE = np.random.default_rng(0).uniform([300, 200, 200], [2100, 1200, 1700], (40, 3))
BARREL = (-0.12, 0.0, 0.0, 0.0, 0.0)


def calibrated(rig, xyz, uv, **options):
    return calibrate_control_points(rig.names, [camera.size for camera in rig], xyz, uv, **options)


def squares(n):
    return np.tile(np.eye(2), (n, 1, 1))


@pytest.mark.parametrize(
    ("xyz", "lens", "method"),
    [
        (FRAME, (0.0,) * 5, ControlPoints(radial=0)),
        (FRAME, BARREL, ControlPoints()),
        (FRAME, (-0.12, 0.03, 1e-3, -5e-4, 0.0), ControlPoints(radial=2, tangential=True)),
        (BOX, (0.0,) * 5, ControlPoints()),
    ],
)
def test_exact_points_give_the_exact_camera(xyz, lens, method):
    rig = ring(4, distortion=lens)
    found = calibrated(rig, xyz, project_all(rig, xyz), method=method)
    for camera, true in zip(found, rig, strict=True):
        np.testing.assert_allclose(camera.K, true.K, rtol=1e-5, atol=1e-5 * true.K[0, 0])
        np.testing.assert_allclose(camera.centre, true.centre, atol=0.05)
        np.testing.assert_allclose(project(camera, INSIDE), project(true, INSIDE), atol=1e-4)
        assert camera.residual < 1e-5
    np.testing.assert_array_equal(found.volume, [xyz.min(0), xyz.max(0)])


def test_a_camera_whose_v_counts_upwards():
    true = ring(1)[0]
    flipped = replace(true, K=np.diag([1.0, -1.0, 1.0]) @ true.K)
    found = calibrate_control_points(["up"], [(0, 0)], FRAME, project(flipped, FRAME)[None])[0]
    np.testing.assert_allclose(found.K, flipped.K, atol=1e-3)
    np.testing.assert_allclose(found.R, true.R, atol=1e-7)


@pytest.mark.parametrize(
    ("n", "lens", "method"),
    [(24, BARREL, ControlPoints()), (24, (0.0,) * 5, ControlPoints(radial=0)), (16, BARREL, ControlPoints())],
)
def test_unseen_points_are_as_far_off_as_the_covariance_says(n, lens, method):
    """chi² of the projection of points that took no part has mean 2, whatever size the noise has."""
    rng = np.random.default_rng(n)
    true, chi2 = ring(3, distortion=lens)[1], []
    for _ in range(100):
        xyz = FRAME[rng.permutation(24)[:n]]
        uv = project(true, xyz) + rng.normal(0, 0.07, (n, 2))
        camera, _ = fit_camera("a", true.size, xyz, uv, squares(n), method=method)
        J = parameter_jacobian(camera, INSIDE)
        off = project(camera, INSIDE) - project(true, INSIDE)
        chi2.append(np.einsum("ni,nij,nj->n", off, np.linalg.inv(J @ camera.cov @ J.transpose(0, 2, 1)), off).mean())
    assert 1.6 < np.mean(chi2) < 2.4


def test_covariance_has_zero_rows_for_what_was_not_fitted_and_scales_with_the_noise():
    true, noise = ring(1)[0], np.random.default_rng(2).normal(size=(24, 2))
    one, ten = (
        fit_camera("a", true.size, FRAME, project(true, FRAME) + k * noise, squares(24), method=ControlPoints())[0]
        for k in (0.01, 0.1)
    )
    fitted = np.diag(one.cov) > 0
    assert [p for p, free in zip(PARAMETERS, fitted, strict=True) if not free] == ["k2", "p1", "p2", "k3"]
    assert not one.cov[~fitted].any() and not one.cov[:, ~fitted].any()
    np.testing.assert_allclose(np.diag(ten.cov), 100 * np.diag(one.cov), rtol=0.05)


def test_precise_points_count_more():
    """Half of the points are ten times noisier; saying so must help, and the proportion alone matters."""
    rng, true = np.random.default_rng(3), ring(1)[0]
    sigma = np.where(np.arange(24) % 2, 1.0, 0.1)
    cov = squares(24) * (sigma**2)[:, None, None]
    off = {"said": [], "unsaid": []}
    for _ in range(20):
        uv = (project(true, FRAME) + sigma[:, None] * rng.normal(size=(24, 2)))[None]
        said, louder = (calibrate_control_points(["a"], [(0, 0)], FRAME, uv, cov=s * cov[None])[0] for s in (1, 7))
        np.testing.assert_allclose(louder.cov, said.cov, rtol=1e-4, atol=1e-9)
        unsaid = calibrate_control_points(["a"], [(0, 0)], FRAME, uv)[0]
        for name, camera in (("said", said), ("unsaid", unsaid)):
            off[name].append(project(camera, INSIDE) - project(true, INSIDE))
    assert np.std(off["said"]) < 0.5 * np.std(off["unsaid"])


def test_the_world_may_be_moved():
    rng, true = np.random.default_rng(4), ring(1, distortion=BARREL)[0]
    uv = (project(true, FRAME) + rng.normal(0, 0.1, (24, 2)))[None]
    shift = np.array([5000.0, -3000.0, 800.0])
    here = calibrate_control_points(["a"], [(0, 0)], FRAME, uv)[0]
    there = calibrate_control_points(["a"], [(0, 0)], FRAME + shift, uv)[0]
    np.testing.assert_allclose(there.centre, here.centre + shift, atol=1e-2)
    np.testing.assert_allclose(project(there, INSIDE + shift), project(here, INSIDE), atol=1e-5)


@pytest.mark.parametrize("wrong", [1, 3])
def test_misread_points_are_left_out(wrong):
    rng, rig = np.random.default_rng(5), ring(3, distortion=BARREL)
    clean = project_all(rig, FRAME) + rng.normal(0, 0.05, (3, 24, 2))
    uv = clean.copy()
    uv[:, :wrong] += rng.choice([-1, 1], (3, wrong, 2)) * rng.uniform(4, 15, (3, wrong, 2))
    robust, naive = (calibrated(rig, FRAME, uv, method=ControlPoints(reject=r)) for r in (5.0, np.inf))
    assert robust.method.endswith(f"left out: cam1 {wrong}, cam2 {wrong}, cam3 {wrong}") and "left" not in naive.method
    without = calibrated(rig, FRAME[wrong:], clean[:, wrong:])
    for good, bad, best, true in zip(robust, naive, without, rig, strict=True):
        np.testing.assert_allclose(project(good, INSIDE), project(best, INSIDE), atol=1e-6)
        assert np.abs(project(bad, INSIDE) - project(true, INSIDE)).max() > 0.3


def test_unseen_points_take_no_part():
    rng, rig = np.random.default_rng(6), ring(2, distortion=BARREL)
    uv = project_all(rig, FRAME) + rng.normal(0, 0.05, (2, 24, 2))
    uv[0, ::4] = np.nan
    seen = np.arange(24) % 4 > 0
    part, alone = calibrated(rig, FRAME, uv), calibrated(rig, FRAME[seen], uv[:, seen])
    np.testing.assert_allclose(part[0].P, alone[0].P, rtol=1e-9)


@pytest.mark.parametrize(
    ("n", "terms"), [(6, []), (10, []), (11, ["k1"]), (12, ["k1", "k2"]), (14, ["k1", "k2", "p1", "p2"])]
)
def test_lens_terms_need_points(n, terms):
    free = free_parameters(n, ControlPoints(radial=2, tangential=True))
    named = [p for p, f in zip(PARAMETERS, free, strict=True) if f and p[0] in "kp"]
    assert named == terms


def test_a_frame_of_24_markers_returns_them_within_the_published_error():
    """KISS 3.3: reference markers came back within 0.6 mm mean in 1.4 × 2.4 × 2 m."""
    rng, rig = np.random.default_rng(7), ring(6, distortion=BARREL)
    found = calibrated(rig, FRAME, project_all(rig, FRAME) + rng.normal(0, 0.1, (6, 24, 2)))
    uv = project_all(rig, INSIDE) + rng.normal(0, 0.1, (6, 40, 2))
    ideal = np.stack([undistort(camera, points) for camera, points in zip(found, uv, strict=True)], 1)
    off = np.linalg.norm(triangulate(ideal, found.P) - INSIDE, axis=1)
    assert off.mean() < 0.6


def test_errors_name_the_camera_and_say_what_to_do():
    rig = ring(2)
    uv = project_all(rig, FRAME)
    few = uv.copy()
    few[1, 5:] = np.nan
    with pytest.raises(KinemarkError, match=r"Camera cam2: 5 control points.*six"):
        calibrated(rig, FRAME, few)
    with pytest.raises(KinemarkError, match=r"Camera cam1: .*plane"):
        calibrated(rig, FRAME[:12], uv[:, :12])  # two rods
    with pytest.raises(KinemarkError, match=r"Camera cam1: .*plane"):
        calibrated(rig, FRAME[[0, 0, 0, 0, 5, 7, 12]], uv[:, [0, 0, 0, 0, 5, 7, 12]])
    shuffled = np.random.default_rng(0).permutation(24)
    with pytest.raises(KinemarkError, match=r"Camera cam1: .*order"):
        calibrated(rig, FRAME, uv[:, shuffled])


@pytest.mark.parametrize("what", ["sizes", "xyz", "uv", "cov"])
def test_arrays_that_do_not_fit(what):
    rig = ring(2)
    arrays = {"sizes": np.zeros((2, 2)), "xyz": FRAME, "uv": project_all(rig, FRAME), "cov": np.zeros((2, 24, 2, 2))}
    arrays[what] = {"sizes": arrays["sizes"][:1], "xyz": FRAME[:, :2]}.get(what, arrays[what][:, :5])
    with pytest.raises(ValueError, match=rf"{what} has shape .* wanted"):
        calibrate_control_points(rig.names, arrays["sizes"], arrays["xyz"], arrays["uv"], cov=arrays["cov"])


@pytest.mark.parametrize("wrong", [{"radial": 4}, {"radial": -1}, {"reject": 1.0}, {"reject": float("nan")}])
def test_parameters_out_of_range(wrong):
    with pytest.raises(ValueError, match="wanted"):
        ControlPoints(**wrong)


def dlt_rms(xyz, uv):
    h = np.column_stack([xyz, np.ones(len(xyz))]) @ from_dlt(fit_dlt(xyz, uv)).T
    return np.sqrt(np.mean(((h[:, :2] / h[:, 2:] - uv) ** 2).sum(1)))


@pytest.mark.parametrize(("camera", "limit"), [(1, 0.30), (2, 0.22), (3, 0.19), (4, 0.32), (5, 0.38)])
def test_real_resection_of_a_moving_light(camera, limit):
    """Hundreds of points seen by a lens that bends: one lens term beats the eleven parameters where it matters."""
    folder = shared_data("cameras/resection_5cam/tests/sample_calibration")
    table = np.loadtxt(folder / f"cam{camera}.points4cal.dat")
    xyz, uv = table[:, :3], table[:, 4:6]
    found = calibrate_control_points(["a"], [(656, 491)], xyz, uv[None])[0]
    assert found.residual < limit
    assert found.residual < 1.05 * dlt_rms(xyz, uv) and 0.18 < dlt_rms(xyz, uv) < 0.87


@pytest.mark.parametrize(("camera", "dlt", "residual"), [(1, 0.35, 0.40), (2, 1.68, 2.63), (3, 1.20, 1.29)])
def test_real_six_point_frame_of_film_cameras(camera, dlt, residual):
    folder = shared_data("cameras/kinemat_running_3cam")
    xyz, uv = np.loadtxt(folder / "calframe.txt"), np.loadtxt(folder / f"r1cam{camera}.cal")[:6]
    assert abs(dlt_rms(xyz, uv) - dlt) < 0.01
    found = calibrate_control_points(["a"], [(0, 0)], xyz, uv[None])[0]
    assert found.residual < residual and found.K[0, 1] == 0
    assert abs(found.K[0, 0] / -found.K[1, 1] - 1) < 0.02  # digitised film, v upwards, square to 2 %


def test_a_real_bad_calibration_shows_as_bad():
    """Poles surveyed wrongly: the residual must say so, and nothing may be thrown away to hide it."""
    folder = shared_data("cameras/bad_control_frame_8cam")
    xyz = 1000 * np.loadtxt(folder / "ref3d_realworld/ref3d_realworld.csv", delimiter=",")
    for c in range(1, 9):
        row = np.loadtxt(folder / f"pixelcorrds/c0{c}_markers_1_line.csv", delimiter=",", skiprows=1, ndmin=2)[0]
        camera = calibrate_control_points([f"c{c}"], [(1920, 1080)], xyz, row[1:].reshape(1, -1, 2))[0]
        off = np.linalg.norm(project(camera, xyz) - row[1:].reshape(-1, 2), axis=1)
        np.testing.assert_allclose(camera.residual, np.sqrt(np.mean(off**2)))
        assert camera.residual > 1.5 and (c == 5 or off[20:].mean() > 1.5 * off[:20].mean())  # the fifth pole
