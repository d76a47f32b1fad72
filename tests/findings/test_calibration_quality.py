"""What the verdict on a calibration says of good ones and of every fault."""

import json
from dataclasses import replace

import numpy as np
import pytest

from kinemark.calibrate.control_points.judgement import Judgement
from kinemark.calibrate.quality.calibration_evidence import Check, Evidence
from kinemark.calibrate.quality.volume import map_volume
from kinemark.data import Rig, make_finding
from kinemark.findings.calibration_quality import _short, calibration_figures
from kinemark.findings.trial_findings import _judged
from kinemark.geometry import project_all
from kinemark.report.calibration_page import calibration_page
from kinemark.report.figures_calibration import lost_figure
from kinemark.report.terminal_summary import calibration_summary
from kinemark.report.words import headline_of, text_of
from support.calibrations import POINTS, RIG, of_control_points, seen
from support.drawings import checked
from support.findings import found, kinds
from support.laboratory import camera


@pytest.fixture(scope="module")
def good():
    return of_control_points(seen(RIG, POINTS, 0.05, np.random.default_rng(1)))


def test_a_good_calibration_is_called_good_and_says_for_what(good):
    figures = calibration_figures(*good, session="lab")
    assert figures["verdict"]["grade"] == "green"
    sd = figures["precision"]["sd_95_mm"]
    headline = figures["verdict"]["statements"][0]
    assert (headline["kind"], headline["values"]) == ("calibration_good", {"sd_mm": sd, "volume_share": 0.95})
    assert f"{sd:.2f}\u00a0mm per axis in 95\u00a0% of the volume" in headline_of(figures["verdict"])
    assert figures["fit"]["points"] == 24
    assert figures["fit"]["left_out_rms_px"] > figures["fit"]["residual_rms_px"]
    assert json.loads(json.dumps(figures, allow_nan=False)) == figures
    text = calibration_summary(figures)
    assert all(name in text for name in RIG.names)


def test_the_verdict_reveals_exchanged_and_repeated_images(good):
    rig, evidence = good
    swapped = Rig((replace(rig[1], name="cam1"), replace(rig[0], name="cam2"), *rig.cameras[2:]))
    residual = evidence.uv - project_all(swapped, POINTS)
    figures = calibration_figures(swapped, replace(evidence, residual=residual))
    assert figures["verdict"]["grade"] == "red"
    (missed,) = (one for one in found(figures, "cameras_miss_points") if one.severity == "red")
    assert missed.cameras == ("cam1", "cam2")
    twice = Rig((rig[0], replace(rig[0], name="cam2"), *rig.cameras[2:]), "", rig.volume)
    (same,) = found(calibration_figures(twice, evidence), "cameras_at_one_place")
    assert (same.severity, same.cameras) == ("red", ("cam1", "cam2"))


def mirrored(uv, which=range(4)):
    """Images whose v is counted from the bottom in these cameras."""
    uv = uv.copy()
    for c in which:
        uv[c, :, 1] = RIG[c].size[1] - 1 - uv[c, :, 1]
    return uv


def test_a_world_of_left_handed_coordinates_and_mirrored_images_are_told(good):
    """Points that are surveyed with y the other way fit as well as before; so do pixels counted from the bottom."""
    uv = seen(RIG, POINTS, 0.05, np.random.default_rng(1))
    told = {"coordinates_mirrored", "cameras_mirrored"}
    assert not told & set(kinds(calibration_figures(*good)))
    (one,) = found(calibration_figures(*of_control_points(mirrored(uv, [2]))), "cameras_mirrored")
    assert one.cameras == (RIG.names[2],)
    (bottom,) = found(calibration_figures(*of_control_points(mirrored(uv))), "coordinates_mirrored")
    sideways = uv.copy()
    sideways[..., 0] = np.array([camera.size[0] for camera in RIG])[:, None] - 1 - uv[..., 0]
    (left,) = found(calibration_figures(*of_control_points(sideways)), "coordinates_mirrored")
    assert (bottom.severity, left.severity) == ("info", "amber")
    assert "from the bottom" in text_of(bottom)
    assert "left-handed, or all images are mirrored" in text_of(left)


def test_pixels_from_the_bottom_are_no_fault_in_a_world_whose_y_goes_up():
    """Nothing tells there which axis goes up; the coordinates are right-handed."""
    uv = mirrored(seen(RIG, POINTS, 0.05, np.random.default_rng(1)))
    rig, evidence = of_control_points(uv)
    y_up = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    turned = Rig(tuple(replace(camera, R=camera.R @ y_up.T) for camera in rig), rig.method)
    (one,) = found(calibration_figures(turned, replace(evidence, xyz=evidence.xyz @ y_up.T)), "coordinates_mirrored")
    assert one.severity == "info"
    assert "v is counted from the bottom, or" in text_of(one)


def grade(rig, evidence, **changes):
    figures = calibration_figures(rig, replace(evidence, **changes))
    return figures["verdict"]["grade"], kinds(figures), figures


def test_every_fault_is_named(good):
    rig, evidence = good
    far = replace(rig, volume=rig.volume + np.array([3000.0, 0, 0]))
    assert "volume_unseen" in grade(far, evidence)[1]
    guessed = replace(rig, volume=np.full((2, 3), np.nan))
    apart = replace(evidence, xyz=evidence.xyz + np.array([3000.0, 0, 0]))
    (unseen,) = found(grade(guessed, apart)[2], "volume_unseen")
    assert unseen.severity == "amber"  # nobody stated this volume
    tiny = replace(rig, cameras=tuple(replace(c, t=c.t / 1000) for c in rig), volume=rig.volume / 1000)
    colour, named, _ = grade(tiny, replace(evidence, xyz=evidence.xyz / 1000))
    assert (colour, "cameras_distance_implausible" in named) == ("red", True)
    for times, said in ((1 / 30, False), (30, False), (1000, True)):  # a hand, 0.14 m; a field of play; mm taken for m
        wide = replace(rig, cameras=tuple(replace(c, t=c.t * times) for c in rig), volume=rig.volume * times)
        wide = grade(wide, replace(evidence, xyz=evidence.xyz * times))
        assert ("cameras_distance_implausible" in wide[1]) == said
    loud = evidence.left_out.copy()
    loud[:, 3] *= 30
    (odd,) = found(grade(rig, evidence, left_out=loud)[2], "control_points_disagree")
    assert odd.values["points_list"] == ("A4",)
    assert "left_out_errors_large" in grade(rig, evidence, left_out=20 * evidence.left_out)[1]
    for ratio, severity in ((1.2, None), (1.7, "amber"), (2.7, "red")):
        halves = found(grade(rig, evidence, halves=np.array([1.0, ratio]))[2], "film_halves_differ")
        assert [one.severity for one in halves] == ([severity] if severity else [])
    one = np.array([5.0, 1, 1, 1])[:, None, None] * evidence.residual * 4
    assert found(grade(rig, evidence, residual=one)[2], "camera_fits_worse")[0].cameras == ("cam1",)
    narrow = np.where((evidence.uv[..., :1] < 640), evidence.uv, np.nan)
    assert "points_cover_part" in grade(rig, evidence, uv=narrow)[1]
    small = replace(rig, cameras=(rig[0], replace(rig[1], size=np.array([900, 1024])), *rig.cameras[2:]))
    (outside,) = found(grade(small, evidence)[2], "points_outside_image")
    assert outside.cameras == ("cam2",) and outside.values["most_share"] > 0.1
    lenses = [c.distortion for c in rig]
    lenses[1] = np.array([-0.6, 0, 0, 0, 0])
    folding = replace(rig, cameras=tuple(replace(c, distortion=k) for c, k in zip(rig, lenses, strict=True)))
    (folds,) = found(grade(folding, evidence)[2], "lens_folds")
    assert folds.cameras == ("cam2",) and 0 < folds.values["most_share"] < 1
    assert "lens_folds" not in grade(rig, evidence)[1]
    noted = make_finding("world_of_first_camera")
    assert found(grade(rig, evidence, findings=(noted,))[2], "world_of_first_camera") == [noted]
    bent = replace(rig, cameras=tuple(replace(c, distortion=np.zeros(5), cov=np.zeros((15, 15))) for c in rig))
    assert {"no_lens_correction", "no_uncertainty_stated"} <= set(grade(bent, evidence)[1])


def test_a_calibration_that_states_no_uncertainty_is_neither_good_nor_usable(good):
    rig, evidence = good
    silent = replace(rig, cameras=tuple(replace(c, cov=np.zeros((15, 15))) for c in rig))
    colour, named, figures = grade(silent, evidence)
    assert colour == "amber" and "no_uncertainty_stated" in named
    assert "not known" in headline_of(figures["verdict"]) and "sable" not in headline_of(figures["verdict"])
    assert "no_uncertainty_stated" not in grade(rig, evidence)[1]
    (of_trial,) = _judged({"calibration": {key: figures[key] for key in ("verdict", "precision")}})
    assert of_trial.severity == "amber" and "not known" in text_of(of_trial)  # nor is a trial green that rests on it


def test_lengths_that_come_out_wrong_are_named(good):
    rig, evidence = good
    place = np.random.default_rng(0).uniform(*rig.volume, (200, 3))
    known, error = np.array([500.0]), np.where(place[:, :1] > 1600, 8.0, 0.1)
    colour, _, figures = grade(rig, evidence, known=known, lengths=known + error, place=place)
    assert colour == "amber"
    here = found(figures, "wand_length_wrong_here")
    assert here and all(one.values["error_mm"] > 1 and one.values["place_mm_list"][0] > 1400 for one in here)
    assert grade(rig, evidence, checks=(Check("The arm", 800.0, 790.0),))[0] == "amber"
    assert grade(rig, evidence, checks=(Check("The arm", 800.0, 700.0),))[0] == "red"


def test_a_camera_on_which_much_rests_is_named():
    places = [(4000, -200, 1500), (4000, 200, 1500), (0, 4000, 1500)]
    rig = Rig(tuple(camera(f"c{i}", p) for i, p in enumerate(places)), "", np.array([[-300.0] * 3, [300.0] * 3]) + 900)
    figures = calibration_figures(rig, Evidence("a file"))
    assert [one.cameras for one in found(figures, "camera_indispensable")] == [("c2",)]
    assert figures["cameras"][2]["without"]["ratio_median"] > 2 > figures["cameras"][0]["without"]["ratio_median"]
    two = calibration_figures(Rig(rig.cameras[1:], "", rig.volume), Evidence("a file"))
    assert "two_cameras_only" in kinds(two)
    assert two["cameras"][0]["without"]["newly_unseen_share"] == 1


def test_the_page_needs_nothing_else_and_escapes_names(good):
    rig, evidence = good
    evil = "<b>x</b>"
    rig = Rig((replace(rig[0], name=evil), *rig.cameras[1:]), evil, rig.volume)
    figures = calibration_figures(rig, replace(evidence, names=(evil, *evidence.names[1:])), session=evil)
    page = calibration_page(figures=figures, rig=rig, evidence=evidence)
    body = page[: page.index("<script>")]
    assert evil not in body
    assert "src=" not in body
    ids = [part.split('"')[0] for part in page.split(' id="')[1:]]
    assert len(set(ids)) == len(ids)
    assert all(f'data-for="{name}"' in page for name in ("slices", "space", "loss", "residuals", "images", "lens"))


def reason(kind, severity):
    """A reason of a judgement, about the point A1."""
    return make_finding(kind, severity=severity, points_list=["A1"])


def test_every_reason_of_a_judgement_keeps_its_weight(good):
    rig, evidence = good
    for grade_, weights, colour in (
        ("bad", ("red", "red", "amber", "info"), "red"),
        ("usable", ("amber", "amber", "amber", "info"), "amber"),
    ):
        reasons = tuple(reason("control_points_seen_by_few", weight) for weight in weights)
        figures = calibration_figures(rig, replace(evidence, judged=Judgement(grade_, reasons)))
        assert [one.severity for one in found(figures, "control_points_seen_by_few")] == list(weights)
        assert figures["verdict"]["grade"] == colour
    well = Judgement("good", (make_finding("no_uncertainty_stated"), reason("control_points_unseen", "info")))
    figures = calibration_figures(rig, replace(evidence, judged=well))
    assert figures["verdict"]["grade"] == "green" and kinds(figures) == ["control_points_unseen"]
    assert figures["verdict"]["statements"][2]["kind"] == "no_uncertainty_stated"  # the first reason of a good one


def test_where_a_lost_camera_is_missed_is_drawn_as_it_is_predicted(good):
    figures = calibration_figures(*good)
    lost, sd = figures["map"]["lost"], figures["precision"]["centroid_sd_px"]
    grid = map_volume(good[0], good[0].volume, centroid_sd=sd)
    k = int(np.argmin(np.abs(grid.axes[2] - lost["level_mm"])))
    assert lost["axis"] == 2 and 0 < k < len(grid.axes[2]) - 1
    assert np.allclose(lost["without_sd_mm"], grid.without[:, :, :, k], rtol=1e-3)
    drawn = checked(lost_figure(figures)).data
    assert len(drawn) == len(RIG)
    for c, panel in enumerate(drawn):
        assert np.allclose(panel.z, (grid.without[c] / grid.sd)[:, :, k].T, rtol=2e-3)


def test_figures_that_are_zero_or_infinite_are_shortened_without_a_warning():
    short = _short(np.array([0.0, np.inf, np.nan, 1.23456]))
    assert np.array_equal(short, [0.0, np.nan, np.nan, 1.235], equal_nan=True)
