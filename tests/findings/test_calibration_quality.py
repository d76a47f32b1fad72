"""What the verdict on a calibration says of good ones and of every fault."""

import json
from dataclasses import replace

import numpy as np
import pytest

from kinemark.calibrate.control_points.judgement import Judgement
from kinemark.calibrate.quality.calibration_evidence import Check, Evidence
from kinemark.calibrate.quality.volume import map_volume
from kinemark.data import Rig
from kinemark.findings.calibration_quality import calibration_figures
from kinemark.geometry import project_all
from kinemark.report.calibration_page import calibration_page
from kinemark.report.calibration_text import calibration_summary
from kinemark.report.figures_calibration import lost_figure
from support.calibrations import POINTS, RIG, of_control_points, seen
from support.laboratory import camera


@pytest.fixture(scope="module")
def good():
    return of_control_points(seen(RIG, POINTS, 0.05, np.random.default_rng(1)))


def said(figures, severity=None):
    return " ".join(w["what"] for w in figures["warnings"] if severity in (None, w["severity"]))


def test_a_good_calibration_is_called_good_and_says_for_what(good):
    figures = calibration_figures(*good, session="lab")
    assert figures["verdict"]["grade"] == "green"
    sd = figures["precision"]["sd_95_mm"]
    assert f"{sd:.2f}\u00a0mm per axis in 95\u00a0% of the volume" in figures["verdict"]["headline"]
    assert figures["fit"]["points"] == 24
    assert figures["fit"]["left_out_rms_px"] > figures["fit"]["residual_rms_px"]
    assert json.loads(json.dumps(figures, allow_nan=False)) == figures
    text = calibration_summary(figures)
    assert all(name in text for name in RIG.names)


def test_the_verdict_reveals_exchanged_and_repeated_images(good):
    rig, evidence = good
    exchanged = Rig((replace(rig[1], name="cam1"), replace(rig[0], name="cam2"), *rig.cameras[2:]))
    residual = evidence.uv - project_all(exchanged, POINTS)
    figures = calibration_figures(exchanged, replace(evidence, residual=residual))
    assert figures["verdict"]["grade"] == "red"
    assert "cam1, cam2" in said(figures, "red")
    twice = Rig((rig[0], replace(rig[0], name="cam2"), *rig.cameras[2:]), "", rig.volume)
    assert "cam1 and cam2 stand at the same place" in said(calibration_figures(twice, evidence), "red")


def grade(rig, evidence, **changes):
    figures = calibration_figures(rig, replace(evidence, **changes))
    return figures["verdict"]["grade"], said(figures)


def test_every_fault_is_named(good):
    rig, evidence = good
    far = replace(rig, volume=rig.volume + np.array([3000.0, 0, 0]))
    assert "fewer than two cameras" in grade(far, evidence)[1]
    tiny = replace(rig, cameras=tuple(replace(c, t=c.t / 1000) for c in rig), volume=rig.volume / 1000)
    colour, words = grade(tiny, replace(evidence, xyz=evidence.xyz / 1000))
    assert (colour, "apart" in words) == ("red", True)
    loud = evidence.left_out.copy()
    loud[:, 3] *= 30
    assert "do not agree with control point A4" in grade(rig, evidence, left_out=loud)[1]
    assert "the few points that there are decide too much" in grade(rig, evidence, left_out=20 * evidence.left_out)[1]
    one = np.array([5.0, 1, 1, 1])[:, None, None] * evidence.residual * 4
    assert "cam1 fits worse than the others" in grade(rig, evidence, residual=one)[1]
    narrow = np.where((evidence.uv[..., :1] < 640), evidence.uv, np.nan)
    assert "cover only part of the volume" in grade(rig, evidence, uv=narrow)[1]
    assert "is doubtful" in grade(rig, evidence, doubts=("The survey is doubtful.",))[1]
    bent = replace(rig, cameras=tuple(replace(c, distortion=np.zeros(5), cov=np.zeros((15, 15))) for c in rig))
    assert "no lens correction" in grade(bent, evidence)[1]
    assert "states no uncertainty" in grade(bent, evidence)[1]


def test_lengths_that_come_out_wrong_are_named(good):
    rig, evidence = good
    place = np.random.default_rng(0).uniform(*rig.volume, (200, 3))
    known, error = np.array([500.0]), np.where(place[:, :1] > 1600, 8.0, 0.1)
    colour, words = grade(rig, evidence, known=known, lengths=known + error, place=place)
    assert colour == "amber"
    assert "mm too long" in words
    assert grade(rig, evidence, checks=(Check("The arm", 800.0, 790.0),))[0] == "amber"
    assert grade(rig, evidence, checks=(Check("The arm", 800.0, 700.0),))[0] == "red"


def test_a_camera_on_which_much_rests_is_named():
    places = [(4000, -200, 1500), (4000, 200, 1500), (0, 4000, 1500)]
    rig = Rig(tuple(camera(f"c{i}", p) for i, p in enumerate(places)), "", np.array([[-300.0] * 3, [300.0] * 3]) + 900)
    figures = calibration_figures(rig, Evidence("a file"))
    assert "Much rests on camera c2" in said(figures)
    assert figures["cameras"][2]["without"]["ratio_median"] > 2 > figures["cameras"][0]["without"]["ratio_median"]
    two = calibration_figures(Rig(rig.cameras[1:], "", rig.volume), Evidence("a file"))
    assert "There are two cameras" in said(two)
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


def test_every_reason_of_a_judgement_keeps_its_weight(good):
    rig, evidence = good
    reasons = ("Far off.", "A rod hangs elsewhere.", "A camera is loose.", "One marker is not seen.")
    for grade_, allowed, colour in (
        ("bad", ("bad", "bad", "usable", "good"), "red"),
        ("usable", ("usable", "usable", "usable", "good"), "amber"),
    ):
        figures = calibration_figures(rig, replace(evidence, judged=Judgement(grade_, reasons, allowed)))
        weights = {w["what"]: w["severity"] for w in figures["warnings"]}
        weight = {"bad": "red", "usable": "amber", "good": "info"}
        assert [weights[reason] for reason in reasons] == [weight[a] for a in allowed]
        assert figures["verdict"]["grade"] == colour
    well = Judgement("good", ("Near enough.", reasons[3]), ("good", "good"))
    figures = calibration_figures(rig, replace(evidence, judged=well))
    assert figures["verdict"]["grade"] == "green" and "Near enough." in figures["verdict"]["sentences"]
    assert said(figures) == reasons[3]


def test_where_a_lost_camera_is_missed_is_drawn_as_it_is_foretold(good):
    figures = calibration_figures(*good)
    lost, sd = figures["map"]["lost"], figures["precision"]["centroid_sd_px"]
    grid = map_volume(good[0], good[0].volume, centroid_sd=sd)
    k = int(np.argmin(np.abs(grid.axes[2] - lost["level_mm"])))
    assert lost["axis"] == 2 and 0 < k < len(grid.axes[2]) - 1
    assert np.allclose(lost["without_sd_mm"], grid.without[:, :, :, k], rtol=1e-3)
    drawn = lost_figure(figures).data
    assert len(drawn) == len(RIG)
    for c, panel in enumerate(drawn):
        assert np.allclose(panel.z, (grid.without[c] / grid.sd)[:, :, k].T, rtol=2e-3)
