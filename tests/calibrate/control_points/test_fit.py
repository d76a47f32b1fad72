"""Control points: exact data give the exact camera, noisy data a true error bar, bad data a clear refusal."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.calibrate import ControlPoints, Dlt, calibrate_control_points, control_point_quality
from kinemark.calibrate.control_points import fit_camera, free_parameters
from kinemark.calibrate.control_points.left_out import errors_without
from kinemark.data import PARAMETERS, Rig
from kinemark.geometry import (
    fit_dlt,
    from_dlt,
    parameter_jacobian,
    project,
    project_all,
    refine,
    sphere_offset,
    triangulate,
    undistort,
)
from kinemark.geometry.dlt import equations
from kinemark.synth import ring
from kinemark.synth.targets import calibration_box, control_frame
from support.shared import shared_data

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
        (FRAME, (0.0,) * 5, Dlt()),
        (BOX, (0.0,) * 5, Dlt()),
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
    [
        (24, BARREL, ControlPoints()),
        (24, (0.0,) * 5, ControlPoints(radial=0)),
        (16, BARREL, ControlPoints()),
        (24, (0.0,) * 5, Dlt()),
    ],
)
def test_unseen_points_are_as_far_off_as_the_covariance_says(n, lens, method):
    """chi² of the projection of points that took no part has mean 2, whatever size the noise has."""
    rng = np.random.default_rng(n)
    true, chi2 = ring(3, distortion=lens)[1], []
    for _ in range(60):
        xyz = FRAME[rng.permutation(24)[:n]]
        uv = project(true, xyz) + rng.normal(0, 0.07, (n, 2))
        camera = fit_camera("a", true.size, xyz, uv, squares(n), method=method).camera
        J = parameter_jacobian(camera, INSIDE)
        off = project(camera, INSIDE) - project(true, INSIDE)
        chi2.append(np.einsum("ni,nij,nj->n", off, np.linalg.inv(J @ camera.cov @ J.transpose(0, 2, 1)), off).mean())
    assert 1.6 < np.mean(chi2) < 2.4


def test_covariance_has_zero_rows_for_what_was_not_fitted_and_scales_with_the_noise():
    true, noise = ring(1)[0], np.random.default_rng(2).normal(size=(24, 2))
    one, ten = (
        fit_camera("a", true.size, FRAME, project(true, FRAME) + k * noise, squares(24), method=ControlPoints()).camera
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


def plain_dlt(xyz, uv):
    """UM²AS eq. 2.4 as it is printed."""
    rows = []
    for (x, y, z), (u, v) in zip(xyz, uv, strict=True):
        rows.append([x, y, z, 1, 0, 0, 0, 0, -u * x, -u * y, -u * z])
        rows.append([0, 0, 0, 0, x, y, z, 1, -v * x, -v * y, -v * z])
    A = np.array(rows)
    return np.linalg.lstsq(A, uv.ravel(), rcond=None)[0], A


@pytest.mark.parametrize("xyz", [FRAME, BOX])
def test_the_dlt_is_that_of_the_thesis_and_better_conditioned(xyz):
    true = ring(3)[1]
    uv = project(true, xyz)
    L, A = plain_dlt(xyz, uv)
    np.testing.assert_allclose(fit_dlt(xyz, uv), L, rtol=1e-6)
    normalised, _, _ = equations(xyz, uv)
    s, plain = (np.linalg.svd(M, compute_uv=False) for M in (normalised.reshape(-1, 12), A))
    assert s[0] / s[10] < 1e-4 * plain[0] / plain[10]
    far = xyz + 1e6  # a national grid
    with_noise = project(true, xyz) + np.random.default_rng(0).normal(0, 0.1, uv.shape)
    assert dlt_rms(far, with_noise) == pytest.approx(dlt_rms(xyz, with_noise), rel=1e-3)


def test_the_dlt_alone_sees_pixel_axes_at_any_angle():
    true = ring(1)[0]
    K = true.K.copy()
    K[0, 1] = 40.0  # pixel axes 88.5° apart
    slanted = replace(true, K=K)
    uv = project(slanted, FRAME)[None]
    found = calibrate_control_points(["a"], [true.size], FRAME, uv, method=Dlt())
    np.testing.assert_allclose(found[0].K, K, rtol=1e-6, atol=1e-3)
    assert found.method == "control points: DLT, 24 points"
    np.testing.assert_allclose(project(found[0], INSIDE), project(slanted, INSIDE), atol=1e-5)
    assert calibrate_control_points(["a"], [true.size], FRAME, uv)[0].residual > 1


def linearised(camera, zoom=1.0, cov=None):
    """The same lens, found at another focal length: K's scale and the terms differ, pixels are bent alike."""
    K = camera.K @ np.diag([1 / zoom, 1 / zoom, 1.0])
    lens = camera.distortion / zoom ** np.array([2, 4, 1, 1, 6])
    return replace(
        camera, K=K, R=np.eye(3), t=np.zeros(3), distortion=lens, cov=np.zeros((15, 15)) if cov is None else cov
    )


@pytest.mark.parametrize("zoom", [1.0, 0.7, 1.6])
def test_a_linearised_lens_is_kept_in_pixels(zoom):
    rig = ring(3, distortion=(-0.2, 0.05, 1e-3, -5e-4, -0.01))
    lenses = [linearised(camera, zoom) for camera in rig]
    found = calibrated(rig, FRAME, project_all(rig, FRAME), lenses=lenses)
    for camera, true in zip(found, rig, strict=True):
        np.testing.assert_allclose(camera.K, true.K, atol=1e-5)
        np.testing.assert_allclose(camera.distortion, true.distortion, atol=1e-8)
        np.testing.assert_allclose(camera.centre, true.centre, atol=1e-4)
    six = [0, 5, 6, 11, 12, 17]
    few = calibrated(rig, FRAME[six], project_all(rig, FRAME[six]), lenses=lenses)
    np.testing.assert_allclose(project_all(few, INSIDE), project_all(rig, INSIDE), atol=1e-4)
    assert "lenses as linearised" in found.method
    with pytest.raises(ValueError, match="lenses were given for Dlt"):
        calibrated(rig, FRAME, project_all(rig, FRAME), lenses=lenses, method=Dlt())
    with pytest.raises(ValueError, match="lenses has shape"):
        calibrated(rig, FRAME, project_all(rig, FRAME), lenses=lenses[:2])


def test_a_held_lens_brings_its_own_uncertainty():
    """chi² of unseen points is 2 with the error of the linearisation in the covariance, and far larger without."""
    rng, true = np.random.default_rng(11), ring(3, distortion=BARREL)[1]
    sd = np.zeros(15)
    sd[[2, 3, 4]] = 4.0, 4.0, 0.004  # cx, cy and k1 of the linearisation
    off = {True: [], False: []}
    for _ in range(30):
        uv = project(true, FRAME) + rng.normal(0, 0.02, (24, 2))
        lens = linearised(true, 1.3, np.diag(sd**2))
        error = rng.normal(0, sd)
        K = lens.K.copy()
        K[:2, 2] += error[2:4]
        lens = replace(lens, K=K, distortion=lens.distortion + error[4] * np.eye(5)[0])
        for said in off:
            held = lens if said else replace(lens, cov=np.zeros((15, 15)))
            camera = fit_camera("a", true.size, FRAME, uv, squares(24), method=ControlPoints(), lens=held).camera
            J, d = parameter_jacobian(camera, INSIDE), project(camera, INSIDE) - project(true, INSIDE)
            C = J @ camera.cov @ J.transpose(0, 2, 1) + 1e-12 * np.eye(2)
            off[said].append(np.einsum("ni,nij,nj->n", d, np.linalg.inv(C), d).mean())
    assert 1.2 < np.mean(off[True]) < 2.6 < np.mean(off[False])


def test_large_spheres_are_corrected_for_perspective():
    rig = ring(4, distortion=BARREL)
    uv = np.stack([project(c, FRAME) + sphere_offset(c, FRAME, diameter=120.0) for c in rig])
    plain, corrected = calibrated(rig, FRAME, uv), calibrated(rig, FRAME, uv, diameter=120.0)
    off = [np.abs(project_all(found, INSIDE) - project_all(rig, INSIDE)).max() for found in (plain, corrected)]
    assert off[1] < 1e-4 < 0.01 * off[0]
    assert max(camera.residual for camera in corrected) < 1e-4


def spread(method, camera, xyz, uv):
    """Covariance of the errors left out (N, 2, 2) px² of one camera."""
    fitted = fit_camera("a", camera.size, xyz, uv, squares(len(xyz)), method=method)
    return errors_without(fitted, xyz, uv, squares(len(xyz)), method=method)[1]


@pytest.mark.parametrize(("xyz", "lens"), [(FRAME, BARREL), (BOX, (0.0,) * 5)])
@pytest.mark.parametrize("method", [ControlPoints(reject=np.inf), Dlt(reject=np.inf)])
def test_errors_left_out_are_those_of_cameras_fitted_without_the_point(xyz, lens, method):
    rng, rig = np.random.default_rng(12), ring(3, distortion=lens)
    uv = project_all(rig, xyz) + rng.normal(0, 0.2, (3, len(xyz), 2))
    fit = control_point_quality(rig.names, [c.size for c in rig], xyz, uv, method=method)
    np.testing.assert_allclose(fit.residual, uv - project_all(fit.rig, xyz))
    for i in (0, len(xyz) // 2, len(xyz) - 1):
        rest = np.arange(len(xyz)) != i
        others = calibrated(rig, xyz[rest], uv[:, rest], method=method)
        error = uv[:, i] - project_all(others, xyz[i])
        scale = np.linalg.norm(error, axis=1, keepdims=True)
        assert (np.abs(fit.left_out_error[:, i] - error) < 0.03 * scale + 1e-3).all()
        exact = Rig(tuple(replace(camera, cov=np.zeros((15, 15))) for camera in others))
        weights = np.stack([spread(method, camera, xyz, x)[i] for camera, x in zip(rig, uv, strict=True)])
        found = refine(exact, xyz[i : i + 1], uv[None, :, i], weights[None]).xyz[0] - xyz[i]
        assert np.linalg.norm(found - fit.left_out_xyz[i]) < 0.03 * np.linalg.norm(found) + 1e-3


def test_points_left_out_are_as_far_off_in_space_as_their_covariance_says():
    """chi² has mean 3 over points that took no part."""
    rng, d2 = np.random.default_rng(13), []
    for k in range(8):
        rig = ring(4, start_deg=7 * k, distortion=BARREL)
        uv = project_all(rig, FRAME) + rng.normal(0, 0.1, (4, 24, 2))
        fit = control_point_quality(rig.names, [c.size for c in rig], FRAME, uv)
        e, C = fit.left_out_xyz, fit.left_out_cov
        d2.append(np.einsum("ni,nij,nj->n", e, np.linalg.inv(C), e).mean())
    assert 2.4 < np.mean(d2) < 3.6


def test_quality_knows_what_took_part_and_what_cannot_be_left_out():
    rng, rig = np.random.default_rng(14), ring(3)
    uv = project_all(rig, BOX) + rng.normal(0, 0.1, (3, 8, 2))
    uv[0, 6:] = np.nan  # six points: none can be spared
    fit = control_point_quality(rig.names, [c.size for c in rig], BOX, uv, points=[f"CB{i}" for i in range(1, 9)])
    assert fit.kept.sum(1).tolist() == [6, 8, 8] and fit.freedom.tolist() == [2, 6, 6]
    assert np.isnan(fit.left_out_error[0]).all() and np.isfinite(fit.left_out_error[1:]).all()
    assert np.isfinite(fit.left_out_xyz).all() and np.isnan(fit.residual[0, 6:]).all()
    assert fit.points[0] == "CB1" and not fit.stated.any()
    with pytest.raises(ValueError, match="points has 2 names, wanted 8"):
        calibrated(rig, BOX, uv, points=["a", "b"])
    fitted = fit_camera("a", rig[0].size, BOX, uv[1], squares(8), method=ControlPoints())
    assert fitted.freedom == 6 and fitted.kept.all() and not fitted.tied


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
