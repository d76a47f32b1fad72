"""Laws of cameras, the DLT, epipolar lines and triangulation."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from kinemark.data import PARAMETERS, KinemarkError, Rig
from kinemark.geometry import (
    camera_from_dlt,
    decompose,
    distort,
    epipolar_constants,
    epipolar_lines,
    fit_dlt,
    from_dlt,
    fundamental,
    line_distance,
    parameter_jacobian,
    point_jacobian,
    polar_rotations,
    project,
    project_all,
    rays,
    refine,
    rigid_align,
    to_camera,
    to_dlt,
    triangulate,
    undistort,
)
from support.laboratory import LENS, camera, observe, ring

RNG = np.random.default_rng(1)
POINTS = RNG.uniform([-700, -1000, 0], [700, 1000, 1800], (300, 3))
SKEWED = replace(ring(1)[0], K=np.array([[1200, 3.0, 640], [0, 1190, 512], [0, 0, 1]]))
FLIPPED = replace(ring(1)[0], K=np.array([[1200, 0, 640], [0, -1190, 512], [0, 0, 1]]))


@pytest.mark.parametrize("lens", [np.zeros(5), LENS, np.array([-0.3, 0.1, 0, 0, 0])])
def test_projection_is_opencvs(lens):
    cam = camera("c", [3000, 2000, 1500], lens=lens)
    rvec = Rotation.from_matrix(cam.R).as_rotvec()
    theirs = cv2.projectPoints(POINTS, rvec, cam.t, cam.K, lens)[0][:, 0]
    assert np.abs(project(cam, POINTS) - theirs).max() < 1e-8


@pytest.mark.parametrize("cam", [camera("c", [3000, 2000, 1500]), SKEWED, FLIPPED])
def test_undistorting_undoes_distorting(cam):
    ideal = RNG.uniform([50, 50], [1200, 950], (200, 2))
    assert np.abs(undistort(cam, distort(cam, ideal)) - ideal).max() < 1e-8


def test_a_lens_that_folds_the_image_gives_nan_not_a_wrong_point():
    cam = camera("c", [3000, 2000, 1500], lens=np.array([-0.6, 0, 0, 0, 0]))
    assert np.isnan(undistort(cam, np.array([[1e5, 512.0]]))).all()
    assert np.isfinite(undistort(cam, np.array([[640.0, 512.0]]))).all()


@pytest.mark.parametrize("cam", [camera("c", [3000, 2000, 1500]), SKEWED, FLIPPED])
def test_rays_pass_through_what_is_seen(cam):
    along = rays(cam, project(cam, POINTS))
    apart = np.linalg.norm(np.cross(POINTS - cam.centre, along), axis=1)
    assert apart.max() < 1e-6
    assert (((POINTS - cam.centre) * along).sum(1) > 0).all()


def test_behind_the_camera_is_nan():
    cam = camera("c", [3000, 0, 900])
    assert np.isnan(project(cam, np.array([6000.0, 0, 900]))).all()


@pytest.mark.parametrize("cam", [camera("c", [3000, 2000, 1500]), SKEWED, FLIPPED])
def test_derivative_by_the_point_is_the_difference(cam):
    h = 1e-3
    J = point_jacobian(cam, POINTS)
    for k, step in enumerate(np.eye(3) * h):
        difference = (project(cam, POINTS + step) - project(cam, POINTS - step)) / (2 * h)
        assert np.abs(J[..., k] - difference).max() < 1e-6 * np.abs(J).max()


def moved(cam, name, h):
    """The camera with one parameter of `PARAMETERS` changed by h."""
    K, lens, t, R = cam.K.copy(), cam.distortion.copy(), cam.t.copy(), cam.R
    places = {"fx": (0, 0), "fy": (1, 1), "cx": (0, 2), "cy": (1, 2)}
    if name in places:
        K[places[name]] += h
    elif name in ("k1", "k2", "p1", "p2", "k3"):
        lens[["k1", "k2", "p1", "p2", "k3"].index(name)] += h
    elif name[0] == "r":
        R = Rotation.from_rotvec(h * np.eye(3)["xyz".index(name[1])]).as_matrix() @ R
    else:
        t["xyz".index(name[1])] += h
    return replace(cam, K=K, distortion=lens, R=R, t=t)


@pytest.mark.parametrize("name", PARAMETERS)
def test_derivative_by_each_parameter_is_the_difference(name):
    cam, h = camera("c", [3000, 2000, 1500]), 1e-5
    J = parameter_jacobian(cam, POINTS)[..., PARAMETERS.index(name)]
    difference = (project(moved(cam, name, h), POINTS) - project(moved(cam, name, -h), POINTS)) / (2 * h)
    assert np.abs(J - difference).max() < 1e-6 * np.abs(J).max()


@pytest.mark.parametrize("cam", [replace(c, distortion=np.zeros(5)) for c in (*ring(4), SKEWED, FLIPPED)])
def test_dlt_and_camera_convert_exactly_both_ways(cam):
    L = to_dlt(cam.P)
    front = POINTS.mean(0)
    K, R, t = decompose(from_dlt(L), front=front)
    assert np.abs(K - cam.K).max() < 1e-7
    assert np.abs(R - cam.R).max() < 1e-10
    assert np.abs(t - cam.t).max() < 1e-6
    back = camera_from_dlt("c", L, front=front)
    assert np.abs(project(back, POINTS) - project(cam, POINTS)).max() < 1e-8
    assert np.abs(to_dlt(back.P) - L).max() < 1e-9 * np.abs(L).max()


def test_a_dlt_predicts_pixels_by_its_equations():
    cam = camera("c", [3000, 2000, 1500], lens=np.zeros(5))
    L = to_dlt(cam.P)
    X, Y, Z = POINTS.T
    below = L[8] * X + L[9] * Y + L[10] * Z + 1
    u = (L[0] * X + L[1] * Y + L[2] * Z + L[3]) / below
    v = (L[4] * X + L[5] * Y + L[6] * Z + L[7]) / below
    assert np.abs(project(cam, POINTS) - np.column_stack([u, v])).max() < 1e-8


def test_a_fitted_dlt_is_the_cameras():
    cam = camera("c", [3000, 2000, 1500], lens=np.zeros(5))
    assert np.allclose(fit_dlt(POINTS[:6], project(cam, POINTS[:6])), to_dlt(cam.P), rtol=1e-6)
    far = POINTS[:8] + 1e6  # coordinates of a national grid: the fit must not lose its digits
    pixels = project(cam, POINTS[:8])
    P = from_dlt(fit_dlt(far, pixels))
    x = np.column_stack([far, np.ones(8)]) @ P.T
    assert np.abs(x[:, :2] / x[:, 2:] - pixels).max() < 1e-4


@pytest.mark.parametrize(
    ("points", "said"),
    [
        (POINTS[:5], "needs six"),
        (POINTS[:20] * [1, 1, 0], "in a plane"),
        (np.repeat(POINTS[:3], 4, 0), "in a plane"),
    ],
)
def test_control_points_that_determine_no_camera_are_refused(points, said):
    with pytest.raises(KinemarkError, match=said):
        fit_dlt(points, project(camera("c", [3000, 2000, 1500]), points))


def test_a_camera_whose_focal_plane_holds_the_origin_has_no_dlt():
    cam = camera("c", [3000, 0, 0], target=(3000, 100, 0))
    with pytest.raises(KinemarkError, match="Move the origin"):
        to_dlt(cam.P)


@pytest.mark.parametrize(("r", "s"), [(0, 1), (3, 1), (2, 5)])
def test_epipolar_lines_from_dlt_and_from_fundamental_matrices_agree(r, s):
    rig = ring(6, lens=np.zeros(5))
    uv = project_all(rig, POINTS)
    F = fundamental(rig.P[r], rig.P[s])
    m = epipolar_constants(*to_dlt(rig.P[[r, s]])).reshape(3, 3)
    lines, by_dlt = epipolar_lines(F, uv[r]), epipolar_lines(m, uv[r])
    assert np.abs(np.abs(lines) - np.abs(by_dlt)).max() < 1e-6
    assert np.abs(line_distance(lines, uv[s])).max() < 1e-6
    assert np.abs(line_distance(by_dlt, uv[s])).max() < 1e-6
    u1, v1, u2, v2 = *uv[r, 0], *uv[s, 0]  # KISS eq. 8 as it is printed
    m1, m2, m3, m4, m5, m6, m7, m8, m9 = m.ravel()
    left = (u1 * m1 + v1 * m2 + m3) * u2 + (u1 * m4 + v1 * m5 + m6) * v2 + u1 * m7 + v1 * m8 + m9
    assert abs(left) < 1e-9 * max(abs(m9), abs(u1 * m7))


def test_triangulation_returns_the_point_for_every_pattern_of_views():
    rig = ring(5, lens=np.zeros(5))
    uv = project_all(rig, POINTS).transpose(1, 0, 2)
    hidden = RNG.random(uv.shape[:2]) < 0.5
    uv[hidden] = np.nan
    xyz = triangulate(uv, rig.P)
    enough = (~hidden).sum(1) >= 2
    assert np.abs(xyz[enough] - POINTS[enough]).max() < 1e-6
    assert np.isnan(xyz[~enough]).all()


def test_triangulation_is_the_least_squares_solution_of_kiss_equation_10():
    rig = ring(4, lens=np.zeros(5))
    uv = project_all(rig, POINTS[:1]).transpose(1, 0, 2) + RNG.normal(size=(1, 4, 2))
    L = to_dlt(rig.P)
    rows = np.concatenate([L[:, 4 * k : 4 * k + 3] - uv[0, :, k, None] * L[:, 8:] for k in (0, 1)])
    right = np.concatenate([uv[0, :, k] - L[:, 4 * k + 3] for k in (0, 1)])
    assert np.abs(triangulate(uv, from_dlt(L))[0] - np.linalg.lstsq(rows, right)[0]).max() < 1e-6


def test_two_cameras_in_one_place_give_nan():
    rig = ring(1, lens=np.zeros(5))
    uv = project(rig[0], POINTS)[:, None].repeat(2, 1)
    assert np.isnan(triangulate(uv, rig.P.repeat(2, 0))).all()


def seen_with_noise(rig, points, sd, seed=0):
    uv = project_all(rig, points).transpose(1, 0, 2)
    return uv + sd * np.random.default_rng(seed).normal(size=uv.shape)


def test_refined_points_are_better_and_their_covariance_is_true():
    rig, points = ring(5), np.tile(POINTS, (10, 1))
    sd = np.array([0.05, 0.1, 0.2, 0.4, 0.8])
    uv = seen_with_noise(rig, points, sd[:, None])
    cov = np.broadcast_to(np.eye(2) * sd[:, None, None] ** 2, (len(points), 5, 2, 2))
    guess = triangulate(np.stack([undistort(c, uv[:, i]) for i, c in enumerate(rig)], 1), rig.P)
    refined = refine(rig, guess, uv, cov)
    off = refined.xyz - points
    assert (off**2).sum() < 0.6 * ((guess - points) ** 2).sum()
    squared = (off * np.linalg.solve(refined.cov, off[..., None])[..., 0]).sum(1)
    assert abs(squared.mean() - 3) < 0.15
    assert abs((squared < chi2.ppf(0.95, 3)).mean() - 0.95) < 0.015


def test_an_uncertain_calibration_widens_the_covariance_as_it_should():
    """Points in rigs whose cameras are moved by their own covariance stay within their ellipsoids."""
    rng = np.random.default_rng(5)
    sd = np.array([0.5, 0.5, 0.4, 0.4, 1e-3, 0, 0, 0, 0, 1e-4, 1e-4, 1e-4, 0.3, 0.3, 0.3])
    true, squared = ring(4), []
    for _ in range(60):
        believed = []
        for cam in true:
            shifted = cam
            for name, h in zip(PARAMETERS, sd * rng.normal(size=15), strict=True):
                shifted = moved(shifted, name, h)
            believed.append(replace(shifted, cov=np.diag(sd**2)))
        rig = replace(true, cameras=tuple(believed))
        uv = seen_with_noise(true, POINTS[:20], 0.05, seed=int(rng.integers(1 << 30)))
        guess = triangulate(np.stack([undistort(c, uv[:, i]) for i, c in enumerate(rig)], 1), rig.P)
        point = refine(rig, guess, uv, np.broadcast_to(np.eye(2) * 0.05**2, (20, 4, 2, 2)))
        off = point.xyz - POINTS[:20]
        squared.append((off * np.linalg.solve(point.cov, off[..., None])[..., 0]).sum(1))
    assert abs(np.mean(squared) - 3) < 0.5


def test_refining_does_not_depend_on_the_world():
    """Turning and moving cameras and points together turns and moves the answer."""
    rig = ring(4)
    R, shift = Rotation.from_euler("xyz", [10, 20, 30], degrees=True).as_matrix(), np.array([100.0, -200, 300])
    turned = replace(rig, cameras=tuple(replace(c, R=c.R @ R.T, t=c.t - c.R @ R.T @ shift) for c in rig))
    uv = seen_with_noise(rig, POINTS[:50], 0.3)
    cov = np.broadcast_to(np.eye(2), (50, 4, 2, 2))
    here = refine(rig, POINTS[:50], uv, cov, steps=6)
    there = refine(turned, POINTS[:50] @ R.T + shift, uv, cov, steps=6)
    assert np.abs(here.xyz @ R.T + shift - there.xyz).max() < 1e-6
    assert np.abs(R @ here.cov @ R.T - there.cov).max() < 1e-6


def test_rigid_alignment_finds_the_motion_and_never_a_reflection():
    R, t = Rotation.from_rotvec([0.3, -1.0, 2.0]).as_matrix(), np.array([1.0, 2, 3])
    found, shift = rigid_align(POINTS, POINTS @ R.T + t)
    assert np.abs(found - R).max() < 1e-12
    assert np.abs(shift - t).max() < 1e-9
    assert np.linalg.det(rigid_align(POINTS, POINTS * [1, 1, -1])[0]) > 0
    with pytest.raises(ValueError, match="at least 3"):
        rigid_align(POINTS[:2], POINTS[:2])


def test_polar_rotations_are_the_nearest_and_never_reflections():
    """Against the decomposition by singular values; a third of the matrices turn points over, one is all but flat."""
    rng = np.random.default_rng(2)
    H = rng.normal(size=(300, 3, 3))
    H[:100] += 3 * np.eye(3)
    H[0] = np.diag([1.0, 1e-3, 1e-8])
    given = H.copy()
    U, s, Vt = np.linalg.svd(H)
    U[..., 2] *= np.sign(np.linalg.det(U @ Vt))[:, None]
    found = polar_rotations(H)
    clear = s[:, 1] - s[:, 2] > 0.05  # where two are alike and det H < 0, others are as near
    clear[0] = True
    assert clear.sum() > 200 and (np.linalg.det(H) < 0).sum() > 50
    assert np.abs(found - U @ Vt)[clear].max() < 1e-9
    assert np.abs(found @ found.mT - np.eye(3)).max() < 1e-9 and (np.linalg.det(found) > 0).all()
    assert (given == H).all()  # the argument stays as it was
    assert polar_rotations(np.zeros((0, 3, 3))).shape == (0, 3, 3)


def test_depth_is_along_the_optical_axis():
    cam = camera("c", [3000, 0, 900])
    assert np.allclose(to_camera(cam, np.array([0.0, 0, 900])), [0, 0, 3000])


def test_observed_points_are_where_the_camera_sees_them():
    rig = ring(3)
    detections, truth = observe(rig, POINTS[:5, None])
    own = slice(detections.start[1, 0], detections.start[1, -1])
    assert np.abs(detections.uv[own] - project(rig[1], POINTS[truth[own]])).max() < 1e-9


def dense_refine(rig, xyz, uv, cov, *, steps):
    """`refine` by its equations, a point at a time."""
    points, covs, offs = [], [], []
    for x, images, spread in zip(xyz, uv, cov, strict=True):
        seen = np.flatnonzero(~np.isnan(images[:, 0]))
        J_cal = [parameter_jacobian(rig[c], x) for c in seen]
        W = [np.linalg.inv(spread[c] + j @ rig[c].cov @ j.T) for c, j in zip(seen, J_cal, strict=True)]
        for k in range(steps + 1):
            J = [point_jacobian(rig[c], x) for c in seen]
            off = [images[c] - project(rig[c], x) for c in seen]
            normal = sum(j.T @ w @ j for j, w in zip(J, W, strict=True))
            if k < steps:
                x = x + np.linalg.solve(normal, sum(j.T @ w @ o for j, w, o in zip(J, W, off, strict=True)))
        points.append(x)
        covs.append(np.linalg.inv(normal))
        offs.append(np.full(images.shape, np.nan))
        offs[-1][seen] = off
    return np.array(points), np.array(covs), np.array(offs)


@pytest.mark.parametrize("calibrated", [False, True])
@pytest.mark.parametrize("steps", [1, 3])
def test_refining_many_points_is_refining_each(calibrated, steps):
    """In cameras that are skewed, flipped and uncertain, by images of any covariance, a third of them unseen."""
    rng = np.random.default_rng(steps)
    sd = np.array([0.5, 0.5, 0.4, 0.4, 1e-3, 1e-3, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 0.3, 0.3, 0.3])
    rig = Rig((*ring(3), replace(SKEWED, name="skewed"), replace(FLIPPED, name="flipped")))
    if calibrated:
        mixed = np.diag(sd) @ (np.eye(15) + 0.3 * rng.normal(size=(15, 15)))
        rig = replace(rig, cameras=tuple(replace(c, cov=mixed @ mixed.T) for c in rig))
    uv = seen_with_noise(rig, POINTS[:60], 0.3)
    uv[rng.random((60, 5)) < 0.3] = np.nan
    uv[:, :2] = seen_with_noise(rig, POINTS[:60], 0.3)[:, :2]  # by two at least
    root = rng.normal(size=(60, 5, 2, 2))
    cov = 0.05 * np.eye(2) + 0.02 * root @ root.swapaxes(-1, -2)
    guess = POINTS[:60] + rng.normal(size=(60, 3))
    here, there = refine(rig, guess, uv, cov, steps=steps), dense_refine(rig, guess, uv, cov, steps=steps)
    assert np.abs(here.xyz - there[0]).max() < 1e-8
    assert (np.abs(here.cov - there[1]).max((1, 2)) < 1e-9 * np.abs(there[1]).max((1, 2))).all()
    assert np.abs(here.residual - there[2])[~np.isnan(uv)].max() < 1e-9
    assert (np.isnan(here.residual) == np.isnan(uv)).all()


def test_what_refine_says_of_a_small_step_is_what_it_says_exactly():
    """Within some mm of the answer, projections are as good as linear."""
    rig = ring(5)
    rng = np.random.default_rng(3)
    xyz = rng.uniform([-500, -500, 500], [500, 500, 1500], (200, 3))
    uv = np.stack([project(camera, xyz) for camera in rig], 1) + rng.normal(0, 0.2, (200, 5, 2))
    cov = np.broadcast_to(np.eye(2) * 0.04, (200, 5, 2, 2))
    near = refine(rig, xyz, uv, cov).xyz + rng.normal(0, 1.0, (200, 3))
    quick, exact = (refine(rig, near, uv, cov, steps=1, exact=how) for how in (False, True))
    assert np.array_equal(quick.xyz, exact.xyz)
    assert np.abs(quick.residual - exact.residual).max() < 2e-3
    assert np.abs(quick.cov - exact.cov).max() < 0.01 * np.abs(exact.cov).max()


def test_polar_rotations_of_great_and_small_matrices():
    H = np.random.default_rng(3).normal(size=(50, 3, 3)) + 3 * np.eye(3)
    for scale in (1e-9, 1e9):
        assert np.abs(polar_rotations(scale * H) - polar_rotations(H)).max() < 1e-9
