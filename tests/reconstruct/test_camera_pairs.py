"""Positions from pairs of cameras that agree: what the rule leaves out, where it fails, and how sure the mean is."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scipy.stats import chi2

from kinemark.data import Detections, Matches, Rig
from kinemark.geometry import project_all, triangulate, undistort
from kinemark.reconstruct import RECONSTRUCT, CameraPairs, LeastSquares, reconstruct
from kinemark.reconstruct.camera_pairs import agreeing, solutions
from kinemark.synth import look_at, ring

LENS = (-0.15, 0.05, 0.001, -0.001, 0.0)
ALL = CameraPairs(outlier_ratio=1e12)
CENTRE = (1200.0, 700.0, 850.0)


def seen(rig, xyz, *, noise=0.1, shift=(0.0, 0.0), seed=0, cov=True):
    """Matches and detections of points (N, 3), one a frame, in all cameras; those of the first moved by `shift`."""
    n = len(xyz)
    uv = project_all(rig, xyz) + np.random.default_rng(seed).normal(0, noise, (len(rig), n, 2))
    uv[0] += shift
    known = np.tile(np.eye(2) * noise**2, (uv.size // 2, 1, 1)) if cov else None
    detections = Detections.build(rig.names, 100.0, np.ones((len(rig), n), int), uv.reshape(-1, 2), known)
    return Matches(np.arange(n), np.arange(n)[:, None] + n * np.arange(len(rig)), np.zeros(n), n), detections


def volume(n, reach=(900.0, 400.0, 600.0), seed=1):
    return CENTRE + np.random.default_rng(seed).uniform(-1, 1, (n, 3)) * reach


def kept(rig, matches, detections):
    """{pair of cameras: share of the points in whose mean it is}."""
    each = solutions(rig, detections.uv[matches.detection])
    share = agreeing(each, np.full(len(each), len(rig))).mean(0)
    return dict(zip(combinations(range(len(rig)), 2), share, strict=True))


def error(cloud, xyz):
    return np.linalg.norm(cloud.xyz - xyz[cloud.frame], axis=1)


def in_their_units(cloud, xyz):
    """Squared distances from the truth in units of the covariance; χ² with three degrees of freedom."""
    off = cloud.xyz - xyz[cloud.frame]
    return np.einsum("ni,nij,nj->n", off, np.linalg.inv(cloud.cov), off)


# ---- The rule ----


def test_of_three_solutions_the_rule_is_that_of_the_paper():
    each = np.random.default_rng(0).normal(size=(3000, 3, 3))
    left_out = ~agreeing(each, np.full(3000, 3))
    for p, (q, r) in {0: (1, 2), 1: (0, 2), 2: (0, 1)}.items():
        d1, d2, d3 = (np.linalg.norm(each[:, a] - each[:, b], axis=1) for a, b in ((p, q), (p, r), (q, r)))
        assert (left_out[:, p] == ((d1 > 2 * d3) & (d2 > 2 * d3))).all()
    assert 0.1 < left_out.any(1).mean() < 0.9 and left_out.sum(1).max() == 1


def test_the_rule_looks_at_shape_only():
    rng = np.random.default_rng(0)
    each, views = rng.normal(size=(200, 10, 3)), np.full(200, 5)
    order = rng.permutation(10)
    expected = agreeing(each, views)
    assert (agreeing(1000 * each[:, order] + 50, views) == expected[:, order]).all()
    assert expected.any(1).all() and not expected.all()
    assert agreeing(each, views, outlier_ratio=1e9).all()


def test_in_the_papers_studio_a_shifted_camera_is_never_left_out():
    """Cameras on the axes: with camera 1 moved by δ along an image axis the solutions lie at 0, δ/2 and δ."""
    at = np.eye(3) * 2400 + 1e-9
    rig = Rig(tuple(look_at(name, place, (0, 0, 0)) for name, place in zip("xyz", at, strict=True)))
    xyz = np.random.default_rng(0).uniform(-200, 200, (300, 3))
    for shift in ((10.0, 0.0), (0.0, 10.0), (10.0, 10.0), (-10.0, 10.0)):
        matches, detections = seen(rig, xyz, noise=0.0, shift=shift)
        assert min(kept(rig, matches, detections).values()) == 1
        moved = np.hypot(*shift) * 2400 / 1300
        off = error(reconstruct(matches, detections, rig, method=CameraPairs()), xyz)
        assert np.median(off) == pytest.approx(moved / 2, rel=0.03)


def test_of_three_level_cameras_the_right_pair_is_left_out_where_the_wrong_ones_are_moved_alike():
    rig, xyz = ring(3, sweep_deg=120, height=(850.0,)), volume(300, (100.0, 100.0, 50.0))
    matches, detections = seen(rig, xyz, shift=(0.0, 10.0))
    share = kept(rig, matches, detections)
    assert share[1, 2] < 0.05 and share[0, 1] == share[0, 2] == 1
    with_rule, without = (reconstruct(matches, detections, rig, method=m) for m in (CameraPairs(), ALL))
    assert np.median(error(with_rule, xyz)) > 1.3 * np.median(error(without, xyz))


@pytest.mark.parametrize("shift", [(10.0, 0.0), (0.0, 10.0), (-7.0, 7.0)])
@pytest.mark.parametrize("n", [4, 5, 6, 8])
def test_with_four_and_more_cameras_a_shifted_one_is_left_out(n, shift):
    rig, xyz = ring(n, distortion=LENS), volume(400)
    matches, detections = seen(rig, xyz, shift=shift)
    share = kept(rig, matches, detections)
    assert max(share[pair] for pair in share if 0 in pair) < 0.02
    cloud = reconstruct(matches, detections, rig, method=CameraPairs())
    clean = reconstruct(*seen(rig, xyz), rig, method=CameraPairs())
    assert np.median(error(cloud, xyz)) < 1.5 * np.median(error(clean, xyz))
    assert abs((in_their_units(cloud, xyz) < chi2.ppf(0.95, 3)).mean() - 0.95) < 0.04
    assert np.median(cloud.residual) > 10 / n  # what was left out is still in the residual
    squares = reconstruct(matches, detections, rig, method=LeastSquares(degrees_of_freedom=0))
    assert np.median(error(squares, xyz)) > 8 * np.median(error(cloud, xyz))


def test_three_solutions_of_six_moved_alike_are_as_good_as_the_other_three():
    rig, xyz = ring(4, height=(850.0,)), volume(100, (50.0, 50.0, 10.0))
    share = kept(rig, *seen(rig, xyz, shift=(0.0, 10.0)))
    assert share[0, 1] > 0.5 and share[0, 3] > 0.5


@pytest.mark.parametrize("n", [5, 6])
def test_solutions_moved_alike_are_left_out_where_the_others_are_more(n):
    """The n − 1 wrong ones are nearer to each other than any two right ones; only their number gives them away."""
    rig, xyz = ring(n, height=(850.0,), sweep_deg=200), volume(300, (100.0, 50.0, 10.0))
    share = kept(rig, *seen(rig, xyz, noise=0.3, shift=(0.0, 10.0)))
    assert max(share[pair] for pair in share if 0 in pair) < 0.02
    assert np.mean([share[pair] for pair in share if 0 not in pair]) > 0.6


def test_a_pair_that_looks_along_one_line_is_left_out():
    rig, xyz = ring(4, height=(850.0,)), volume(500, (900.0, 400.0, 20.0))
    opposite = rig.select(["cam1", "cam2", "cam3"])  # 1 and 3 look at each other
    matches, detections = seen(opposite, xyz)
    share = kept(opposite, matches, detections)
    assert share[0, 2] < 0.2 and min(share[0, 1], share[1, 2]) > 0.95
    with_rule, without = (reconstruct(matches, detections, opposite, method=m) for m in (CameraPairs(), ALL))
    assert np.sqrt((error(with_rule, xyz) ** 2).mean()) < np.sqrt((error(without, xyz) ** 2).mean()) / 1.5


# ---- Positions ----


def test_two_cameras_give_the_linear_solution_which_is_nearly_least_squares():
    rig, xyz = ring(2, sweep_deg=80, distortion=LENS), volume(500)
    matches, detections = seen(rig, xyz, noise=0.3)
    pairs, squares = (reconstruct(matches, detections, rig, method=m) for m in (CameraPairs(), LeastSquares()))
    ideal = np.stack([undistort(camera, detections.uv[matches.detection[:, c]]) for c, camera in enumerate(rig)], 1)
    np.testing.assert_allclose(pairs.xyz, triangulate(ideal, rig.P), atol=1e-6)
    apart = np.linalg.norm(pairs.xyz - squares.xyz, axis=1)
    assert np.median(apart) < 0.05 * np.median(error(squares, xyz))
    np.testing.assert_allclose(pairs.residual, squares.residual, rtol=0.05, atol=0.01)


def test_without_noise_every_point_is_exact():
    rig, xyz = ring(6, distortion=LENS), volume(100)
    cloud = reconstruct(*seen(rig, xyz, noise=1e-9), rig, method=CameraPairs())
    assert len(cloud) == 100 and error(cloud, xyz).max() < 1e-5 and cloud.residual.max() < 1e-6


def test_the_order_of_cameras_plays_no_part():
    rig, xyz = ring(5, distortion=LENS), volume(200)
    matches, detections = seen(rig, xyz, noise=0.5)
    order = [3, 0, 4, 1, 2]
    turned = Rig(tuple(rig[c] for c in order))
    a = reconstruct(matches, detections, rig, method=CameraPairs())
    b = reconstruct(replace(matches, detection=matches.detection[:, order]), detections, turned, method=CameraPairs())
    for name in ("xyz", "cov", "residual"):
        np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=1e-6, atol=1e-6)


def test_missing_images_leave_the_pairs_that_see_the_point():
    rig, xyz = ring(5), volume(60)
    matches, detections = seen(rig, xyz)
    detection = matches.detection.copy()
    detection[:20, 0] = -1  # four cameras
    detection[20:40, :3] = -1  # two
    detection[40:, :4] = -1  # one: no position (UM²AS eq. 2.6)
    cloud = reconstruct(replace(matches, detection=detection), detections, rig, method=CameraPairs())
    assert (cloud.frame == np.arange(40)).all()
    four, two = rig.select(rig.names[1:]), rig.select(rig.names[3:])
    fewer = reconstruct(replace(matches, detection=detection[:, 1:]), detections, four, method=CameraPairs())
    np.testing.assert_allclose(cloud.xyz[:20], fewer.xyz[:20], atol=1e-9)
    pair = reconstruct(replace(matches, detection=detection[:, 3:]), detections, two, method=CameraPairs())
    np.testing.assert_allclose(cloud.xyz[20:], pair.xyz[20:40], atol=1e-9)
    np.testing.assert_allclose(cloud.cov[20:], pair.cov[20:40], rtol=1e-9)


def test_points_outside_the_volume_are_dropped_only_if_asked():
    rig = ring(4)
    far = rig.volume[1] + [[500.0, 0.0, 0.0], [-500.0, -300.0, -900.0]]
    matches, detections = seen(rig, far)
    assert list(reconstruct(matches, detections, rig, method=CameraPairs()).frame) == [1]
    assert len(reconstruct(matches, detections, rig, method=CameraPairs(within_volume=False))) == 2


# ---- Covariance ----


@pytest.mark.parametrize(("n", "sweep"), [(2, 70.0), (3, 120.0), (3, 240.0), (4, 360.0), (5, 360.0), (8, 360.0)])
def test_the_covariance_is_true(n, sweep):
    rig, xyz = ring(n, sweep_deg=sweep, distortion=LENS), volume(2500)
    cloud = reconstruct(*seen(rig, xyz, noise=0.3), rig, method=CameraPairs())
    squared = in_their_units(cloud, xyz)
    assert len(cloud) == 2500
    assert 0.9 < squared.mean() / 3 < 1.1
    assert abs((squared < chi2.ppf(0.95, 3)).mean() - 0.95) < 0.02


def test_the_covariance_is_that_of_differences():
    """Each image moved a little in turn, the solutions kept fixed: what the mean does is H of (7)."""
    rig, xyz = ring(4, distortion=LENS), volume(1000)
    matches, detections = seen(rig, xyz, noise=0.02)
    cloud = reconstruct(matches, detections, rig, method=CameraPairs(model_sd=0.0))
    uv = detections.uv[matches.detection]
    use = agreeing(solutions(rig, uv), np.full(1000, 4))[..., None]
    expected, step = np.zeros((1000, 3, 3)), 1e-3
    for c, axis in np.ndindex(4, 2):
        moved = []
        for sign in (1, -1):
            other = uv.copy()
            other[:, c, axis] += sign * step
            moved.append(np.where(use, solutions(rig, other), 0).sum(1) / use.sum(1))
        slope = (moved[0] - moved[1]) / (2 * step)
        expected += 0.02**2 * slope[:, :, None] * slope[:, None]
    widened = np.trace(cloud.cov, axis1=1, axis2=2) / np.trace(expected, axis1=1, axis2=2)
    assert np.median(widened) == pytest.approx(1, abs=0.01) and widened.min() > 0.98
    usual = widened < 1.02
    assert 0.03 < 1 - usual.mean() < 0.09  # (8): one in twenty, and a little more as it is not least squares
    scale = np.abs(expected[usual]).max((1, 2))[:, None, None]
    np.testing.assert_allclose(cloud.cov[usual] / scale, expected[usual] / scale, atol=0.02)


def test_an_uncertain_calibration_widens_the_covariance():
    rig, xyz = ring(4), volume(50)
    loose = np.zeros((15, 15))
    loose[12:, 12:] = np.eye(3)  # 1 mm of translation
    unsure = Rig(tuple(replace(camera, cov=loose) for camera in rig))
    matches, detections = seen(rig, xyz)
    sure, wide = (reconstruct(matches, detections, r, method=CameraPairs()) for r in (rig, unsure))
    np.testing.assert_array_equal(sure.xyz, wide.xyz)
    assert (np.trace(wide.cov, axis1=1, axis2=2) > 4 * np.trace(sure.cov, axis1=1, axis2=2)).all()


def test_images_that_disagree_widen_the_covariance():
    rig, xyz = ring(3, sweep_deg=120), volume(300)
    clean, shifted = (reconstruct(*seen(rig, xyz, shift=s), rig, method=ALL) for s in ((0, 0), (0, 10)))
    assert (in_their_units(shifted, xyz) < chi2.ppf(0.95, 3)).mean() > 0.9
    assert np.median(np.trace(shifted.cov, axis1=1, axis2=2)) > 100 * np.median(np.trace(clean.cov, axis1=1, axis2=2))


def test_images_without_a_covariance_are_given_one_from_the_data():
    rig, xyz = ring(5), volume(1500)
    cloud = reconstruct(*seen(rig, xyz, noise=0.25, cov=False), rig, method=CameraPairs())
    assert 0.85 < in_their_units(cloud, xyz).mean() / 3 < 1.15


# ---- The method ----


def test_the_table_has_both_methods():
    kinds = [declared.kind for declared in RECONSTRUCT.values()]
    assert set(kinds) == {LeastSquares, CameraPairs}
    empty, rig = Matches(np.zeros(0, int), np.zeros((0, 3), int), np.zeros(0), 4), ring(3)
    nothing = Detections.build(rig.names, 50.0, np.zeros((3, 4), int), np.zeros((0, 2)))
    for method in kinds:
        cloud = reconstruct(empty, nothing, rig, method=method())
        assert len(cloud) == 0 and cloud.n_frames == 4 and cloud.rate == 50


@pytest.mark.parametrize(
    "wrong",
    [
        {"outlier_ratio": 0.5},
        {"outlier_ratio": np.nan},
        {"centroid_sd": 0.0},
        {"model_sd": -1.0},
        {"volume_margin": np.inf},
    ],
)
def test_wrong_parameters_are_named(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        CameraPairs(**wrong)
