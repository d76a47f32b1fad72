"""What is said of filled trials, and kept of them: every sample that is replaced, every gap, what nobody knows."""

import re
from dataclasses import replace

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import Fills, MarkerTrajectory, Origin, same
from kinemark.engine.fill_files import fill_file, filled_text
from kinemark.engine.settings.method_tables import whole_of
from kinemark.fill import Cubic, FilledGap, Filling, Gap, Linear, Prediction, Rays, RigidBody, fill, fill_recording
from kinemark.fill.filled_gap import Filled
from kinemark.fill.judge.expected_error import SLOPE, MeasuredErrors
from kinemark.fill.judge.hold_out import HoldOutGap, HoldOutResult
from kinemark.findings.gaps import filling_figures
from kinemark.io.c3d import read_c3d, write_c3d
from kinemark.report.figures_gaps import gap_figure
from kinemark.report.filling_page import filling_page, gap_table
from kinemark.report.terminal_summary import filling_summary
from support.filling import GAP, segment, swaying, trial_of, with_gap
from support.findings import found
from support.laboratory import observe, ring
from support.schema import check_findings

QUICK = {"method": Linear(), "name": "linear", "limit_mm": np.inf}


# Replaced samples


def trimmed_file(tmp_path):
    """A file whose marker is off by 25 mm in the two frames before its gap."""
    motion, _ = swaying()
    xyz = motion.xyz.copy()
    xyz[0, 98:100] += 25.0
    xyz[0, 100:130] = np.nan
    write_c3d(tmp_path / "in.c3d", trial_of(xyz))
    return tmp_path / "in.c3d", motion.xyz


def test_replaced_samples_are_told_drawn_and_kept_on_request(tmp_path):
    source, truth = trimmed_file(tmp_path)
    done = fill_file(source, tmp_path / "out.c3d", method=RigidBody(), trim=5, report=tmp_path / "out.html")
    (gap,) = done.figures["list"]
    assert gap["suspicious"] == [] and done.figures["suspicious"] == 0
    assert gap["trimmed"] == [103, 104] and done.figures["replaced"] == 2  # the file counts from 5
    assert np.abs(read_c3d(tmp_path / "out.c3d").trajectories["A"].xyz[98:100] - truth[0, 98:100]).max() < 3
    (replaced,) = found(done.figures, "samples_replaced")
    assert (replaced.values["samples"], replaced.values["gaps"]) == (2, 1)
    assert done.figures["verdict"]["grade"] == "green"  # a note is no doubt
    page = (tmp_path / "out.html").read_text()
    assert page.count("<circle") == 6 and "2 samples measured beside 1 gap" in filled_text({source: done})


def test_nothing_measured_is_replaced_by_default_and_what_is_suspicious_is_listed(tmp_path):
    source, _ = trimmed_file(tmp_path)
    kept = fill_file(source, tmp_path / "kept.c3d", method=RigidBody(), limit_mm=np.inf, report=tmp_path / "kept.html")
    (gap,) = kept.figures["list"]
    assert (kept.figures["replaced"], gap["trimmed"]) == (0, [])
    assert gap["suspicious"] == [103, 104] and kept.figures["suspicious"] == 2  # the file counts from 5
    (listed,) = found(kept.figures, "samples_suspicious")
    assert (listed.markers, listed.frames) == (("A",), ((103, 104),))
    assert dict(listed.values) == {"samples": 2, "gaps": 1, "where_list": ("A 103–104",)}
    page = (tmp_path / "kept.html").read_text()
    assert "A 103–104" in filled_text({source: kept}) and "A 103–104" in page
    assert page.count("<circle") == 6 and "--trim 5 (trim = 5 in a session)" in page
    check_findings(kept.figures)
    before = read_c3d(source).trajectories
    for stored in (kept.trial.trajectories, read_c3d(tmp_path / "kept.c3d").trajectories):
        for path, was in zip(stored, before, strict=True):
            measured = was.origin == Origin.MEASURED
            assert path.xyz[measured].tobytes() == was.xyz[measured].tobytes()
            assert (path.origin[measured] == Origin.MEASURED).all()


def test_how_far_samples_are_off_that_a_fill_does_not_follow_is_said_beside_them():
    before = trial_of(with_gap(segment(120))).trajectories
    filled = fill(before, method=Linear(), limit_mm=np.inf)
    (gap,) = filled.gaps
    gap = replace(gap, suspicious=(gap.start - 2, gap.start - 1, gap.stop), off_mm=12.34)
    figures = filling_figures(filled._replace(gaps=(gap,)), before, source="s", method="l", limit_mm=np.inf)
    check_findings(figures)
    (listed,) = found(figures, "samples_suspicious")
    first, last = gap.start + before.first_frame, gap.stop + before.first_frame
    name = f"{gap.marker} "
    assert listed.values["where_list"] == (
        f"{name}{first - 2}–{first - 1} (up to 12.3 mm off)",
        f"{name}{last} (up to 12.3 mm off)",
    )


def test_trim_is_the_same_in_a_session_in_python_and_on_the_command_line(tmp_path):
    source, _ = trimmed_file(tmp_path)
    assert whole_of("fill", {"method": "linear", "trim": 0}).trim == 0 and whole_of("fill", {"trim": 5}).trim == 5
    assert whole_of("fill", {}).trim == Filling().trim == 0
    assert whole_of("fill", {"method": "linear"}).name == "linear" and whole_of("fill", {}).name == "auto"
    for bad in ({"trim": -1}, {"trim": "x"}, {"limit_mm": np.nan}):
        with pytest.raises(ValueError):
            whole_of("fill", bad)
    app(["fill", str(source), "-o", str(tmp_path / "o.c3d"), "--method", "rigid_body", "--trim", "0"],
        result_action="return_value")  # fmt: skip
    app(["fill", str(source), "-o", str(tmp_path / "d.c3d"), "--method", "rigid_body"], result_action="return_value")
    app(["fill", str(source), "-o", str(tmp_path / "t.c3d"), "--method", "rigid_body", "--trim", "5"],
        result_action="return_value")  # fmt: skip
    filled = {name: read_c3d(tmp_path / f"{name}.c3d").trajectories["A"].origin == Origin.FILLED for name in "odt"}
    assert np.flatnonzero(filled["o"]).tolist() == np.flatnonzero(filled["d"]).tolist() == list(range(100, 130))
    assert np.flatnonzero(filled["t"]).tolist() == list(range(98, 130))


# What is said


def said_of(xyz, **options):
    before = trial_of(xyz).trajectories
    filled = fill(before, method=options.pop("method", Linear()), **options)
    limit = options.get("limit_mm", 20.0)
    figures = filling_figures(filled, before, source="s", method="linear", limit_mm=limit)
    check_findings(figures)
    return figures


def test_missing_samples_are_counted_once_each():
    xyz = with_gap(segment(120))
    xyz[1, :7], xyz[1, 110:], xyz[2] = np.nan, np.nan, np.nan
    figures = said_of(xyz, limit_mm=0.001)
    assert figures["beyond"] == 17 and figures["missing_samples"] == figures["missing_after"] == 20 + 17 + 120
    assert figures["never_seen"] == ["C"] and figures["open"] == 1 and figures["filled"] == 0
    ends = said_of(xyz, limit_mm=np.inf, ends=True, method=RigidBody())
    assert ends["filled"] == 3 and ends["beyond"] == 0 and ends["missing_after"] == 120
    before = trial_of(xyz).trajectories
    nameless = replace(before, paths=(*before.paths[:2], replace(before.paths[0].only(np.arange(120) > 60), name="*1")))
    filled = fill(nameless, method=RigidBody(), limit_mm=np.inf, ends=True)
    figures = filling_figures(filled, nameless, source="s", method="rigid_body", limit_mm=np.inf)
    assert figures["beyond"] == 0  # of a track that is no marker's nobody wants the ends
    closed = said_of(xyz, limit_mm=1e-6, ends=True, method=RigidBody())
    assert closed["open"] == 3 and closed["beyond"] == 0


def test_a_trial_without_any_sample_is_not_called_good():
    figures = said_of(np.full((4, 50, 3), np.nan))
    assert figures["verdict"]["grade"] == "red" and figures["verdict"]["statements"][0]["kind"] == "no_marker_seen"
    assert said_of(segment(50))["verdict"]["grade"] == "green"
    one = segment(50)
    one[3, 5:] = np.nan
    assert said_of(one)["much_filled"] == []
    holed = one.copy()
    holed[2, 10:30] = np.nan
    assert said_of(holed, limit_mm=np.inf, method=Cubic())["much_filled"] == ["C"]
    one[3] = np.nan
    assert said_of(one)["verdict"]["grade"] == "amber"


def test_a_gap_with_a_great_standard_deviation_asks_for_a_look():
    before = trial_of(with_gap(segment(120))).trajectories
    wide = before.paths[0].xyz.copy()
    wide[GAP] = 0.0
    path, cov = before.paths[0], np.full((120, 3, 3), np.nan)
    cov[GAP] = np.diag([1.0, 400.0, 25.0])
    origin = np.where(np.isnan(path.xyz[:, 0]), Origin.FILLED, path.origin)
    after = replace(before, paths=(replace(path, xyz=wide, cov=cov, origin=origin), *before.paths[1:]))
    gap = FilledGap("A", GAP.start, GAP.stop, "body", 2.0)
    figures = filling_figures(Filled(after, (gap,)), before, source="s", method="body", limit_mm=20.0)
    assert figures["list"][0]["sd_max_mm"] == pytest.approx(20)
    assert figures["verdict"]["grade"] == "amber"
    assert found(figures, "gaps_uncertain")[0].values["max_mm"] == pytest.approx(20)


def test_a_fill_that_no_test_could_judge_is_said_to_be_unknown():
    before = trial_of(with_gap(segment(120))).trajectories
    filled = fill(before, method=Linear(), limit_mm=np.inf)
    (gap,) = filled.gaps
    judged, unjudged = replace(gap, start=0, stop=1), replace(gap, expected_mm=np.inf)
    figures = filling_figures(filled._replace(gaps=(judged, unjudged)), before, source="s", method="l", limit_mm=np.inf)
    assert figures["unknown"] == 1 and figures["expected_max_mm"] == gap.expected_mm
    assert figures["verdict"]["grade"] == "amber" and found(figures, "gaps_untested")[0].values["gaps"] == 1
    assert "expected –" in filling_page(figures=figures, trajectories=filled.trajectories, before=before)


def test_the_page_draws_the_band_and_says_why_only_where_a_gap_is_open():
    before = trial_of(with_gap(segment(120))).trajectories
    for limit, words in ((np.inf, False), (0.001, True)):
        filled = fill(before, method=Linear(), limit_mm=limit)
        figures = filling_figures(filled, before, source="<s>", method="linear", limit_mm=limit)
        page = filling_page(figures=figures, trajectories=filled.trajectories, before=before)
        assert ("why it is open" in page) == words and ("<polygon" in page) != words
        assert "&lt;s&gt;" in page and "<s>" not in page and "nan" not in page.split("<main>")[1].lower()


def test_frames_of_open_gaps_are_told_as_one_or_as_a_stretch():
    before = trial_of(with_gap(segment(120))).trajectories
    (gap,) = (filled := fill(before, method=Linear(), limit_mm=np.inf)).gaps
    left = replace(gap, method="", state="left_open")
    gaps = (left, replace(left, stop=left.start + 1))
    figures = filling_figures(filled._replace(gaps=gaps), before, source="s", method="linear", limit_mm=np.inf)
    first, last = gap.start + before.first_frame, gap.stop - 1 + before.first_frame
    text = filling_summary(figures)
    assert f"frames {first}–{last}: somebody" in text and f"frame {first}: somebody" in text
    table = gap_table(figures["list"], np.inf)
    assert [row[1:3] for row in table.rows] == [[f"{first}–{last}", str(gap.stop - gap.start)], [f"{first}", "1"]]
    assert "replaced" not in table.head and table.rows[0][-1] == "somebody chose to leave it open"


def test_open_gaps_and_the_least_certain_are_drawn_first():
    before = trial_of(with_gap(segment(120))).trajectories
    (gap,) = (filled := fill(before, method=Linear(), limit_mm=np.inf)).gaps
    gaps = (
        replace(gap, expected_mm=1.25),
        replace(gap, expected_mm=7.25),
        replace(gap, method="", state="not_predicted", reason="because of this", expected_mm=np.nan),
    )
    figures = filling_figures(filled._replace(gaps=gaps), before, source="s", method="l", limit_mm=20.0)
    drawn = filling_page(figures=figures, trajectories=filled.trajectories).split('<section id="drawings">')[1]
    assert drawn.index("because of this") < drawn.index("expected 7.2") < drawn.index("expected 1.2")


def test_a_replaced_sample_far_away_leaves_the_curve_visible():
    before = fill(trial_of(with_gap(segment(120))).trajectories, method=Linear(), limit_mm=np.inf).trajectories
    plain = gap_figure(before, "A", 40, 60)
    far = gap_figure(before, "A", 40, 60, replaced={45: np.full(3, 1e9)})
    near = gap_figure(before, "A", 40, 60, replaced={45: before["A"].xyz[45] + 300})
    assert bare(far) == plain and far.count("<circle") == 3
    assert bare(near) != plain  # the panel makes room for it


def test_each_filled_run_has_a_band_of_its_own_that_is_as_wide_as_it_says():
    xyz = with_gap(segment(120))
    xyz[0, 66] = np.nan
    before = trial_of(xyz).trajectories
    after = fill(before, method=Linear(), limit_mm=np.inf).trajectories
    bands = re.findall('<polygon points="([^"]*)"', gap_figure(after, "A", 40, 60))
    assert len(bands) == 6  # two runs, three axes
    x = [np.array([p.split(",") for p in band.split()], float) for band in bands]
    assert x[0][:, 0].max() < x[1][:, 0].min()  # nothing over what was measured in between
    wide = gap_figure(replace(after, paths=tuple(replace(p, cov=4 * p.cov) for p in after)), "A", 40, 60)
    assert wide != gap_figure(after, "A", 40, 60)
    top, bottom = x[0][: len(x[0]) // 2, 1], x[0][len(x[0]) // 2 :, 1][::-1]
    low, high = (float(t) for t in reversed(re.findall(r">(-?[0-9]+)</text>", gap_figure(after, "A", 40, 60))[:2]))
    sd = np.sqrt(after["A"].cov[40:60, 0, 0].max())
    assert (bottom - top).max() * (high - low) / 88 == pytest.approx(2 * 1.96 * sd, rel=0.05)


def bare(svg):
    """A drawing without its dots."""
    return re.sub("<circle[^>]*>", "", svg)


def test_a_gap_that_the_method_finds_harder_than_its_tests_is_expected_to_be_worse():
    """Nothing is learnt of how true claims are from tests with like ones: they count by the usual slope."""
    test = HoldOutGap(0, 0, Gap(0, 10, 15), (0, 5), True)
    results = HoldOutResult(test, np.full((5, 3), 1.0), np.tile(np.eye(3), (5, 1, 1)), np.ones(5))
    measured = MeasuredErrors([results, results])
    for claim, ratio in ((1.0, 1.0), (4.0, 4**SLOPE), (0.25, 0.25**SLOPE)):
        prediction = Prediction(np.zeros((5, 3)), claim**2 * np.tile(np.eye(3), (5, 1, 1)))
        assert measured.expect(prediction, np.ones(2))[0] == pytest.approx(ratio * 3**0.5)
        assert measured.expect(prediction, np.ones(2))[1] == pytest.approx(3**0.5)


# What a session keeps


def test_fills_taken_off_and_put_on_again_are_the_same():
    before = trial_of(with_gap(segment(120))).trajectories
    after = fill(before, method=RigidBody(), limit_mm=np.inf).trajectories
    fills = Fills.between(before, after)
    assert len(fills.marker) >= 20 and same(fills.on(before), after)
    assert same(Fills.between(before, before).on(before), before)
    with pytest.raises(ValueError, match="reach beyond"):
        fills.on(replace(before, paths=()))
    with pytest.raises(ValueError, match="reach beyond"):
        fills.on(replace(before, paths=before.paths[: fills.marker.max()]))
    last = fills.frame.max()
    cut = tuple(MarkerTrajectory.measured(p.name, p.xyz[:last]) for p in before)
    with pytest.raises(ValueError, match="reach beyond"):
        fills.on(replace(before, paths=cut))


def test_what_was_filled_before_is_no_new_fill():
    once = fill(trial_of(with_gap(segment(120))).trajectories, method=RigidBody(), limit_mm=np.inf).trajectories
    xyz, origin = once.paths[1].xyz.copy(), once.paths[1].origin.copy()
    xyz[5:9], origin[5:9] = np.nan, Origin.MISSING
    holed = replace(once, paths=(once.paths[0], replace(once.paths[1], xyz=xyz, origin=origin), *once.paths[2:]))
    twice = fill(holed, method=RigidBody(), limit_mm=np.inf).trajectories
    fills = Fills.between(holed, twice)
    assert set(fills.marker.tolist()) == {1} and same(fills.on(holed), twice)


def test_a_recording_is_filled_as_its_settings_say(tmp_path):
    source, _ = trimmed_file(tmp_path)
    trial = read_c3d(source).trajectories
    paths = list(trial.paths)
    xyz, origin = paths[1].xyz.copy(), paths[1].origin.copy()
    xyz[:10], origin[:10] = np.nan, Origin.MISSING
    paths[1] = replace(paths[1], xyz=xyz, origin=origin)
    detections, _ = observe(ring(3), swaying(frames=5)[0].xyz)
    trial, rays = replace(trial, paths=tuple(paths)), Rays(ring(3), detections, np.zeros(len(detections), bool))
    told = {}
    for name, options in (
        ("usual", {}),
        ("trimmed", {"trim": 5}),
        ("ends", {"ends": True, "trim": 5}),
        ("tight", {"limit_mm": 1e-6}),
    ):
        told[name] = fill_recording(trial, rays, method=Filling(RigidBody(), "rigid_body", rays=False, **options)).gaps
    assert [(g.start, g.length) for g in told["trimmed"]] == [(98, 32)]
    assert [(g.start, g.length, g.suspicious) for g in told["usual"]] == [(100, 30, (98, 99))]
    assert {g.start for g in told["ends"]} == {98, 0} and told["tight"][0].method == ""


def test_the_gap_with_the_greatest_deviation_is_drawn_first(tmp_path):
    xyz = with_gap(segment(200))
    xyz[1, 100:110] = np.nan
    write_c3d(tmp_path / "in.c3d", trial_of(xyz))
    done = fill_file(tmp_path / "in.c3d", tmp_path / "out.c3d", method=RigidBody(), name="rigid_body")
    figures = done.figures
    for gap in figures["list"]:
        gap["expected_mm"], gap["sd_max_mm"] = (1.0, 30.0) if gap["marker"] == "B" else (2.0, 3.0)
    page = filling_page(figures=figures, trajectories=done.filled.trajectories).split("<h2>Drawings</h2>")[1]
    assert page.index("<b>B</b>") < page.index("<b>A</b>")


def test_a_gap_in_more_motion_than_its_tests_is_named():
    motion, _ = swaying()
    xyz = with_gap(motion.xyz)
    before = trial_of(xyz).trajectories
    filled = fill(before, method=RigidBody(), limit_mm=np.inf)
    for ratio, named in ((1.0, []), (3.0, ["gaps_beyond_tests"]), (np.nan, [])):
        odd = Filled(filled.trajectories, tuple(replace(gap, motion_ratio=ratio) for gap in filled.gaps))
        figures = filling_figures(odd, before, source="t", method="rigid_body", limit_mm=np.inf)
        assert [f["kind"] for f in figures["findings"] if f["kind"] == "gaps_beyond_tests"] == named
        assert figures["verdict"]["grade"] == ("amber" if named else "green")
        check_findings(figures)


def test_a_reference_marker_that_was_dropped_after_filling_is_not_drawn():
    """As a nameless track that a fill rests on and that `edits finish` drops."""
    before = fill(trial_of(with_gap(segment(120))).trajectories, method=Linear(), limit_mm=np.inf).trajectories
    assert gap_figure(before, "A", 40, 60, references=("*3",)) == gap_figure(before, "A", 40, 60)
