"""The figures of a trial: exact ones, a finding for every known fault, and none for a perfect trial."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import (
    Detections,
    KinemarkError,
    MarkerTrajectory,
    Origin,
    Rig,
    Step,
    Tracks,
    Trajectories,
    Validity,
    make_finding,
)
from kinemark.findings.markers import completeness, in_view, jitter, markers_worn
from kinemark.findings.plain import plain, runs
from kinemark.findings.trial_findings import trial_findings
from kinemark.report import summary, write_quality, write_report
from kinemark.report.formatting import number, percent, some
from kinemark.report.words import advice_of, text_of
from kinemark.track.simultaneous import AmbiguousDecision
from support.captures import RATE, STEPS, capture, empty_capture, judge, ring, walk
from support.findings import found
from support.schema import check_quality


def test_a_perfect_trial_is_green_and_its_figures_are_known():
    rig = ring()
    figures = judge(rig, capture(rig, walk()))
    assert figures["verdict"]["grade"] == "green"
    assert figures["findings"] == []
    assert figures["recording"] == {"first_frame": 1, "frames": 40, "rate_hz": 50.0, "duration_s": 0.8}
    assert figures["points"]["count"] == 120
    assert figures["points"]["per_frame_mean"] == 3
    assert figures["points"]["cameras_per_point"] == {"4": 120}
    assert figures["points"]["residual_rms_px"] < 1e-9
    assert figures["tracks"]["lengths_frames"] == [40, 40, 40]
    assert figures["trajectories"]["completeness_share"] == 1
    assert figures["trajectories"]["sd_per_axis_mean_mm"] == pytest.approx(0.5)
    assert figures["timing"]["total_s"] == 2.5
    assert figures["timing"]["frames_per_s"] == pytest.approx(16)
    shared = judge(rig, capture(rig, walk()), steps=(Step("calibrate", "Wand", {}, "0.1.0", "c" * 64, 30.0), *STEPS))
    assert (shared["timing"]["total_s"], len(shared["timing"]["stages"])) == (2.5, 3)
    camera = figures["cameras"][0]
    assert camera["position_mm"] == pytest.approx([3000, 0, 2000])
    assert camera["detections_per_frame"] == {"mean": 3, "min": 3, "max": 3}
    assert camera["used_share"] == 1
    assert camera["calibration_residual_px"] is None
    assert 2700 / 800 < camera["pixel_at_subject_mm"] < 3300 / 800


def test_a_camera_two_pixels_off_is_found_and_named():
    rig = ring()
    offset = np.zeros((4, 2))
    offset[2] = [1.2, -1.6]
    figures = judge(rig, capture(rig, walk(), offset))
    for key in ("residual_median_px", "residual_rms_px", "residual_95_px"):
        assert figures["cameras"][2][key] == pytest.approx(2.0)
        assert figures["cameras"][1][key] < 1e-9
    assert figures["cameras"][2]["offset_px"] == pytest.approx([1.2, -1.6])
    assert figures["points"]["residual_rms_px"] == pytest.approx(1.0)  # one view in four is 2 px off
    (one,) = found(figures, "camera_disagrees")
    assert one.cameras == ("cam3",) and one.values["residual_px"] == pytest.approx(2.0)
    assert (one.values["offset_u_px"], one.values["offset_v_px"]) == pytest.approx((1.2, -1.6))
    assert figures["verdict"]["findings"] == ["camera_disagrees"]
    assert figures["verdict"]["grade"] == "amber"


def test_equal_residuals_blame_no_camera():
    rig = ring()
    figures = judge(rig, capture(rig, walk(), np.full((4, 2), 0.6)))
    assert not found(figures, "camera_disagrees")


def test_detections_are_counted_used_and_refused():
    rig = ring(3)
    records = capture(rig, walk(markers=4, frames=10))
    seen = records["detections"]
    validity = np.zeros(len(seen), np.uint8)
    validity[:10] = Validity.TOO_SMALL  # in cam1
    detection = records["tracks"].cloud.detection.copy()
    detection[np.isin(detection, np.arange(10))] = -1
    records["detections"] = replace(seen, validity=validity)
    records["tracks"] = Tracks(replace(records["tracks"].cloud, detection=detection), records["tracks"].id)
    figures = judge(rig, records)
    first = figures["cameras"][0]
    assert first["detections"] == 40
    assert first["used_share"] == pytest.approx(0.75)
    assert first["used_of_valid_share"] == 1
    assert first["invalid_share"]["too_small"] == pytest.approx(0.25)
    assert first["invalid_share"]["at_edge"] == 0
    assert figures["points"]["cameras_per_point"] == {"2": 10, "3": 30}
    assert figures["points"]["fewer_than_3_cameras_share"] == pytest.approx(0.25)


def test_gaps_and_completeness():
    xyz = walk(markers=4, frames=100)
    xyz[1, 20:45] = np.nan  # one gap of 25 frames, 0.5 s
    xyz[2, :10] = np.nan  # before the first sample: missing, no gap
    xyz[3, 50:52] = xyz[3, 60:61] = np.nan  # two short gaps
    rig = ring()
    figures = judge(rig, capture(rig, xyz))
    together, markers = figures["trajectories"], figures["trajectories"]["markers"]
    assert [m["gaps"] for m in markers] == [0, 1, 0, 2]
    assert [m["longest_gap_frames"] for m in markers] == [0, 25, 0, 2]
    assert [m["missing_samples"] for m in markers] == [0, 25, 10, 3]
    assert together["gaps"] == 3
    assert together["longest_gap_s"] == pytest.approx(0.5)
    assert together["completeness_share"] == pytest.approx(1 - 38 / 400)
    assert markers[2]["first_seen_s"] == pytest.approx(0.2)
    assert [one.markers for one in found(figures, "long_gaps")] == [("m1",)]


def test_in_view_leaves_out_the_way_into_the_volume():
    xyz = walk(markers=4, frames=50)
    xyz[:2, :10] = np.nan
    xyz[1, 45:] = np.nan
    trajectories = capture(ring(), xyz)["trajectories"]
    assert in_view(trajectories) == (10, 50)


@pytest.mark.parametrize("names", [None, [f"*{m + 1}" for m in range(4)]], ids=["named", "unnamed"])
def test_a_subject_that_is_away_for_a_while_is_not_missing_then(names):
    xyz, rig = walk(markers=4, frames=90), ring()
    xyz[:, 30:60] = np.nan
    figures = judge(rig, capture(rig, xyz, names=names))
    assert figures["trajectories"]["in_view_runs"] == [[0, 30], [60, 90]]
    assert figures["trajectories"]["completeness_in_view_share"] == 1
    assert not found(figures, "incomplete")
    assert "(frames 1–30, 61–90), 100" in summary(figures)


def test_markers_that_are_lost_while_the_cameras_see_them_are_missing():
    xyz, rig = walk(markers=4, frames=90), ring()
    records = capture(rig, xyz)
    lost = xyz.copy()
    lost[:, 30:60] = np.nan
    there = np.isfinite(lost[:, :, 0])[records["tracks"].id, np.repeat(np.arange(90), 4)]
    tracks = Tracks(records["tracks"].cloud.keep(there), records["tracks"].id[there])
    figures = judge(rig, {**capture(rig, lost), "detections": records["detections"], "tracks": tracks})
    assert figures["trajectories"]["completeness_in_view_share"] == pytest.approx(2 / 3)
    assert [one.severity for one in found(figures, "incomplete")] == ["red"]


@pytest.mark.parametrize("found_of_ten", [1, 4, 6])
def test_completeness_is_not_known_where_most_images_are_left_over(found_of_ten):
    rig, xyz = ring(), walk(markers=10)
    records = capture(rig, xyz)
    own = records["tracks"].id < found_of_ten
    tracks = Tracks(records["tracks"].cloud.keep(own), records["tracks"].id[own])
    paths = tuple(replace(path, name=f"*{m + 1}") for m, path in enumerate(records["trajectories"]))[:found_of_ten]
    trajectories = replace(records["trajectories"], paths=paths)
    figures = judge(rig, {**records, "tracks": tracks, "trajectories": trajectories})
    check_quality(figures)
    kinds = [one["kind"] for one in figures["verdict"]["statements"]]
    assert ("completeness_unknown" in kinds) == (found_of_ten < 5) and ("completeness" in kinds) == (found_of_ten > 5)
    assert (figures["trajectories"]["completeness_in_view_share"] is None) == (found_of_ten < 5)
    assert ("is not known: only" in summary(figures)) == (found_of_ten < 5)


@pytest.mark.parametrize("prefix", ["m", "*"])
@pytest.mark.parametrize(("markers", "length"), [(10, 4), (20, 2), (6, 30)])
def test_markers_that_are_never_there_together_are_reported(tmp_path, prefix, markers, length):
    frames = max(markers * length, 12 * length)
    xyz = np.full((markers, frames, 3), np.nan)
    for m in range(markers):
        xyz[m, m * length : (m + 1) * length] = walk(1, frames)[0, m * length : (m + 1) * length]
    if length == 2:
        xyz[2:] = np.nan  # in one of ten frames there is any marker
    rig = ring()
    records = capture(rig, xyz, names=[f"{prefix}{m + 1}" for m in range(markers)])
    figures = judge(rig, records)
    assert 0 <= figures["trajectories"]["completeness_of_found_share"] <= 1
    assert markers_worn(records["trajectories"]) >= 1
    assert all(isinstance(advice_of(one), str) for one in figures["findings"]) and summary(figures)
    write_quality(tmp_path / "quality.json", figures)


def test_filled_samples_are_told_apart():
    rig = ring()
    records = capture(rig, walk())
    path = records["trajectories"].paths[0]
    origin = path.origin.copy()
    origin[5:25] = Origin.FILLED
    origin[30] = Origin.EDITED
    paths = (replace(path, origin=origin), *records["trajectories"].paths[1:])
    figures = judge(rig, {**records, "trajectories": replace(records["trajectories"], paths=paths)})
    marker = figures["trajectories"]["markers"][0]
    assert (marker["filled_samples"], marker["edited_samples"], marker["longest_fill_frames"]) == (20, 1, 20)
    assert [one.markers for one in found(figures, "much_filled")] == [("m0",)]


def test_volume_given_and_spanned():
    rig, xyz = ring(volume=[[0, -500, 0], [150, 500, 2000]]), walk(markers=1, frames=31)
    figures = judge(rig, capture(rig, xyz))
    assert figures["volume"]["given_mm"] == [[0, -500, 0], [150, 500, 2000]]
    assert figures["volume"]["spanned_mm"] == pytest.approx(np.array([xyz[0].min(0), xyz[0].max(0)]))
    assert figures["volume"]["samples_outside_given_share"] == pytest.approx(15 / 31)
    assert found(figures, "outside_volume")[0].values["samples_share"] == pytest.approx(15 / 31)


def test_jitter_is_the_noise_that_was_added_and_filled_samples_have_none():
    noise = np.random.default_rng(3).normal(0, 0.7, (20000, 3))
    noise[5000:] = 0
    path = MarkerTrajectory.measured("m", walk(1, 20000)[0] + noise)
    assert jitter(path) < 0.01
    origin = np.where(np.arange(20000) < 5000, Origin.MEASURED, Origin.FILLED)
    assert jitter(replace(path, origin=origin)) == pytest.approx(0.7, rel=0.05)


def test_the_deviation_of_positions_is_told_in_noise_and_what_stays():
    rig, xyz = ring(), walk(frames=2000)
    shown = {}
    for noise in (0.3, 1.2):  # the capture states 0.5
        noisy = xyz + noise * np.random.default_rng(5).normal(size=xyz.shape)
        figures = judge(rig, capture(rig, noisy))
        markers = figures["trajectories"]
        assert markers["jitter_median_mm"] == pytest.approx(noise, rel=0.1)
        assert markers["steady_sd_mm"] == pytest.approx(math.sqrt(max(0.25 - markers["jitter_median_mm"] ** 2, 0)))
        shown[noise] = summary(figures)
        assert [one.severity for one in found(figures, "noise_above_deviation")] == ["amber"] * (noise > 0.5)
    assert "0.50 mm per axis on average, of which 0.30 mm is noise" in shown[0.3].replace("\u00a0", " ")
    assert "the positions tremble by 1.2" in shown[1.2].replace("\u00a0", " ")


def scaled(figures, by):
    """The cameras stand as by a calibration in another unit."""
    for camera in figures["cameras"]:
        camera["position_mm"] = by * np.asarray(camera["position_mm"])


@pytest.mark.parametrize(
    ("change", "kind", "severity", "about"),
    [
        (lambda q: q["cameras"][1].update(detections=0), "camera_sees_nothing", "amber", "cam2"),
        (lambda q: q["cameras"][1].update(used_of_valid_share=0.3), "detections_unused", "amber", "cam2"),
        (lambda q: q["cameras"][1].update(calibration_residual_px=7.0), "calibration_residual_high", "amber", "cam2"),
        (lambda q: q["points"].update(fewer_than_3_cameras_share=0.8), "two_camera_points", "amber", None),
        (lambda q: q["points"].update(residual_median_px=1.5), "cameras_agree_poorly", "amber", None),
        (lambda q: q["points"].update(residual_median_px=4.0), "cameras_agree_poorly", "red", None),
        (lambda q: q["points"].update(in_a_track_share=0.5), "points_in_no_track", "amber", None),
        (lambda q: q["cameras"][0].update(focal_px=[800.0, 600.0]), "pixels_not_square", "amber", "cam1"),
        (lambda q: scaled(q, 1e-3), "scale_impossible", "red", None),
        (lambda q: scaled(q, 1e3), "scale_impossible", "red", None),
        (lambda q: q["trajectories"].update(completeness_of_found_share=0.9), "incomplete", "amber", None),
        (lambda q: q["trajectories"].update(completeness_of_found_share=0.5), "incomplete", "red", None),
        (lambda q: q["trajectories"]["markers"][0].update(name="*1"), "unnamed_trajectories", "info", None),
        (lambda q: q["trajectories"]["markers"][0].update(samples=0), "markers_never_seen", "amber", "m0"),
        (lambda q: q["trajectories"]["markers"][0].update(sd_per_axis_mean_mm=4.0), "markers_uncertain", "amber", "m0"),
    ],
)
def test_every_fault_is_named_and_says_what_to_do(change, kind, severity, about):
    rig = ring()
    figures = judge(rig, capture(rig, walk()))
    change(figures)
    findings = trial_findings(figures)
    assert [(one.kind, one.severity) for one in findings] == [(kind, severity)]
    assert about is None or about in findings[0].cameras + findings[0].markers
    assert advice_of(findings[0]).endswith(".")


def test_what_the_stages_found_is_among_the_findings():
    rig = ring()
    noted = make_finding("frame_rate_contradicted", cameras=["cam1"], rate_hz=50.0, stated_hz_list=[25.0])
    figures = judge(rig, capture(rig, walk()), findings=[noted])
    assert found(figures, "frame_rate_contradicted") == [noted]
    assert figures["verdict"]["grade"] == "amber"


def test_a_camera_that_was_diagnosed_is_not_blamed_twice():
    rig = ring()
    figures = judge(rig, capture(rig, walk()))
    figures["cameras"][2]["used_of_valid_share"] = 0.1
    moved = make_finding("camera_moved", cameras=[rig.names[2]], frames=[(4, 39)])
    assert [one.kind for one in trial_findings(figures)] == ["detections_unused"]
    assert [one.kind for one in trial_findings(figures, [moved])] == ["camera_moved"]


def test_where_most_cameras_were_diagnosed_what_is_left_is_not_what_was_seen():
    """Five cameras in a ring of wrong order: each fits nothing, and what two of them make by chance was usable."""
    rig = ring()
    figures = judge(rig, capture(rig, walk()))
    for camera in figures["cameras"]:
        camera["used_of_valid_share"] = 0.2
    noted = [make_finding("camera_fits_nothing", cameras=[name], left_out=True) for name in rig.names]
    first = trial_findings(figures, noted)[0]
    assert (first.kind, first.severity) == ("detections_unused", "red")
    assert {one.kind for one in trial_findings(figures, noted[:2])} == {"detections_unused", "camera_fits_nothing"}


def test_images_of_points_outside_the_volume_blame_no_calibration():
    rig = ring()
    figures = judge(rig, capture(rig, walk()))
    for camera in figures["cameras"]:
        camera["used_of_valid_share"] = 0.2
    left = {"points": 900, "margin_mm": 100.0, "least_mm_list": [0, 0, 0], "greatest_mm_list": [1, 1, 1], "unit": "m"}
    for share, kinds in (0.8, []), (0.1, ["detections_unused"]):
        outside = make_finding("points_dropped_outside", points_share=share, **left)
        assert {one.kind for one in trial_findings(figures, [outside])} == {"points_dropped_outside", *kinds}


def test_a_camera_that_saw_nothing_is_told_once():
    rig = ring()
    figures = judge(rig, capture(rig, walk()))
    figures["cameras"][2]["detections"] = 0
    noted = make_finding("camera_without_images", cameras=[rig.names[2]])
    assert [one.kind for one in trial_findings(figures, [noted])] == ["camera_sees_nothing"]


def odd_cases():
    rig = ring()
    unknown = Rig(tuple(replace(c, size=np.zeros(2), cov=np.full((15, 15), np.nan)) for c in ring()))
    missing = walk()
    missing[1] = np.nan
    return {
        "nothing seen": (rig, empty_capture(rig, 30)),
        "no frames": (rig, empty_capture(rig, 0)),
        "one frame": (rig, capture(rig, walk(frames=1))),
        "a marker never there": (rig, capture(rig, missing)),
        "no sample at all": (rig, capture(rig, np.full((2, 5, 3), np.nan))),
        "unknown size and covariance": (unknown, capture(unknown, walk(), sd=float("nan"))),
        "more cameras calibrated than used": (ring(5), capture(Rig(ring(5).cameras[1:]), walk())),
        "half a volume": (ring(volume=[[0, 0, 0], [np.nan] * 3]), capture(rig, walk())),
        "many cameras": (ring(17), capture(ring(17), walk())),
    }


@pytest.mark.parametrize("name", odd_cases())
def test_odd_trials_give_valid_json_text_and_page(name, tmp_path):
    rig, records = odd_cases()[name]
    figures = judge(rig, records)
    write_quality(tmp_path / "quality.json", figures)
    text = (tmp_path / "quality.json").read_text(encoding="utf-8")
    assert json.loads(text, parse_constant=lambda constant: pytest.fail(constant)) == figures
    check_quality(figures)
    assert figures["verdict"]["headline"] in summary(figures)
    write_report(tmp_path / "report.html", quality=figures, rig=rig, **records)
    assert len(figures["cameras"]) == len(records["detections"].cameras)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["quality.json", "report.html"]


@pytest.mark.parametrize("name", ["nothing seen", "no frames", "no sample at all"])
def test_a_trial_without_trajectories_is_red(name):
    rig, records = odd_cases()[name]
    assert judge(rig, records)["verdict"]["grade"] == "red"


def test_records_that_do_not_belong_together_are_refused():
    rig = ring()
    records = capture(rig, walk())
    with pytest.raises(ValueError, match="cam4"):
        judge(Rig(rig.cameras[:3]), records)
    fewer = Detections.build(rig.names[:2], RATE, np.zeros((2, 40)), np.zeros((0, 2)))
    with pytest.raises(ValueError, match="wanted the 2 of detections"):
        judge(rig, {**records, "detections": fewer})
    with pytest.raises(ValueError, match="only 60"):
        judge(rig, {**records, "detections": records["detections"].keep(np.arange(480) % 8 == 0)})


def test_a_place_that_cannot_be_written_is_reported_and_left_alone(tmp_path):
    (tmp_path / "quality.json").mkdir()
    rig = ring()
    with pytest.raises(KinemarkError, match="cannot be written"):
        write_quality(tmp_path / "quality.json", judge(rig, capture(rig, walk())))
    assert [p.name for p in tmp_path.iterdir()] == ["quality.json"]


def test_numbers_as_readers_want_them():
    assert number(None) == "–"
    assert number(1234567.0, 0) == "1\u00a0234\u00a0567"
    assert number(-0.001, 2) == "0.00"
    assert number(-1.5, 1) == "-1.5"
    assert number(50.0) == "50"
    assert [percent(x) for x in (None, 0.0, 1.0, 0.9999, 0.0001, 0.1234)] == [
        "–", "0\u00a0%", "100\u00a0%", "> 99.9\u00a0%", "< 0.1\u00a0%", "12.3\u00a0%",
    ]  # fmt: skip
    assert some("marker", ["a"]) == "marker a"
    assert some("marker", list("abcdefgh")) == "markers a, b, c, d, e, f and 2 more"


def test_plain_is_json_without_nan():
    value = {"a": np.array([1.0, np.nan]), 3: (np.int64(2), np.bool_(True), math.inf), "e": Origin.FILLED, "p": object}
    assert json.loads(json.dumps(plain(value), allow_nan=False)) == {
        "a": [1.0, None], "3": [2, True, None], "e": 2, "p": "<class 'object'>",
    }  # fmt: skip


def test_runs_of_true_values():
    assert runs(np.array([1, 1, 0, 0, 1, 0, 1], bool)) == [(0, 2), (4, 5), (6, 7)]


def pieces(at):
    """Trajectories of one marker each, seen only in the frames given, over 100 frames."""
    paths = []
    for k, (first, stop) in enumerate(at):
        xyz = np.full((100, 3), np.nan)
        xyz[first:stop] = [k, 0, 0]
        paths.append(MarkerTrajectory.measured(f"*{k + 1}", xyz))
    return Trajectories(tuple(paths), 100.0)


def test_unlabelled_pieces_are_counted_as_the_markers_that_they_make():
    """Two markers in five pieces are two markers, complete but for what lies between the pieces."""
    broken = pieces([(0, 100), (0, 20), (25, 50), (50, 75), (80, 100)])
    assert markers_worn(broken) == 2
    assert completeness(broken) == pytest.approx(190 / 200)
    named = Trajectories(tuple(replace(p, name=p.name[1:]) for p in broken), 100.0)
    assert markers_worn(named) == 5
    assert completeness(named) == pytest.approx(190 / 500)


def test_a_short_piece_that_was_left_without_a_name_is_no_marker_that_is_missing():
    """As a ghost beside a body that was named; what is there in all frames is one, with a name or without."""
    there = np.ones((7, 100), bool)
    there[0, 90:] = there[5, :20] = there[5, 33:] = False
    xyz = np.where(there[..., None], 1.0 + np.arange(7)[:, None, None], np.nan) * np.ones(3)
    names = ("A", "B", "C", "D", "E", "*1", "*2")
    beside = Trajectories(tuple(map(MarkerTrajectory.measured, names, xyz)), 50.0)
    assert markers_worn(beside) == 6
    assert completeness(beside) == pytest.approx(590 / 600)
    assert markers_worn(beside.select(names[:6])) == 5
    assert completeness(beside.select(names[:6])) == pytest.approx(490 / 500)


def test_a_piece_without_a_name_where_a_named_marker_is_missing_is_no_other_marker():
    """It is that one's: not more are worn than are there at once."""
    there = np.ones((6, 100), bool)
    there[4, :60] = there[5, 60:] = False
    xyz = np.where(there[..., None], 1.0 + np.arange(6)[:, None, None], np.nan) * np.ones(3)
    beside = Trajectories(tuple(map(MarkerTrajectory.measured, ("A", "B", "C", "D", "E", "*1"), xyz)), 50.0)
    assert markers_worn(beside) == 5
    assert completeness(beside) == pytest.approx(440 / 500)


@pytest.mark.parametrize(("frames", "grade"), [(1, None), (39, "amber"), (300, "red")])
def test_tracks_that_came_near_for_long_are_never_green(frames, grade):
    """Of 1200 points; either of two tracks could have had the other's images for so many frames, two points a frame."""
    rig = ring()
    near = AmbiguousDecision("swap", 0, frames - 1, (0, 1), "came_near", {"distance_mm": 3.0})
    short = AmbiguousDecision("swap", 0, 399, (0, 1), "found_again", {"sd_mm": 12.0})
    figures = judge(rig, capture(rig, walk(frames=400)), ambiguous_decisions=[near, near, short])
    kinds = {row["kind"]: row["severity"] for row in figures["findings"]}
    assert kinds.get("tracks_confusable") == grade
    assert all(
        f["values"]["points_share"] == 2 * frames / 1200 for f in figures["findings"] if "confusable" in f["kind"]
    )
    assert grade is None or figures["verdict"]["grade"] == grade


def test_tracks_that_continue_earlier_ones_are_named_in_words():
    said = make_finding("tracks_continue", tracks=2, earlier_list=["*3", "*7"], later_list=["*40", "*41"])
    assert "*3" in text_of(said) and "*41" in text_of(said) and "2 tracks" in text_of(said)


@pytest.mark.parametrize("known", [True, False])
def test_errors_are_not_called_the_calibration_s_where_it_states_none(known):
    said = text_of(make_finding("position_deviation", sd_mm=0.07, noise_mm=0.04, calibration_known=known))
    assert "the rest is of errors that stay" in said
    assert ("as the calibration's" in said, "by the images alone" in said) == (known, not known)


@pytest.mark.parametrize(("pieces_each", "grade"), [(1, None), (2, "amber"), (22, "red")])
def test_many_more_tracks_than_markers_are_never_good(pieces_each, grade):
    """341 tracks of 15 markers were called good to use."""
    rig, whole = ring(), walk(frames=220)
    cut = np.full((3, pieces_each, 220, 3), np.nan)
    for k, frames in enumerate(np.array_split(np.arange(220), pieces_each)):
        cut[:, k, frames] = whole[:, frames]
    names = [f"*{k + 1}" for k in range(3 * pieces_each)]
    figures = judge(rig, capture(rig, cut.reshape(-1, 220, 3), names=names))
    kinds = {row["kind"]: row["severity"] for row in figures["findings"]}
    assert kinds.get("tracks_broken") == grade
    assert grade is None or figures["verdict"]["grade"] == grade
