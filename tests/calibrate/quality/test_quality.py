"""How good a calibration is: predicted precision against many simulated calibrations, and what the verdict says."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.calibrate import calibrate_control_points
from kinemark.calibrate.bundle import Bundle, calibrate_sticks
from kinemark.calibrate.quality import apart_from_frame, joint_of, predicted_covariance, visible
from kinemark.calibrate.quality.calibration_evidence import Evidence, centroid_deviation
from kinemark.calibrate.quality.change import compare
from kinemark.calibrate.quality.halves import halves_ratio
from kinemark.calibrate.quality.image_coverage import image_coverage
from kinemark.calibrate.quality.volume import deviation, map_volume, points_of, ray_angle, view_volume, volume_grid
from kinemark.calibrate.quality.wand import folds_of, image_errors, judge_poses, reconstructed, seen_by
from kinemark.calibrate.world_frame import fit_moved_to, moved_to
from kinemark.data import KinemarkError, Rig
from kinemark.geometry import project_all, refine, triangulate, undistort
from kinemark.synth import ring as laboratory
from kinemark.synth import wand
from support.calibrations import POINTS, RIG, of_control_points, seen
from support.laboratory import camera, ring

SIZES = [c.size for c in RIG]
PLACES = np.random.default_rng(5).uniform(RIG.volume[0], RIG.volume[1], (40, 3))


def placed(rig, uv, noise):
    """(N, 3) mm from (C, N, 2) px, as `reconstruct` does it."""
    uv = uv.transpose(1, 0, 2)
    ideal = np.stack([undistort(c, uv[:, i]) for i, c in enumerate(rig)], 1)
    return refine(rig, triangulate(ideal, rig.P), uv, np.broadcast_to(noise**2 * np.eye(2), (*uv.shape, 2))).xyz


def variance(cov):
    return np.trace(cov, axis1=-2, axis2=-1) / 3


@pytest.fixture(scope="module")
def control():
    """Many calibrations with control points: what each predicted with all cameras and without two of them, and what
    came of it, mm² a place."""
    noise, predicted, found = 0.3, {w: [] for w in LOST}, {w: [] for w in LOST}
    for seed in range(40):
        rng = np.random.default_rng(seed)
        rig = calibrate_control_points(RIG.names, SIZES, POINTS, seen(RIG, POINTS, noise, rng))
        uv = seen(RIG, PLACES, noise, rng)
        for without in LOST:
            cov = predicted_covariance(rig, PLACES, centroid_sd=noise, without=without)
            predicted[without].append(variance(cov))
            left = uv.copy()
            left[list(without)] = np.nan
            found[without].append(((placed(rig, left, noise) - PLACES) ** 2).mean(1))
    return {w: (np.sqrt(np.mean(predicted[w], 0)), np.sqrt(np.mean(found[w], 0))) for w in LOST}


LOST = ((), (0,), (3,))


@pytest.mark.parametrize("without", LOST)
def test_the_precision_predicted_after_control_points_is_the_one_observed(control, without):
    """Within 15 %, wherever the place and whichever camera is lost."""
    predicted, found = control[without]
    ratio = predicted / found
    assert 0.9 < ratio.mean() < 1.1
    assert ratio.std() < 0.15
    if without:
        assert predicted.mean() > 1.1 * control[()][0].mean()


ALONG = np.array([0.0, 500.0])
POSES = wand(ALONG, duration_s=32.0, rate=2.5).xyz.transpose(1, 0, 2)


def waved(noise, seed):
    uv = seen(RIG, POSES.reshape(-1, 3), noise, np.random.default_rng(seed))
    return uv.reshape(len(RIG), *POSES.shape[:2], 2)


@pytest.fixture(scope="module")
def wands():
    """Calibrations with a wand, each laid on the truth by its own wand."""
    fits = []
    for seed in range(6):
        fit = calibrate_sticks(RIG.names, SIZES, waved(0.1, seed), along=ALONG)
        good = np.isfinite(fit.xyz).all(1)
        fits.append(fit_moved_to(fit, fit.xyz[good], POSES.reshape(-1, 3)[good]))
    return fits


def test_the_precision_predicted_after_a_wand_is_the_one_observed(wands):
    noise, predicted, found = 0.1, [], []
    for k, fit in enumerate(wands):
        predicted.append(variance(predicted_covariance(fit.rig, PLACES, centroid_sd=noise, joint=fit.joint)))
        for again in range(4):
            rng = np.random.default_rng(1000 + 10 * k + again)
            found.append(((placed(fit.rig, seen(RIG, PLACES, noise, rng), noise) - PLACES) ** 2).mean(1))
    ratio = np.sqrt(np.mean(predicted)) / np.sqrt(np.mean(found))
    assert 0.85 < ratio < 1.15


def test_losing_a_camera_is_predicted_too():
    noise, found = 0.3, []
    rest = Rig(RIG.cameras[1:])
    for seed in range(60):
        uv = seen(rest, PLACES, noise, np.random.default_rng(seed))
        found.append(((placed(rest, uv, noise) - PLACES) ** 2).mean(1))
    predicted = variance(predicted_covariance(RIG, PLACES, centroid_sd=noise, without=(0,)))
    assert np.sqrt(predicted).mean() == pytest.approx(np.sqrt(np.mean(found, 0)).mean(), rel=0.05)
    assert (predicted > variance(predicted_covariance(RIG, PLACES, centroid_sd=noise))).all()


def test_without_a_joint_covariance_it_is_that_of_refine():
    rng = np.random.default_rng(0)
    rig = calibrate_control_points(RIG.names, SIZES, POINTS, seen(RIG, POINTS, 0.3, rng))
    uv = project_all(rig, PLACES).transpose(1, 0, 2)
    uv[~visible(rig, PLACES).T] = np.nan
    by_refine = refine(rig, PLACES, uv, np.broadcast_to(0.09 * np.eye(2), (*uv.shape, 2))).cov
    assert np.allclose(predicted_covariance(rig, PLACES, centroid_sd=0.3), by_refine, rtol=1e-6)


def test_where_the_world_stands_does_not_change_what_is_apart_from_it(wands):
    fit = wands[0]
    apart = apart_from_frame(fit.rig, fit.joint, PLACES, centroid_sd=0.1)
    assert np.allclose(
        apart_from_frame(fit.rig, apart, PLACES, centroid_sd=0.1), apart, atol=1e-6 * np.abs(apart).max()
    )
    turn = Rotation.from_rotvec([0.3, -0.2, 0.9]).as_matrix()
    moved = PLACES @ turn.T + [100.0, -2000.0, 50.0]
    good = np.isfinite(fit.xyz).all(1)
    other = fit_moved_to(fit, fit.xyz[good], fit.xyz[good] @ turn.T + [100.0, -2000.0, 50.0])
    again = apart_from_frame(other.rig, other.joint, moved, centroid_sd=0.1)
    here, there = (
        deviation(predicted_covariance(r, p, centroid_sd=0.1, joint=j))
        for r, p, j in ((fit.rig, PLACES, apart), (other.rig, moved, again))
    )
    assert np.allclose(here, there, rtol=1e-4)


def test_a_turn_of_the_whole_world_is_no_error_of_shape():
    """A joint covariance made of one motion of the world alone leaves nothing when that motion does not count."""
    H = np.zeros((len(RIG), 15))
    for c, cam in enumerate(RIG):
        H[c, 9:12], H[c, 12:15] = -cam.R @ [0, 0, 1e-3], 0.0
    joint = np.outer(H.ravel(), H.ravel())
    plain = predicted_covariance(RIG, PLACES, centroid_sd=1e-3, joint=joint)
    level = np.linalg.norm(PLACES[:, :2], axis=1) * 1e-3
    assert np.allclose(np.sqrt(np.trace(plain, axis1=1, axis2=2)), level, rtol=0.02)
    apart = apart_from_frame(RIG, joint, PLACES, centroid_sd=1e-3)
    cov = predicted_covariance(RIG, PLACES, centroid_sd=1e-3, joint=apart)
    bare = predicted_covariance(RIG, PLACES, centroid_sd=1e-3)
    assert np.allclose(cov, bare, atol=1e-4)


def test_wrong_arguments_are_named():
    with pytest.raises(ValueError, match="centroid_sd is 0"):
        predicted_covariance(RIG, PLACES, centroid_sd=0)
    with pytest.raises(ValueError, match=r"joint has shape \(3, 3\)"):
        predicted_covariance(RIG, PLACES, centroid_sd=1, joint=np.eye(3))


def test_visible_means_ahead_inside_and_on_this_side_of_the_fold():
    cam = camera("a", (4000, 0, 900), lens=np.array([-0.3, 0, 0, 0, 0]))
    rig = Rig((cam,))
    inside = np.array([0.0, 0, 900])
    behind = np.array([9000.0, 0, 900])
    aside = np.array([3000.0, 3000.0, 900])  # folded back into the image by k1, though 70 degrees off the axis
    assert visible(rig, np.array([inside, behind, aside])).tolist() == [[True, False, False]]
    unknown = Rig((replace(cam, size=np.zeros(2, int), distortion=np.zeros(5)),))
    assert visible(unknown, np.array([inside, behind, aside])).tolist() == [[True, False, True]]


def test_the_map_of_a_volume_agrees_with_the_places_it_is_made_of():
    grid = map_volume(RIG, RIG.volume, centroid_sd=0.1, places=300)
    xyz = points_of(grid.axes)
    assert np.allclose(grid.sd.ravel(), deviation(predicted_covariance(RIG, xyz, centroid_sd=0.1)))
    assert grid.sd.shape == grid.seen.shape == grid.without.shape[1:]
    assert (grid.sd_largest_axis >= grid.sd).all()
    assert (grid.sd_largest_axis <= np.sqrt(3) * grid.sd * (1 + 1e-9)).all()
    for c in range(len(RIG)):
        assert np.nanmin(grid.without[c] / grid.sd) >= 1
    assert np.array_equal(grid.seen.ravel(), visible(RIG, xyz).sum(0))
    far = map_volume(RIG, RIG.volume + 20000.0, centroid_sd=0.1, places=100)
    assert np.isnan(far.sd).all()


def test_rays_at_right_angles_are_told_from_flat_ones():
    rig = Rig((camera("a", (4000, 0, 900)), camera("b", (0, 4000, 900)), camera("c", (4000, 100, 900))))
    here = np.array([[0.0, 0, 900]])
    every = np.ones((3, 1), bool)
    assert ray_angle(rig, here, every)[0] == pytest.approx(90, abs=1e-6)
    flat = ray_angle(rig, here, np.array([[True], [False], [True]]))[0]
    assert flat == pytest.approx(np.degrees(np.arctan(100 / 4000)))
    assert np.isnan(ray_angle(rig, here, np.array([[True], [False], [False]]))[0])


def test_an_empty_volume_and_cameras_that_look_apart_are_explained():
    with pytest.raises(KinemarkError, match=r"is empty\. Set volume_mm"):
        volume_grid([[0, 0, 0], [1000, 0, 1000]])
    rig = Rig((camera("a", (4000, 0, 900)), camera("b", (6000, 0, 900), target=(9000, 0, 900))))
    with pytest.raises(KinemarkError, match="look at a common place"):
        view_volume(rig)
    assert np.abs(view_volume(ring(4)).mean(0) - [0, 0, 900]).max() < 1


# -- errors left out ---------------------------------------------------------------------------------------------------


def test_folds_share_out_every_usable_pose_once():
    usable = np.arange(40) % 7 != 0
    masks = np.array(folds_of(usable, 3))
    assert np.array_equal(masks.sum(0), usable.astype(int))
    assert masks.sum(1).min() > 8


def test_a_wand_judges_poses_that_it_has_not_seen():
    uv = waved(0.1, 3)
    fit = calibrate_sticks(RIG.names, SIZES, uv, along=ALONG)
    assert np.allclose(seen_by(fit, 2)[fit.kept.reshape(uv.shape[:3])], uv[fit.kept.reshape(uv.shape[:3])])
    judged = judge_poses(fit, ALONG, method=Bundle())
    off = judged.lengths[np.isfinite(judged.lengths)] - 500
    assert len(off) > 0.95 * len(POSES)
    errors = image_errors(judged.residual.reshape(len(RIG), -1, 2))
    assert np.sqrt(np.nanmean(errors**2) / 2) == pytest.approx(0.1, rel=0.1)
    own, _ = reconstructed(fit.rig, seen_by(fit, 2))
    own = np.linalg.norm(own[:, 1] - own[:, 0], axis=1) - 500
    assert 0.9 * np.nanstd(own) < off.std() < 2 * np.nanstd(own)


def test_a_lens_that_no_pose_supports_shows_only_on_poses_left_out():
    """All lens terms from twenty poses: the residual is small, the poses left out are not."""
    few = waved(0.3, 4)[:, ::4]
    method = Bundle(radial=3, tangential=True)
    fit = calibrate_sticks(RIG.names, SIZES, few, along=ALONG, method=method)
    judged = judge_poses(fit, ALONG, method=method)
    errors = image_errors(judged.residual.reshape(len(RIG), -1, 2))
    own = fit.residual[fit.kept]
    assert np.sqrt(np.nanmean(errors**2)) > 1.5 * np.sqrt((own**2).sum(1).mean())


@pytest.mark.parametrize("cameras", [[0, 1], [0, 1, 2, 3]], ids=str)
def test_halves_of_a_film_are_alike_unless_a_camera_is_moved(cameras):
    late = np.arange(len(POSES)) >= 0.6 * len(POSES)
    uv = waved(0.1, 0)[cameras]
    names, sizes = [RIG.names[c] for c in cameras], np.array(SIZES)[cameras]
    fit = calibrate_sticks(names, sizes, uv, along=ALONG)
    assert halves_ratio(fit, ALONG, method=Bundle()).max() < 1.2
    uv[1, late] += [0.5, -0.4]
    fit = calibrate_sticks(names, sizes, uv, along=ALONG)
    assert halves_ratio(fit, ALONG, method=Bundle()).max() > 1.3


def test_halves_of_exact_images_differ_by_nothing():
    fit = calibrate_sticks(RIG.names, SIZES, waved(0.0, 0), along=ALONG)
    assert (halves_ratio(fit, ALONG, method=Bundle()) == 1).all()


def test_halves_that_leave_few_equations_tell_nothing():
    few = np.arange(len(POSES)) < 52
    uv = waved(0.1, 0)[:2, :][:, few]
    fit = calibrate_sticks(RIG.names[:2], np.array(SIZES)[:2], uv, along=ALONG)
    assert np.isnan(halves_ratio(fit, ALONG, method=Bundle())).all()


def test_the_centroids_noise_is_read_from_residuals_with_what_was_fitted_to_them():
    found = []
    for seed in range(8):
        uv = seen(RIG, POINTS, 0.2, np.random.default_rng(seed))
        rig, evidence = of_control_points(uv)
        found.append(centroid_deviation(rig, evidence) ** 2)
    assert np.sqrt(np.mean(found)) == pytest.approx(0.2, rel=0.08)
    assert centroid_deviation(ring(2), Evidence("a file")) == 0.2
    stated = Rig(tuple(replace(c, residual=0.5) for c in RIG))
    assert centroid_deviation(stated, Evidence("a file")) == pytest.approx(0.5 / np.sqrt(2))


def test_an_image_is_covered_where_its_points_are():
    cam = RIG[0]
    corners = np.array([[100.0, 100], [1180, 100], [1180, 924], [100, 924]])
    cover = image_coverage(cam, corners, PLACES)
    assert cover.image_share == pytest.approx(1080 * 824 / (1280 * 1024))
    assert cover.volume_share > 0.9
    half = image_coverage(cam, corners * [0.5, 1], PLACES)
    assert 0.2 < half.volume_share < 0.8
    none = image_coverage(cam, corners[:1], PLACES)
    assert (none.image_share, none.volume_share) == (0, 0)


# -- changes -----------------------------------------------------------------------------------------------------------


def test_a_kicked_camera_is_told_from_a_new_world():
    old = laboratory(5)
    turn, shift = Rotation.from_rotvec([0.1, 0.2, 1.0]).as_matrix(), np.array([500.0, -200.0, 30.0])
    cameras = [replace(c, R=c.R @ turn.T, t=c.t - c.R @ turn.T @ shift) for c in old]
    kick = Rotation.from_rotvec([0, 0.01, 0]).as_matrix()
    cameras[2] = replace(cameras[2], R=kick @ cameras[2].R, t=kick @ cameras[2].t + [0, 0, 8.0])
    cameras[4] = replace(cameras[4], K=cameras[4].K @ np.diag([1.02, 1.02, 1]))
    change = compare(old, Rig(tuple(cameras)), PLACES @ turn.T + shift)
    assert np.allclose(change.moved, [0, 0, 8.0, 0, 0], atol=1e-6)
    assert np.allclose(change.turned, [0, 0, np.degrees(0.01), 0, 0], atol=1e-5)
    assert np.allclose(change.focal, [0, 0, 0, 0, 0.02], atol=1e-9)
    assert np.allclose(change.image[[0, 1, 3]], 0, atol=1e-6)
    assert change.image[2] > 5
    assert change.world > 300
    same = compare(old, old, PLACES)
    assert max(same.moved.max(), same.image.max(), same.world) < 1e-6


def test_rigid_motions_of_rig_and_volume_change_no_figure():
    """SD, coverage and losses do not depend on where the world has its origin."""
    rig, _ = of_control_points(seen(RIG, POINTS, 0.05, np.random.default_rng(1)))
    shift = np.array([1000.0, 2000.0, -500.0])
    moved = replace(moved_to(rig, POINTS, POINTS + shift), volume=rig.volume + shift)
    a, b = (map_volume(r, r.volume, centroid_sd=0.1, joint=joint_of(r), places=200) for r in (rig, moved))
    assert np.allclose(a.sd, b.sd, rtol=1e-6)
    assert np.allclose(a.without, b.without, rtol=1e-6)
