"""Filling many files, and odd ones: nothing is lost, nothing fails without a word."""

import json
from dataclasses import replace

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import AngleModel, KinemarkError, Origin, Trajectories, Trial, same
from kinemark.engine.fill_files import angle_model, fill_file, fill_files, fill_method, filled_figures, filled_text
from kinemark.engine.settings.method_tables import whole_of
from kinemark.fill import Auto, Body, Gap, KalmanAngles, LimbAngles, Linear, MarkerArray
from kinemark.fill.methods.angles import fill_limb_angles
from kinemark.io.angle_model_csv import write_angle_model
from kinemark.io.c3d import read_c3d, write_c3d
from kinemark.io.c3d.document import with_parameters
from kinemark.io.c3d.parameters import Parameter
from kinemark.io.c3d.provenance import stated_filled
from kinemark.io.c3d.writing import write_document
from kinemark.io.trc import read_trc, write_trc
from kinemark.io.trial import read_trial, write_trial
from kinemark.synth import walking
from support.computed import computed, walker, with_computed
from support.filling import GAP, segment, trial_of, with_gap
from support.findings import found
from support.shared import shared_data

QUICK = {"method": Linear(), "name": "linear", "limit_mm": np.inf}


def folder_of(tmp_path, n=2, frames=120):
    """n files with one gap each."""
    sources = [tmp_path / f"trial{k}.c3d" for k in range(n)]
    for k, source in enumerate(sources):
        write_c3d(source, trial_of(with_gap(segment(frames, seed=k))))
    return sources


# Many files


def test_many_files_go_into_a_folder_and_a_bad_one_keeps_nobody_from_the_others(tmp_path):
    a, b = folder_of(tmp_path)
    bad = tmp_path / "bad.c3d"
    bad.write_bytes(b"no C3D file")
    steps = []
    done = fill_files([a, bad, b], tmp_path / "out", report=True, progress=lambda *step: steps.append(step), **QUICK)
    assert {name for name, *_ in steps} == {"trial0.c3d (1 of 3)", "trial1.c3d (3 of 3)"} and list(done) == [a, bad, b]
    assert all(0 <= n <= total for _, n, total in steps)
    assert isinstance(done[bad], KinemarkError)
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == [
        "trial0.c3d", "trial0.html", "trial1.c3d", "trial1.html"
    ]  # fmt: skip
    assert np.isfinite(read_c3d(tmp_path / "out/trial1.c3d").trajectories["A"].xyz).all()
    figures, text = filled_figures(done), filled_text(done)
    assert figures[str(a)]["filled"] == 1 and "bad.c3d" in figures[str(bad)]["error"]
    assert all(str(path) in text for path in (a, b, tmp_path / "out/trial0.html"))


def test_points_that_were_computed_of_markers_stay_as_they_are(tmp_path):
    """Where the program lacked a marker it lacked what it computed of it: that is no gap of a marker."""
    whole = with_computed(walker(1))
    away = np.zeros(whole.n_frames, bool)
    away[60:90] = True
    lost = {"LKNE", *computed(walker(1))}
    cut = replace(whole, paths=tuple(path.only(~away) if path.name in lost else path for path in whole))
    write_trial(Trial("walk", cut), tmp_path / "walk.c3d")
    done = fill_file(tmp_path / "walk.c3d", tmp_path / "filled.c3d", **QUICK)
    after = read_trial(tmp_path / "filled.c3d").trajectories
    assert after.names == whole.names and done.figures["filled"] == done.figures["gaps"] == 1
    assert np.isfinite(after["LKNE"].xyz).all()
    assert all(np.isnan(after[name].xyz[away]).all() for name in computed(walker(1)))
    (said,) = found(done.figures, "computed_not_filled")
    assert said.values["points"] == len(computed(walker(1)))


def test_one_file_goes_into_a_file_or_a_folder(tmp_path):
    (a,) = folder_of(tmp_path, 1)
    assert fill_files([a], tmp_path / "x.trc", **QUICK)[a].written == (tmp_path / "x.trc",)
    assert fill_files([a], tmp_path / "out", **QUICK)[a].written == (tmp_path / "out/trial0.c3d",)
    with pytest.raises(KinemarkError, match="nothing is overwritten"):
        fill_files([a], tmp_path / "out", **QUICK)
    with pytest.raises(KinemarkError, match="nothing is overwritten"):
        fill_files([a], tmp_path, **QUICK)  # the source's own folder
    with pytest.raises(KinemarkError, match="one file, and there are 2 trials"):
        fill_files([a, a], tmp_path / "x.c3d", **QUICK)


def test_the_command_takes_many_files_and_fails_at_the_end_if_one_did(tmp_path, capsys):
    a, b = folder_of(tmp_path)
    words = ["fill", str(a), str(b), "-o", str(tmp_path / "out"), "--method", "linear", "--limit-mm", "inf", "--json"]
    app(words, result_action="return_value")
    assert set(json.loads(capsys.readouterr().out)) == {str(a), str(b)}
    with pytest.raises(SystemExit) as stopped:
        app(words, result_action="return_value")
    assert stopped.value.code == 1
    assert all("nothing is overwritten" in found["error"] for found in json.loads(capsys.readouterr().out).values())


def test_pages_of_files_that_differ_by_their_endings_stand_beside_each_other(tmp_path):
    a, b = folder_of(tmp_path)
    write_trial(read_trial(a), tmp_path / "trial0.trc")
    done = fill_files([a, tmp_path / "trial0.trc", b], tmp_path / "out", report=True, **QUICK)
    pages = [one.written[1] for one in done.values()]
    assert [page.name for page in pages] == ["trial0.c3d.html", "trial0.trc.html", "trial1.html"]
    assert all(page.is_file() for page in pages)


# Odd files


def test_numbers_that_cannot_be_are_refused_in_words(tmp_path):
    (a,) = folder_of(tmp_path, 1)
    out = tmp_path / "o.c3d"
    for options, said in (({"limit_mm": -1}, "limit is -1"), ({"limit_mm": np.nan}, "limit is nan"),
                          ({"trim": -2}, "trim is -2"), ({"rate_hz": -3}, "rate is -3"),
                          ({"rate_hz": 0}, "rate is 0")):  # fmt: skip
        with pytest.raises(KinemarkError, match=said):
            fill_file(a, out, **options)
    write_trc(tmp_path / "still.trc", replace(trial_of(segment(20)).trajectories, rate=50.0))
    text = (tmp_path / "still.trc").read_text().replace("50", "-5", 1)
    (tmp_path / "still.trc").write_text(text)
    with pytest.raises(KinemarkError, match=r"rate|DataRate"):
        fill_file(tmp_path / "still.trc", out)
    assert not out.exists()


def test_the_command_refuses_them_too(tmp_path):
    (a,) = folder_of(tmp_path, 1)
    with pytest.raises(KinemarkError, match="Wanted is one above 0"):
        app(["fill", str(a), "-o", str(tmp_path / "o.c3d"), "--limit-mm", "-1"], result_action="return_value")


@pytest.mark.parametrize("ending", [".trc", ".csv"])
def test_text_files_are_filled_and_keep_what_was_measured(tmp_path, ending):
    given = trial_of(with_gap(segment(120)))
    write_trial(given, tmp_path / f"a{ending}")
    fill_file(tmp_path / f"a{ending}", tmp_path / f"b{ending}", trim=0, **QUICK)
    after = read_trial(tmp_path / f"b{ending}").trajectories
    assert after.rate == 100.0 and after.first_frame == 5
    seen = ~np.isnan(given.trajectories.xyz)
    assert np.array_equal(after.xyz[seen], given.trajectories.xyz[seen]) and np.isfinite(after.xyz).all()


def test_a_file_in_metres_with_repeated_names_and_angles(tmp_path):
    """Lengths come back in the file's unit; angles and moments with holes are no markers and stay as they are."""
    xyz = with_gap(segment(100))
    write_c3d(tmp_path / "mm.c3d", trial_of(xyz, names=["A", "B", "C", "D", "Knee"]))
    doc = read_c3d(tmp_path / "mm.c3d").source
    doc = replace(doc, points=doc.points / 1000)
    doc = with_parameters(doc, "POINT", [Parameter.text("UNITS", "m"), Parameter.text("ANGLES", ["Knee"])])
    doc = with_parameters(doc, "POINT", [Parameter.text("LABELS", ["A", "A", "A", "D", "Knee"])])
    write_document(tmp_path / "m.c3d", doc)
    before = read_c3d(tmp_path / "m.c3d")
    fill_file(tmp_path / "m.c3d", tmp_path / "out.c3d", trim=0, **QUICK)
    after = read_c3d(tmp_path / "out.c3d")
    assert after.source.texts("POINT", "UNITS") == ("m",) or list(after.source.texts("POINT", "UNITS")) == ["m"]
    assert after.trajectories.names == before.trajectories.names and len(set(after.trajectories.names)) == 4
    assert same(before.signals, after.signals) and after.signals.names == ("Knee",)
    first = after.trajectories.paths[0]
    assert (first.origin[GAP] == Origin.FILLED).all()
    assert np.linalg.norm(np.diff(first.xyz, axis=0), axis=1).max() < 40  # mm, not metres
    assert all(same(a, b) for a, b in zip(before.trajectories.paths[1:], after.trajectories.paths[1:], strict=True))


def test_a_child_s_gait_file_keeps_its_angles_moments_and_events(tmp_path):
    source = shared_data("mocap3d/pig_gait_child/HC030A05.c3d")
    before = read_c3d(source)
    name = next(n for n in before.trajectories.names if n.endswith("LTOE"))
    path = before.trajectories[name]
    hole = np.zeros(len(path), bool)
    hole[60:75] = True
    gone = replace(path, xyz=np.where(hole[:, None], np.nan, path.xyz), origin=np.where(hole, 0, path.origin))
    paths = tuple(gone if p.name == name else p for p in before.trajectories)
    write_c3d(tmp_path / "holed.c3d", replace(before, trajectories=replace(before.trajectories, paths=paths)))
    fill_file(tmp_path / "holed.c3d", tmp_path / "out.c3d", method=Body(), trim=0)
    after = read_c3d(tmp_path / "out.c3d")
    assert (after.trajectories[name].origin == Origin.FILLED).sum() == 15
    assert np.linalg.norm(after.trajectories[name].xyz[hole] - path.xyz[hole], axis=1).mean() < 10
    others = [n for n in before.trajectories.names if n != name]
    assert all(same(before.trajectories[n], after.trajectories[n]) for n in others)
    assert len(others) + len(before.signals) > 200 and same(before.signals, after.signals)
    assert all(same(a, b) for a, b in zip(before.analog, after.analog, strict=True)) and same(
        before.events, after.events
    )


def test_filled_samples_of_more_than_255_gaps_are_all_told(tmp_path):
    xyz = segment(1200)
    for m in range(5):
        for k in range(60):
            xyz[m, 10 + 19 * k + 3 * m : 12 + 19 * k + 3 * m] = np.nan
    write_c3d(tmp_path / "in.c3d", trial_of(xyz))
    fill_file(tmp_path / "in.c3d", tmp_path / "out.c3d", trim=0, **QUICK)
    after = read_c3d(tmp_path / "out.c3d").trajectories
    told = np.array([path.origin == Origin.FILLED for path in after])
    assert np.array_equal(told, np.isnan(xyz[:, :, 0])) and told.sum() == 600
    write_c3d(tmp_path / "again.c3d", read_c3d(tmp_path / "out.c3d"))
    assert same(read_c3d(tmp_path / "again.c3d").trajectories, after)


def test_frames_beyond_sixteen_bits_are_told(tmp_path):
    xyz = np.tile(segment(1000)[:1], (1, 70, 1))
    xyz[0, 66000:66010] = np.nan
    write_c3d(tmp_path / "in.c3d", trial_of(xyz))
    fill_file(tmp_path / "in.c3d", tmp_path / "out.c3d", trim=0, **QUICK)
    origin = read_c3d(tmp_path / "out.c3d").trajectories["A"].origin
    assert np.flatnonzero(origin == Origin.FILLED).tolist() == list(range(66000, 66010))


def test_marks_of_filled_samples_follow_what_is_done_to_the_file(tmp_path):
    """They go when the samples are measured after all, and stay with the frames of a cut trial."""
    write_c3d(tmp_path / "in.c3d", trial_of(with_gap(segment(120))))
    trial = fill_file(tmp_path / "in.c3d", tmp_path / "out.c3d", trim=0, **QUICK).trial
    stored = read_c3d(tmp_path / "out.c3d")
    assert (stored.trajectories["A"].origin[GAP] == Origin.FILLED).all()
    path = stored.trajectories["A"]
    as_measured = replace(path, origin=np.full(120, Origin.MEASURED, np.uint8))
    write_c3d(tmp_path / "m.c3d", replace(stored, trajectories=replace(
        stored.trajectories, paths=(as_measured, *stored.trajectories.paths[1:]))))  # fmt: skip
    assert (read_c3d(tmp_path / "m.c3d").trajectories["A"].origin == Origin.MEASURED).all()
    assert same(trial.trajectories["A"].origin, path.origin)


def test_samples_a_kilometre_away_are_told_and_no_motion(tmp_path):
    xyz = with_gap(segment(120))
    xyz[1, 119], xyz[2, 50] = 1e9, -1e9
    write_trc(tmp_path / "in.trc", trial_of(xyz).trajectories)
    done = fill_file(
        tmp_path / "in.trc", tmp_path / "out.trc", method=Body(training_frames=40), name="body", limit_mm=50.0
    )
    assert done.figures["far_away"] == 2  # the one within the marker's time is a gap, and filled
    assert found(done.figures, "samples_far_away")[0].values["samples"] == 2
    after = read_trc(tmp_path / "out.trc")
    assert np.abs(after["C"].xyz).max() < 1e5 and done.figures["replaced"] >= 1
    assert np.isnan(after["B"].xyz[119]).all()


def test_gaps_of_tracks_without_a_name_are_none_of_a_markers(tmp_path):
    paths = list(trial_of(with_gap(segment(120))).trajectories)
    gappy = next(k for k, path in enumerate(paths) if np.isnan(path.xyz).any())
    for names, filled in (("*1", 0), ("A", 1)):
        named = [replace(path, name=f"N{k}") for k, path in enumerate(paths)]
        named[gappy] = replace(paths[gappy], name=names)
        write_trc(tmp_path / f"{filled}.trc", Trajectories(tuple(named), 100.0))
        done = fill_file(
            tmp_path / f"{filled}.trc", tmp_path / f"out{filled}.trc", method=Linear(), name="linear", limit_mm=np.inf
        )
        assert done.figures["filled"] == done.figures["gaps"] == filled
        said = found(done.figures, "tracks_not_filled")
        assert [one.values for one in said] == ([] if filled else [{"tracks": 1, "gaps": 1}])
    alone = [replace(path, name=f"*{k}") for k, path in enumerate(paths)]
    write_trc(tmp_path / "alone.trc", Trajectories(tuple(alone), 100.0))
    done = fill_file(tmp_path / "alone.trc", tmp_path / "o.trc", method=Linear(), name="linear", limit_mm=np.inf)
    assert done.figures["filled"] == 1, "where no track has a name, none is a ghost for that"


def test_marks_of_samples_that_another_program_measured_anew_or_that_do_not_fit_are_passed_over(tmp_path):
    write_c3d(tmp_path / "in.c3d", trial_of(with_gap(segment(120))))
    fill_file(tmp_path / "in.c3d", tmp_path / "out.c3d", trim=0, **QUICK)
    doc = read_c3d(tmp_path / "out.c3d").source
    word = doc.word.copy()
    word[45:50, 0] = 3.0
    assert np.array_equal(
        stated_filled(replace(doc, word=word), ("A",))[0].nonzero()[0], [*range(40, 45), *range(50, 60)]
    )
    for runs in ([[100, 125]], [[4, 6]], [[60, 50]]):  # the file has the frames 5 to 124
        frames = Parameter.real("FILLED_FRAMES", np.array(runs, float))
        assert not stated_filled(with_parameters(doc, "KINEMARK", [frames]), ("A",)).any()
    frames = Parameter.real("FILLED_FRAMES", np.array([[124, 124]], float))
    assert stated_filled(with_parameters(doc, "KINEMARK", [frames]), ("A",))[0].nonzero()[0].tolist() == [119]
    assert not stated_filled(doc, ("B",)).any()


# A static trial


def test_a_static_trial_of_other_markers_says_what_it_cannot_place(tmp_path):
    (a,) = folder_of(tmp_path, 1)
    write_c3d(tmp_path / "static.c3d", trial_of(segment(20), names="VWXYZ"))
    static = tmp_path / "static.c3d"
    done = fill_file(a, tmp_path / "o.c3d", static=static, report=tmp_path / "o.html", trim=0, **QUICK)
    assert done.figures["filled"] == 1 and done.figures["open"] == 5
    assert all(gap["state"] != "filled" for gap in done.figures["list"] if not gap["method"])
    assert done.trial.trajectories.names == ("A", "B", "C", "D", "E") and (tmp_path / "o.html").is_file()


def test_a_marker_from_the_static_trial_is_told_apart(tmp_path):
    truth = segment(120, noise=0.1)
    xyz = truth.copy()
    xyz[4] = np.nan
    write_c3d(tmp_path / "in.c3d", trial_of(xyz))
    write_c3d(tmp_path / "static.c3d", trial_of(truth[:, :20]))
    done = fill_file(tmp_path / "in.c3d", tmp_path / "o.c3d", static=tmp_path / "static.c3d", limit_mm=20.0)
    assert done.figures["by_method"] == {"static": 1} and done.figures["never_seen"] == []
    assert done.figures["expected_median_mm"] is None  # no hold-out gap was made
    assert [one["kind"] for one in done.figures["verdict"]["statements"]] == ["gaps_filled", "markers_from_static"]
    after = read_c3d(tmp_path / "o.c3d").trajectories["E"]
    assert (after.origin == Origin.FILLED).all() and np.abs(after.xyz - truth[4]).max() < 5


# The thesis' methods by name


def test_the_thesis_own_algorithm_is_selectable_and_auto_leaves_it_out():
    method = fill_method("kalman_angles", ["feedback=measured", "segment_tolerance=0.05"])
    assert method == KalmanAngles("measured", segment_tolerance=0.05)
    assert whole_of("fill", {"method": "kalman_angles", "feedback": "path"}).method == KalmanAngles("path")
    assert "kalman_angles" not in Auto().candidates and "limb_angles" in Auto().candidates
    with pytest.raises(KinemarkError, match="feedback"):
        fill_method("kalman_angles", ["feedback=x"])


@pytest.fixture(scope="module")
def walk():
    subject = walking(duration_s=4.0, rate=50.0, seed=3)
    return trial_of(subject.xyz, names=subject.names)


def test_a_model_comes_from_another_trial_or_a_file(walk, tmp_path):
    walk = replace(walk, trajectories=replace(walk.trajectories, rate=50.0))
    write_c3d(tmp_path / "walk.c3d", walk)
    model = angle_model(tmp_path / "walk.c3d")
    write_angle_model(tmp_path / "walk.csv", model)
    assert isinstance(model, AngleModel)
    other = fill_method("limb_angles", model=tmp_path / "walk.csv")
    assert isinstance(other, LimbAngles) and np.allclose(other.model.length, model.length)
    assert fill_method("kalman_angles", model=tmp_path / "walk.csv").limbs.model is not None
    candidates = fill_method("auto", ['candidates=["linear", "limb_angles"]'], model=tmp_path / "walk.csv").methods
    assert [type(one) for one in candidates] == [Linear, LimbAngles] and candidates[1].model is not None
    with pytest.raises(KinemarkError, match="linear takes no model"):
        fill_method("linear", model=tmp_path / "walk.csv")
    write_c3d(tmp_path / "still.c3d", trial_of(np.repeat(segment(5)[:, :1], 100, axis=1)))
    with pytest.raises(KinemarkError, match="No model can be made of"):
        angle_model(tmp_path / "still.c3d")


def test_a_model_of_another_walk_fills_half_a_step(walk, tmp_path):
    trajectories = replace(walk.trajectories, rate=50.0)
    write_c3d(tmp_path / "other.c3d", replace(walk, trajectories=trajectories))
    short = Trajectories(tuple(replace(p, xyz=p.xyz[:70], cov=p.cov[:70], origin=p.origin[:70],
                         residual=p.residual[:70], cameras=p.cameras[:70]) for p in trajectories), 50.0)  # fmt: skip
    knee = next(n for n in short.names if "KNE" in n)
    path = short[knee]
    hole = np.zeros(70, bool)
    hole[25:50] = True
    gone = replace(path, xyz=np.where(hole[:, None], np.nan, path.xyz), origin=np.where(hole, 0, path.origin))
    motion = MarkerArray.of(replace(short, paths=tuple(gone if p.name == knee else p for p in short)))
    gap = Gap(motion.names.index(knee), 25, 50)
    (found,) = fill_limb_angles(motion, [gap], method=fill_method("limb_angles", model=tmp_path / "other.c3d"))
    assert np.linalg.norm(found.xyz - path.xyz[hole], axis=1).mean() < 20
