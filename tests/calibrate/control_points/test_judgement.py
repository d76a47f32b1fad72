"""Whether a calibration from control points is good: good ones are called so, bad ones with what makes them bad."""

import numpy as np
import pytest

from kinemark.calibrate import ControlPoints, Dlt, control_point_quality, judge_control_points
from kinemark.calibrate.control_points.judgement import BAD, GOOD, grade_of, limits
from kinemark.calibrate.control_points.survey import displaced_points, distance, refused_everywhere
from kinemark.geometry import project_all
from kinemark.report.words import text_of
from kinemark.synth import ring
from kinemark.synth.targets import calibration_box, control_frame
from support.shared import shared_data

RODS = control_frame()
FRAME, NAMES = RODS.xyz.reshape(-1, 3), RODS.marker_names
BOX = calibration_box(1400.0).xyz[:, 0]
NOISE = 0.1


def seen(n=4, xyz=FRAME, *, noise=NOISE, seed=0, k1=-0.12):
    """A rig and what it sees (n, N, 2) px."""
    rig = ring(n, distortion=(k1, 0, 0, 0, 0))
    return rig, project_all(rig, xyz) + np.random.default_rng(seed).normal(0, noise, (n, len(xyz), 2))


def quality(rig, xyz, uv, **options):
    return control_point_quality(rig.names, [c.size for c in rig], xyz, uv, **options)


def judged(rig, xyz, uv, **options):
    """The grade, and the reasons by their kinds, the last where a kind came several times."""
    grade, findings = judge_control_points(quality(rig, xyz, uv, points=NAMES[: len(xyz)], **options))
    return grade, {one.kind: one for one in findings}


def stated(uv, noise=NOISE):
    return np.tile(np.eye(2) * noise**2, (*uv.shape[:2], 1, 1))


@pytest.mark.parametrize("seed", range(3))
def test_a_good_calibration_is_called_good(seed):
    rig, uv = seen(seed=seed)
    grade, reasons = judged(rig, FRAME, uv, cov=stated(uv))
    assert grade == "good" and len(reasons) < 6
    assert "control_points_return" in reasons
    assert not {"residuals_above_noise", "control_points_displaced"} & set(reasons)


def test_the_error_in_the_verdict_is_that_of_unseen_points():
    """What points that took no part say is what other points of the volume are off by, within a third."""
    rig, uv = seen(noise=0.3)
    fit = quality(rig, FRAME, uv)
    said = np.sqrt((fit.left_out_xyz**2).sum(1).mean())
    others = np.random.default_rng(1).permutation(24).reshape(6, 4)  # real folds of four points
    off = []
    for fold in others:
        rest = np.setdiff1d(np.arange(24), fold)
        part = quality(rig, FRAME, np.where(np.isin(np.arange(24), rest)[:, None], uv, np.nan))
        without = part._replace(rig=part.rig)
        assert not without.kept[:, fold].any()
        moved = uv[:, fold] - project_all(part.rig, FRAME[fold])
        off.append(moved)
    assert np.sqrt(np.mean(np.square(off))) == pytest.approx(np.sqrt(np.nanmean(fit.left_out_error**2)), rel=0.34)
    (back,) = (one for one in judge_control_points(fit).findings if one.kind == "control_points_return")
    assert back.values["rms_mm"] == pytest.approx(said)


def test_few_points_are_never_good_and_never_bad_without_proof():
    low, high = limits(1 / 1000, 6)
    assert low < 1 / 1000 < high and grade_of(low, high) == 1
    assert limits(1.0, 10000) == pytest.approx((1.0, 1.0), rel=0.02)
    assert grade_of(*limits(0.1 / GOOD, 6)) == 0 and grade_of(*limits(10 / BAD, 6)) == 2
    low, high = np.array([limits(np.sqrt(x / 8), 8) for x in np.random.default_rng(0).chisquare(8, 4000)]).T
    assert ((low < 1) & (high > 1)).mean() == pytest.approx(0.95, abs=0.015)


def test_six_points_are_good_only_with_residuals_far_below_the_limit():
    """Six equations are left over: the truth may be 2.2 times as large as the residuals say."""
    grades = []
    for seed in range(4):
        rig, uv = seen(3, BOX[:6], noise=0.15, seed=seed, k1=0.0)
        fit = quality(rig, BOX[:6], uv)
        s = np.sqrt((fit.residual**2).sum() / fit.freedom.sum())
        parts = min(np.linalg.norm(np.ptp(u, axis=0)) for u in uv) / (np.sqrt(2) * s)
        assert fit.freedom.sum() == 6 and parts > GOOD
        grades.append((parts > 2.2 * GOOD, judge_control_points(fit).grade))
    assert sorted(set(grades)) == [(False, "usable"), (True, "good")]


def test_wild_noise_is_bad_and_a_missing_lens_term_is_told():
    rig, uv = seen(noise=12.0)
    assert judged(rig, FRAME, uv)[0] == "bad"
    rig, uv = seen()
    grade, reasons = judged(rig, FRAME, uv, cov=stated(uv), method=ControlPoints(radial=0))
    assert grade == "usable" and reasons["residuals_above_noise"].values["ratio"] > 3
    assert "control_points_displaced" not in reasons  # the survey is innocent


def test_a_camera_worse_than_the_others_is_named():
    rig, uv = seen()
    uv[2] += np.random.default_rng(1).normal(0, 1.5, (24, 2))
    grade, reasons = judged(rig, FRAME, uv)
    assert grade == "usable" and reasons["cameras_worse_than_others"].cameras == ("cam3",)
    assert not any("cam1" in one.cameras for one in reasons.values())


@pytest.mark.parametrize("seed", range(3))
def test_a_marker_surveyed_wrong_is_named_with_its_offset(seed):
    """It is found to be where it is, as exactly as the cameras that were fitted without it say."""
    rig, uv = seen(seed=seed)
    wrong, by = FRAME.copy(), np.array([0, 0, 20.0])
    wrong[7] += by
    fit = quality(rig, wrong, uv, cov=stated(uv), points=NAMES)
    found = displaced_points(fit)
    assert found.rows.tolist() == [7]
    off = found.offset[0] + by
    assert off @ np.linalg.solve(found.rest.left_out_cov[7], off) < 16.3  # χ² of three, 1 in 1000
    grade, findings = judge_control_points(fit)
    (said,) = (one.values for one in findings if one.kind == "control_points_displaced")
    assert grade == "good" and (said["points_list"], said["where"]) == (("B2",), "alike")
    assert said["greatest_mm"] == pytest.approx(np.linalg.norm(found.offset[0]))
    assert said["shift_mm_list"] == pytest.approx(tuple(found.offset[0]))
    assert said["before_px"] is None  # no camera used it


@pytest.mark.parametrize("seed", [0, 2, 4, 7])
def test_a_point_that_no_camera_used_is_named_also_where_others_are_in_doubt(seed):
    """One of 14 is mistyped by a digit: a tenth of its place."""
    rng = np.random.default_rng([313, seed])
    xyz = np.column_stack([rng.uniform(-900, 900, (14, 2)), rng.uniform(50, 1900, 14)])
    rig, uv = seen(xyz=xyz, seed=seed)
    wrong = xyz + rng.normal(0, 0.3, xyz.shape)
    wrong[4] /= 10
    fit = quality(rig, wrong, uv, points=NAMES[:14])
    (said,) = (one for one in judge_control_points(fit).findings if one.kind == "control_points_displaced")
    assert NAMES[4] in said.values["points_list"]


def test_a_whole_rod_that_hangs_elsewhere_is_named():
    """A quarter of the points pull all cameras towards themselves; no point of them stands out."""
    rig, uv = seen(6)
    wrong = FRAME.copy()
    wrong[6:12] += [15, 0, 0]
    grade, reasons = judged(rig, wrong, uv, cov=stated(uv))
    assert grade == "usable"
    said = reasons["control_points_displaced"].values
    assert (said["points_list"], said["where"]) == (("B1", "B2", "B3", "B4", "B5", "B6"), "alike")
    assert said["shift_mm_list"] == pytest.approx((-15, 0, 0), abs=5)
    away = np.linalg.norm(said["shift_mm_list"])  # the distance in words is that of the shift beside it
    words = text_of(reasons["control_points_displaced"]).replace("\u00a0", " ")
    assert f"at the surveyed places but {away:.3g} mm away, by (" in words


def test_one_of_eight_control_balls_measured_wrong_is_named():
    rig, uv = seen(4, BOX, noise=0.3, k1=0.0)
    for k, axis in ((3, 0), (6, 2)):
        wrong = BOX.copy()
        wrong[k, axis] += 30
        found = displaced_points(quality(rig, wrong, uv))
        assert found.rows.tolist() == [k]
        np.testing.assert_allclose(found.offset[0], -30 * np.eye(3)[axis], atol=5)


@pytest.mark.parametrize("wrong", ["exchanged", "taken", "survey"])
def test_points_mistaken_for_others_are_named_where_they_were(wrong):
    rig, uv = seen()
    if wrong == "exchanged":
        uv[2, [3, 9]] = uv[2, [9, 3]]
        kind, points, there = "control_points_left_out", ("A4", "B4"), ("B4", "A4")
    elif wrong == "taken":
        uv[2, 3] = uv[2, 4] + 0.3
        kind, points, there = "control_points_left_out", ("A4",), ("A5",)
    else:
        uv[:, [3, 9]] = uv[:, [9, 3]]
        kind, points, there = "control_points_displaced", ("A4", "B4"), "other"
    grade, reasons = judged(rig, FRAME, uv)
    said = reasons[kind]
    assert grade == "good" and said.values["points_list"] == points
    assert said.values["where" if wrong == "survey" else "place_of_list"] == there
    assert said.cameras == (() if wrong == "survey" else ("cam3",))
    assert ("control_points_displaced" in reasons) == (wrong == "survey")


def test_an_image_misplaced_among_few_is_blamed_and_not_the_survey():
    rig, uv = seen(3, BOX, noise=0.3, k1=0.0)
    uv[1, 2] += [30, 10]
    grade, reasons = judged(rig, BOX, uv)
    said = reasons["control_point_misplaced"]
    assert (grade, said.cameras, said.values["point"]) == ("bad", ("cam2",), "A3")
    assert said.values["after_px"] < said.values["before_px"] / 2
    assert "control_points_displaced" not in reasons


def test_points_that_no_camera_sees_are_named_and_one_camera_places_nothing():
    rig, uv = seen()
    uv[:, 8] = np.nan
    assert judged(rig, FRAME, uv)[1]["control_points_unseen"].values["points_list"] == ("B3",)
    grade, reasons = judged(rig.select(["cam1"]), FRAME, uv[:1])
    assert grade == "good" and reasons["control_points_by_residual"].values["alone"]


@pytest.mark.parametrize(("depth", "loose"), [(0.03, True), (1.0, False)])
def test_points_nearly_in_a_plane_leave_cameras_uncertain(depth, loose):
    xyz = FRAME.copy()
    xyz[:, 1] = 700 + depth * (xyz[:, 1] - 700)
    rig, uv = seen(3, xyz, noise=1.0)
    grade, reasons = judged(rig, xyz, uv)
    assert grade == "usable" and ("focal_length_uncertain" in reasons) == loose


def test_distances_of_true_points_stay_below_what_makes_them_suspicious():
    far = []
    for seed in range(6):
        rig, uv = seen(3 + seed % 3, seed=seed)
        fit = quality(rig, FRAME, uv)
        assert not refused_everywhere(fit).any()
        far.append(distance(fit).max())
    assert np.median(far) < 3.5 and max(far) < 5


@pytest.mark.parametrize("method", [ControlPoints(), Dlt()])
def test_a_real_bad_calibration_is_called_bad_with_the_reason(method):
    """25 points on five poles, the fifth surveyed 11 cm off."""
    folder = shared_data("cameras/bad_control_frame_8cam")
    xyz = 1000 * np.loadtxt(folder / "ref3d_realworld/ref3d_realworld.csv", delimiter=",")
    files = [folder / f"pixelcorrds/c0{c}_markers_1_line.csv" for c in range(1, 9)]
    uv = np.stack([np.loadtxt(f, delimiter=",", skiprows=1, ndmin=2)[0, 1:].reshape(-1, 2) for f in files])
    fit = control_point_quality([f"c{c}" for c in range(1, 9)], [(1920, 1080)] * 8, xyz, uv, method=method)
    grade, findings = judge_control_points(fit)
    (said,) = (one.values for one in findings if one.kind == "control_points_displaced")
    assert grade == "bad" and said["points_list"] == ("21", "22", "23", "24", "25")
    found = displaced_points(fit)
    pole = found.offset[np.isin(found.rows, range(20, 25))]
    np.testing.assert_allclose(pole.mean(0)[:2], [-115, 0], atol=6)
    assert max(c.residual for c in found.rest.rig) < 0.5 * max(c.residual for c in fit.rig)
    for c, camera in enumerate(fit.rig):
        off = np.linalg.norm(fit.residual[c, fit.kept[c]], axis=1)
        np.testing.assert_allclose(camera.residual, np.sqrt(np.mean(off**2)))


def test_real_calibrations_of_six_points_and_of_hundreds_are_not_bad():
    folder = shared_data("cameras/kinemat_running_3cam")
    uv = np.stack([np.loadtxt(folder / f"r1cam{c}.cal")[:6] for c in (1, 2, 3)])
    xyz = np.loadtxt(folder / "calframe.txt")
    for method in (ControlPoints(), Dlt()):
        fit = control_point_quality("abc", [(0, 0)] * 3, xyz, uv, method=method)
        grade, findings = judge_control_points(fit)
        assert (grade, findings[0].kind) == ("usable", "control_points_by_residual")
        assert not findings[0].values["alone"]
    table = np.loadtxt(shared_data("cameras/resection_5cam/tests/sample_calibration/cam3.points4cal.dat"))
    fit = control_point_quality(["cam3"], [(656, 491)], table[:, :3], table[None, :, 4:6])
    assert judge_control_points(fit).grade != "bad"
