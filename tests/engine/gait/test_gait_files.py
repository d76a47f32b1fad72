"""`kinemark gait`: from files to results."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import Events, KinemarkError, MarkerTrajectory, Trajectories, Trial
from kinemark.data.gait_curves import GaitReference
from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.engine.gait.comparison import compare_gait
from kinemark.engine.gait.files import gait_of_files
from kinemark.engine.gait.reference import read_band, reference_of_files
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.trial_files import SubjectFiles, one_of_each, trial_names
from kinemark.gait.gait_trial import REACTION_AXES
from kinemark.io.c3d import write_c3d
from kinemark.io.gait_reference import read_reference, write_reference
from kinemark.io.notes import file_note_text
from kinemark.io.trial import read_trial
from kinemark.report.figures_gait import KINEMATICS, panels_figure
from kinemark.report.gait_page import key_values_table, time_distance_table
from kinemark.synth import WalkingBody, gait_laboratory, walking
from support.drawings import check_page
from support.plug_in_gait import ADULT
from support.shared import shared_data

MEASURES = """
mass_kg = 70
[left]
leg_mm = 890
knee_mm = 105
ankle_mm = 72
[right]
leg_mm = 890
knee_mm = 105
ankle_mm = 72
"""
QUICK = GaitSettings(uncertainty=False)


@pytest.fixture
def walk(tmp_path):
    """A simulated walk without plates, and measures."""
    subject = walking(duration_s=5.0, rate=100.0, seed=1)
    write_c3d(tmp_path / "walk.c3d", Trial("walk", subject.trajectories))
    (tmp_path / "anna.toml").write_text(MEASURES, encoding="utf-8")
    return tmp_path


def test_angles_with_gaps_are_told_and_filling_is_named(walk):
    whole = gait_of_files(SubjectFiles([walk / "walk.c3d"], measures=walk / "anna.toml"), settings=QUICK)
    trial = read_trial(walk / "walk.c3d")
    knee = trial.trajectories["RKNE"]
    xyz = knee.xyz.copy()
    xyz[200:230] = np.nan  # a part of one stride
    paths = tuple(MarkerTrajectory.measured("RKNE", xyz) if p.name == "RKNE" else p for p in trial.trajectories)
    write_c3d(walk / "gappy.c3d", replace(trial, trajectories=replace(trial.trajectories, paths=paths)))
    gappy = gait_of_files(SubjectFiles([walk / "gappy.c3d"], measures=walk / "anna.toml"), settings=QUICK)
    kinds = [[f for f in one.figures["findings"] if f["kind"] == "gait_angles_with_gaps"] for one in (whole, gappy)]
    assert not kinds[0] and len(kinds[1]) == 1
    values = kinds[1][0]["values"]
    assert values["joints_list"] == ["hip", "knee", "ankle", "foot progression"]
    assert (
        values["side"] == "right"
        and 1 <= values["cut"] <= 2 < values["strides"]
        and "kinemark fill" in kinds[1][0]["advice"]
    )


def test_a_missing_sample_that_costs_key_values_is_told(walk):
    """One wild sample, which the reader gives as missing, took values out of the tables without a word."""
    trial = read_trial(walk / "walk.c3d")
    xyz = trial.trajectories["RKNE"].xyz.copy()
    xyz[215] = np.nan
    paths = tuple(MarkerTrajectory.measured("RKNE", xyz) if p.name == "RKNE" else p for p in trial.trajectories)
    write_c3d(walk / "gappy.c3d", replace(trial, trajectories=replace(trial.trajectories, paths=paths)))
    found = gait_of_files(SubjectFiles([walk / "gappy.c3d"], measures=walk / "anna.toml"), settings=QUICK)
    told = [f["values"] for f in found.figures["findings"] if f["kind"] == "gait_key_values_with_gaps"]
    assert [one["side"] for one in told] == ["right"] and told[0]["missing"] > 3
    assert told[0]["curves_list"] == ["ankle", "foot progression", "hip", "knee"]


def test_a_band_whose_reactions_are_along_the_laboratory_is_refused(tmp_path):
    curves = {"GroundReactionForce": np.ones((101, 3)), "KneeAngles": np.ones((101, 3))}
    band = GaitReference(curves, curves, "earlier", 7)
    write_reference(tmp_path / "old.json", band)
    with pytest.raises(KinemarkError, match="along the axes of the laboratory"):
        read_band(tmp_path / "old.json")
    write_reference(tmp_path / "new.json", band._replace(axes={"GroundReactionForce": REACTION_AXES}))
    assert read_band(tmp_path / "new.json").axes["GroundReactionForce"] == REACTION_AXES
    del curves["GroundReactionForce"]
    write_reference(tmp_path / "angles.json", band)
    assert set(read_band(tmp_path / "angles.json").mean) == {"KneeAngles"}


def test_walks_that_cannot_be_used_are_told_and_keep_nobody_from_the_others(walk, capsys):
    content = (walk / "walk.c3d").read_bytes()
    (walk / "a_broken.c3d").write_bytes(content[: len(content) // 300])
    trial = read_trial(walk / "walk.c3d")
    few = tuple(p for p in trial.trajectories if p.name != "LKNE")
    write_c3d(walk / "b_few.c3d", replace(trial, trajectories=replace(trial.trajectories, paths=few)))
    alone = gait_of_files(SubjectFiles([walk / "walk.c3d"], measures=walk / "anna.toml"), settings=QUICK).figures
    with pytest.raises(SystemExit) as ended:
        app(["gait", str(walk), "--measures", str(walk / "anna.toml"), "--no-uncertainty", "-o", str(walk / "all")])
    said = capsys.readouterr().err
    assert ended.value.code == 1 and "a_broken.c3d" in said and "LKNE" in said
    figures = json.loads((walk / "all/gait.json").read_text())
    assert figures["time_distance"] == alone["time_distance"]
    left_out = [f["values"]["trial"] for f in figures["findings"] if f["kind"] == "gait_walk_left_out"]
    assert left_out == ["a_broken", "b_few"] and "So b_few was left out." in (walk / "all/gait.html").read_text()
    with pytest.raises(KinemarkError, match="a_broken"):
        gait_of_files(SubjectFiles([walk / "a_broken.c3d", walk / "b_few.c3d"]), settings=QUICK)


def test_names_that_were_taken_for_the_models_are_told_where_one_is_missing(walk):
    trial = read_trial(walk / "walk.c3d")
    other = {"LASI": "Ann:LFWT", "RASI": "Ann:RFWT", "LTIB": "Ann:LSHN", "RTIB": "Ann:RSHN"}
    paths = tuple(replace(p, name=other.get(p.name, f"Ann:{p.name}")) for p in trial.trajectories)
    write_c3d(walk / "other.c3d", replace(trial, trajectories=replace(trial.trajectories, paths=paths)))
    with pytest.raises(
        KinemarkError, match=r"LTIB, RTIB.* Taken for the model's were LASI = Ann:LFWT, RASI = Ann:RFWT"
    ):
        gait_of_files(SubjectFiles([walk / "other.c3d"], measures=walk / "anna.toml"), settings=QUICK)
    stated = {"LTIB": "LSHN", "RTIB": "Ann:RSHN"}  # with the subject's name, or without it
    found = gait_of_files(
        SubjectFiles([walk / "other.c3d"], measures=walk / "anna.toml", markers=stated), settings=QUICK
    )
    told = next(f for f in found.figures["findings"] if f["kind"] == "gait_markers_renamed")
    assert "LTIB = Ann:LSHN" in told["values"]["names_list"]


def test_a_walk_gives_page_tables_figures_and_a_file(walk):
    found = gait_of_files(SubjectFiles([walk / "walk.c3d"], measures=walk / "anna.toml"), settings=QUICK)
    assert found.folder == walk / "walk_gait"
    figures = json.loads((found.folder / "gait.json").read_text())
    speed = figures["time_distance"]["left"]["speed"]["mean"]
    assert speed == pytest.approx(1100, rel=0.02)
    page = (found.folder / "gait.html").read_text()
    assert "Knee flexion" in page and "walking speed" in page and "Harmonics of the stride" in page
    assert check_page(page)
    assert figures["harmonics"]["stride_hz"]["left"] == pytest.approx(
        figures["time_distance"]["left"]["cadence"]["mean"] / 120, rel=0.01
    )
    knee = next(h for h in figures["harmonics"]["angles"] if (h["name"], h["component"]) == ("LKneeAngles", "flexion"))
    assert knee["amplitude"][0] > 15 and sum(knee["share"]) == pytest.approx(1, abs=0.02)
    with (found.folder / "curves.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 101 and 50 < max(float(r["LKneeAngles_flexion_deg"]) for r in rows) < 75
    back = read_trial(found.folder / "walk_gait.c3d")
    assert "LKneeAngles" in back.signals.names and len(back.events) > 8
    assert {f["kind"] for f in figures["findings"]} >= {"gait_without_moments", "foot_offsets_unknown"}


def moved(trial, mm):
    """Another walk of the subject: the same steps beside those of the first, which would be one recording."""
    paths = tuple(replace(path, xyz=path.xyz + np.array([0.0, mm, 0.0])) for path in trial.trajectories)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths))


def test_each_value_of_a_stride_says_of_which_walk_it_is(walk):
    """What a statistician needs: rows by trial, side and stride, whose means are those of the page."""
    write_c3d(walk / "second.c3d", moved(read_trial(walk / "walk.c3d"), 150.0))
    found = gait_of_files(
        SubjectFiles([walk / "walk.c3d", walk / "second.c3d"], measures=walk / "anna.toml"), settings=QUICK
    )
    tables = {}
    for name in ("key_values", "time_distance"):
        with (found.folder / f"{name}.csv").open() as file:
            tables[name] = list(csv.DictReader(file))
    strides = [{(r["trial"], r["side"], r["first_s"]) for r in rows} for rows in tables.values()]
    assert strides[0] == strides[1] and {trial for trial, *_ in strides[0]} == {"walk", "second"}
    row = next(r for r in found.figures["key_values"] if r["name"] == "knee flexion, greatest in swing")
    own = [float(r["value"]) for r in tables["key_values"] if (r["name"], r["side"]) == (row["name"], "left")]
    assert row["left"]["strides"] == len(own) and row["left"]["mean"] == pytest.approx(np.mean(own), abs=1e-4)
    assert 50 < row["left"]["mean"] < 75 and "knee flexion, greatest in swing (°)" in (
        (found.folder / "gait.html").read_text()
    )


@pytest.mark.parametrize(
    ("subjects", "told"), [(("Anna", "Ben"), True), (("Anna", "anna "), False), (("", "Ben"), False)]
)
def test_files_of_two_people_are_told(walk, subjects, told):
    trial = read_trial(walk / "walk.c3d")
    for name, subject in zip(("one", "standing"), subjects, strict=True):
        write_c3d(walk / f"{name}.c3d", replace(trial, about={**trial.about, "subject": subject}))
    files = {"static": walk / "standing.c3d", "measures": walk / "anna.toml"}
    found = gait_of_files(SubjectFiles([walk / "one.c3d"], **files), settings=QUICK, folder=walk / "out")
    said = [f["text"] for f in found.figures["findings"] if f["kind"] == "gait_subjects_differ"]
    assert bool(said) == told and all("Anna (one), Ben (standing)" in text for text in said)


def test_a_marker_that_leaps_is_told(walk):
    trial = read_trial(walk / "walk.c3d")
    xyz = trial.trajectories["RKNE"].xyz.copy()
    xyz[150:] += [0, 60.0, 0]  # its track went over to another marker
    paths = tuple(MarkerTrajectory.measured("RKNE", xyz) if p.name == "RKNE" else p for p in trial.trajectories)
    write_c3d(walk / "leaps.c3d", replace(trial, trajectories=replace(trial.trajectories, paths=paths)))
    told = [
        [
            f
            for f in gait_of_files(SubjectFiles([walk / name]), settings=QUICK).figures["findings"]
            if f["kind"] == "gait_markers_leap"
        ]
        for name in ("walk.c3d", "leaps.c3d")
    ]
    assert not told[0] and told[1][0]["markers"] == ["RKNE"] and told[1][0]["values"]["leaps"] == 2


def test_a_spike_is_left_out_and_told(walk):
    trial = read_trial(walk / "walk.c3d")
    xyz = trial.trajectories["RKNE"].xyz.copy()
    xyz[150:152] += [0, 60.0, 0]
    paths = tuple(MarkerTrajectory.measured("RKNE", xyz) if p.name == "RKNE" else p for p in trial.trajectories)
    write_c3d(walk / "spike.c3d", replace(trial, trajectories=replace(trial.trajectories, paths=paths)))
    clean, found = (gait_of_files(SubjectFiles([walk / name]), settings=QUICK) for name in ("walk.c3d", "spike.c3d"))
    (told,) = (f for f in found.figures["findings"] if f["kind"] == "gait_spikes_left_out")
    assert (told["markers"], told["frames"], told["values"]["samples"]) == (["RKNE"], [[151, 152]], 2)
    assert told["text"].startswith("spike: 2 samples of marker RKNE are off the path by up to 60\xa0mm for a moment (")
    knees = [one.trials[0].gait.signals["RKneeAngles"].values for one in (clean, found)]
    assert np.nanmax(np.abs(knees[0] - knees[1])) < 0.1
    kept = read_trial(found.folder / "spike_gait.c3d").trajectories["RKNE"].xyz
    assert np.allclose(kept, xyz, atol=1e-3, equal_nan=True)  # what was given is never changed


def test_error_bars_are_on_every_curve(walk):
    found = gait_of_files(
        SubjectFiles([walk / "walk.c3d"], static=walk / "walk.c3d", measures=walk / "anna.toml"), folder=walk / "out"
    )
    knee = next(c for c in found.curves if c.name == "LKneeAngles")
    assert (knee.measurement_sd[:, 0] > 0.5).all()
    assert {"placement", "hip centre"} <= set(found.figures["uncertainty"][0]["by_cause"])


def test_a_motion_shows_the_hips(tmp_path):
    leg = LegMeasures(890.0, 105.0, 72.0)
    off = {"left": np.array([8.0, 6.0, -9.0]), "right": np.array([-9.0, 8.0, 7.0])}
    body = WalkingBody(SubjectMeasures(leg, leg, mass_kg=70.0), hip_error_mm=off)
    lab = gait_laboratory(body, duration_s=3.0, rate=50.0)
    for name in ("walk", "static", "functional"):
        write_c3d(tmp_path / f"{name}.c3d", getattr(lab, name))
    files = {name: tmp_path / f"{name}.c3d" for name in ("static", "functional")}
    how = GaitSettings(smoothing="none", tissue_mm=0.5, uncertainty=False)
    measures = replace(body.measures)
    found = gait_of_files(
        SubjectFiles([tmp_path / "walk.c3d"], measures=measures, **files), folder=tmp_path / "out", settings=how
    )
    hip = found.trials[0].gait.limbs.left.hip
    assert np.abs(hip - lab.limbs.left.hip).max() < 0.1  # C3D holds single precision
    told = next(f for f in found.figures["findings"] if f["kind"] == "gait_hips_functional")
    assert told["values"]["away_mm"] == pytest.approx(np.linalg.norm(off["right"]), abs=1.0)
    assert "functional, from functional" in (tmp_path / "out" / "gait.html").read_text()
    with pytest.raises(KinemarkError, match=r"static: The left hip"):
        gait_of_files(
            SubjectFiles([tmp_path / "walk.c3d"], measures=measures, functional=files["static"]), settings=how
        )


def test_devices_on_the_knees_show_their_axes(tmp_path):
    leg = LegMeasures(890.0, 105.0, 72.0)
    turned = replace(leg, thigh_wand_deg=9.0, shank_wand_deg=-8.0, torsion_deg=21.0)
    body = WalkingBody(SubjectMeasures(turned, leg, mass_kg=70.0), worn=("KAX", "KD1", "KD2", "MED"))
    lab = gait_laboratory(body, duration_s=3.0, rate=50.0)
    for name in ("walk", "static"):
        write_c3d(tmp_path / f"{name}.c3d", getattr(lab, name))
    files = {"static": tmp_path / "static.c3d", "measures": SubjectMeasures(leg, leg, mass_kg=70.0)}
    how = GaitSettings(smoothing="none", uncertainty=False)
    found = gait_of_files(SubjectFiles([tmp_path / "walk.c3d"], **files), folder=tmp_path / "out", settings=how)
    true, ours = (signals["LKneeAngles"].values for signals in (lab.signals, found.trials[0].gait.signals))
    np.testing.assert_allclose(ours, true, atol=0.01)  # C3D holds single precision
    assert found.figures["measures"]["left"]["torsion_deg"] == pytest.approx(21.0, abs=0.01)
    told = {f["kind"]: f["values"] for f in found.figures["findings"]}
    assert told["gait_axes_from_static"] == {"trial": "static", "way": "devices"} and "gait_axes_doubtful" not in told
    assert "tibial torsion" in (tmp_path / "out" / "gait.html").read_text()
    thin = {**files, "measures": SubjectMeasures(replace(leg, ankle_mm=45.0), leg, mass_kg=70.0)}
    doubted = gait_of_files(
        SubjectFiles([tmp_path / "walk.c3d"], **thin), folder=tmp_path / "thin", settings=how
    ).figures
    doubt = next(f for f in doubted["findings"] if f["kind"] == "gait_axes_doubtful")
    assert doubt["values"]["by_mm"] == pytest.approx(27.0, abs=0.1) and "left ankle" in doubt["text"]
    wide = {**files, "measures": SubjectMeasures(replace(leg, ankle_mm=99.0), leg, mass_kg=70.0)}
    doubted = gait_of_files(
        SubjectFiles([tmp_path / "walk.c3d"], **wide), folder=tmp_path / "wide", settings=how
    ).figures
    text = next(f["text"] for f in doubted["findings"] if f["kind"] == "gait_axes_doubtful")
    assert "27\u00a0mm nearer to each other than the ankle is wide" in text
    how = replace(how, axes=False)
    plain = gait_of_files(SubjectFiles([tmp_path / "walk.c3d"], **files), folder=tmp_path / "plain", settings=how)
    assert plain.figures["measures"]["left"]["torsion_deg"] == 0


def test_several_walks_count_together(walk):
    write_c3d(walk / "second.c3d", moved(read_trial(walk / "walk.c3d"), 150.0))
    both = [walk / "walk.c3d", walk / "second.c3d", walk / "walk.c3d"]  # a file that is given twice counts once
    two = gait_of_files(SubjectFiles(both, measures=walk / "anna.toml"), folder=walk / "two", settings=QUICK)
    one = gait_of_files(
        SubjectFiles([walk / "walk.c3d"], measures=walk / "anna.toml"), folder=walk / "one", settings=QUICK
    )
    assert len(two.curves[0].values) == 2 * len(one.curves[0].values)


def test_controls_become_a_band_that_others_are_scored_against(walk):
    for seed in (2, 3):
        subject = walking(duration_s=4.0, rate=100.0, seed=seed)
        write_c3d(walk / f"c{seed}.c3d", Trial("walk", subject.trajectories))
        gait_of_files(
            SubjectFiles([walk / f"c{seed}.c3d"], measures=walk / "anna.toml"), folder=walk / f"c{seed}", settings=QUICK
        )
    controls = [walk / f"c{seed}" / "gait.json" for seed in (2, 3)]
    band = reference_of_files(controls, output=walk / "band.json", source="two of ours")
    assert band.subjects == 2 and band.mean["KneeAngles"].shape == (101, 3)
    found = gait_of_files(
        SubjectFiles([walk / "walk.c3d"], measures=walk / "anna.toml", reference=walk / "band.json"), settings=QUICK
    )
    assert 0 < found.figures["profile"]["left"]["score"] < 5  # deg; the simulated walkers differ by their noise alone
    page = (found.folder / "gait.html").read_text()
    assert "Overall gait profile score, of both sides" in page and "two of ours" in page and 'href="#profile"' in page
    speeds = [json.loads(path.read_text())["time_distance"] for path in controls]
    mean = np.mean([each[side]["speed"]["mean"] for each in speeds for side in ("left", "right")])
    assert band.numbers["speed"][0] == pytest.approx(mean)  # mm/s, as in gait.json
    assert time_distance_table(found.figures, band.numbers).rows[0][-1].startswith(f"{mean / 1000:.2f} ± ")
    keys = key_values_table(found.figures, read_reference(walk / "band.json").numbers, angles=True)
    swing = next(row for row in keys.rows if row[0].startswith("knee flexion, greatest in swing"))
    own, norm = (float(swing[k].split(" ± ")[0]) for k in (1, -1))
    assert keys.head[-1] == "reference" and norm == pytest.approx(own, abs=3)
    assert "reference" not in time_distance_table(found.figures).head
    with pytest.raises(KinemarkError, match="two or more"):
        reference_of_files(controls[:1], output=walk / "band.json", source="")
    with pytest.raises(KinemarkError, match="never overwritten"):
        reference_of_files(controls, output=controls[0], source="")
    before = (walk / "band.json").read_bytes()
    with pytest.raises(KinemarkError, match="nothing is overwritten"):
        reference_of_files(controls, output=walk / "band.json", source="")
    assert (walk / "band.json").read_bytes() == before
    with pytest.raises(KinemarkError, match=r"gait\.json is given twice"):
        reference_of_files([*controls, controls[0]], output=walk / "other.json", source="")


def test_exports_have_y_up_and_unknown_ones_are_refused(walk):
    given = read_trial(walk / "walk.c3d").trajectories
    files = SubjectFiles([walk / "walk.c3d"], measures=walk / "anna.toml")
    options = {"folder": walk / "out", "settings": QUICK}
    gait_of_files(files, **options, exports="trc, mot,sto,gcd")
    back = read_trial(walk / "out" / "walk.trc").trajectories
    x, y, z = np.moveaxis(given["LKNE"].xyz, -1, 0)
    np.testing.assert_allclose(back["LKNE"].xyz, np.stack([x, z, -y], -1), atol=1e-3)
    assert "LKneeAngles_flexion" in (walk / "out" / "walk_angles.mot").read_text()
    assert "!LeftKneeFlexExt" in (walk / "out" / "gait.gcd").read_text()
    assert not (walk / "out" / "walk_reaction.mot").exists()  # there are no plates
    with pytest.raises(KinemarkError, match="no export 'xlsx'"):
        gait_of_files(files, **options, exports="xlsx")


def test_events_of_the_file_that_nobody_sees_are_absent_and_not_late(walk):
    paths = read_trial(walk / "walk.c3d").trajectories
    found = gait_of_files(SubjectFiles([walk / "walk.c3d"], measures=walk / "anna.toml"), settings=QUICK)
    first = next(e for e in found.trials[0].events if e.side == "left" and e.strike)
    between = [first.time + 0.02, first.time + 0.08, first.time + 0.55]  # s; near, off, and in the middle of a stride
    told = Events(("Foot Strike",) * 3, ("Left",) * 3, np.array(between))
    write_c3d(walk / "told.c3d", Trial("told", paths, events=told))
    figures = gait_of_files(SubjectFiles([walk / "told.c3d"], measures=walk / "anna.toml"), settings=QUICK).figures
    by_kind = {f["kind"]: f["values"] for f in figures["findings"]}
    assert by_kind["file_events_not_found"]["events"] == 1
    assert by_kind["file_events_differ"]["events"] == 1 and by_kind["file_events_differ"]["most_ms"] < 100


def test_who_turns_is_told(walk):
    paths = read_trial(walk / "walk.c3d").trajectories
    angle = np.radians(np.clip(np.arange(paths.n_frames) - 200, 0, 150) * 0.6)
    turn = np.stack([[np.cos(angle), -np.sin(angle), 0 * angle], [np.sin(angle), np.cos(angle), 0 * angle],
                     [0 * angle, 0 * angle, 1 + 0 * angle]]).transpose(2, 0, 1)  # fmt: skip
    turned = replace(paths, paths=tuple(replace(p, xyz=np.einsum("fij,fj->fi", turn, p.xyz)) for p in paths))
    write_c3d(walk / "turn.c3d", Trial("turn", turned))
    told = [
        {
            f["kind"]
            for f in gait_of_files(SubjectFiles([walk / f], measures=walk / "anna.toml"), settings=QUICK).figures[
                "findings"
            ]
        }
        for f in ("walk.c3d", "turn.c3d")
    ]
    assert not told[0] & {"gait_turns", "gait_turns_left_out"} and "gait_turns_left_out" in told[1]


def test_without_walks_it_is_said_what_to_give():
    with pytest.raises(KinemarkError, match="one or more"):
        gait_of_files(SubjectFiles([]))


def test_nothing_that_was_given_is_changed(walk):
    before = (walk / "walk.c3d").read_bytes()
    gait_of_files(SubjectFiles([walk / "walk.c3d"], measures=walk / "anna.toml"), settings=QUICK)
    assert (walk / "walk.c3d").read_bytes() == before


@pytest.mark.parametrize(
    ("given", "exports"), [(["walk.trc"], "trc"), (["walk.c3d", "walk_gait.c3d"], ""), (["a/gait.gcd"], "gcd")]
)
def test_no_result_overwrites_a_file_that_was_given(tmp_path, given, exports):
    for name in given:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(b"a recording")
    into = (tmp_path / given[-1]).parent
    with pytest.raises(KinemarkError, match=r"would overwrite .*Give them a folder without recordings: -o"):
        gait_of_files(
            SubjectFiles([tmp_path / name for name in given]), folder=into / ".." / into.name, exports=exports
        )
    assert all((tmp_path / name).read_bytes() == b"a recording" for name in given)
    assert sorted(p.name for p in into.iterdir()) == sorted(Path(name).name for name in given)


def test_trials_of_one_name_keep_their_rows_files_and_subjects(walk):
    """Of two sessions, whose folders tell them apart, and of a standing trial that is called as a walk."""
    trial = read_trial(walk / "walk.c3d")
    for k, (folder, subject) in enumerate((("a", "Anna"), ("b", "Anna"), ("s", "Ben"))):
        (walk / folder).mkdir()
        own = replace(moved(trial, 150.0 * k), about={**trial.about, "subject": subject})
        write_c3d(walk / folder / "w.c3d", own)
    walks = [walk / "a" / "w.c3d", walk / "b" / "w.c3d"]
    files = SubjectFiles(walks, static=walk / "s" / "w.c3d", measures=walk / "anna.toml")
    found = gait_of_files(files, folder=walk / "out", settings=QUICK)
    for name in ("key_values", "time_distance"):
        with (walk / "out" / f"{name}.csv").open() as file:
            assert {row["trial"] for row in csv.DictReader(file)} == {"a_w", "b_w"}
    assert {p.name for p in (walk / "out").glob("*.c3d")} == {"a_w_gait.c3d", "b_w_gait.c3d"}
    assert "a_w, b_w" in (walk / "out" / "gait.html").read_text()
    said = next(f["text"] for f in found.figures["findings"] if f["kind"] == "gait_subjects_differ")
    assert "Anna (a_w, b_w), Ben (s_w)" in said


def test_names_of_trials_are_as_short_as_they_may_be(tmp_path):
    given = ["v.c3d", "a/w.c3d", "a/w.trc", "b/w.c3d", "x/a/u.c3d", "y/a/u.c3d"]
    names = trial_names(tmp_path / name for name in given)
    short = ["v", "w_c3d", "w_trc", "b_w"]
    assert [names[(tmp_path / name).resolve()] for name in given[:4]] == short
    assert len(set(names.values())) == len(given)


def test_a_recording_in_two_formats_counts_once_where_a_folder_was_named(tmp_path):
    there = [tmp_path / name for name in ("v.trc", "w.c3d", "w.tdf", "w.trc", "x.c3d", "x.trc")]
    kept, left_out = one_of_each(there, [tmp_path, tmp_path / "x.trc"])
    assert [path.name for path in kept] == ["v.trc", "w.c3d", "x.trc"]
    assert [path.name for path in left_out] == ["w.tdf", "w.trc", "x.c3d"]
    assert one_of_each(there, there) == (tuple(there), ())  # who names both wants both
    with pytest.raises(KinemarkError, match=r"would overwrite .*w\.trc"):
        gait_of_files(SubjectFiles(kept[1:2], left_out=left_out), folder=tmp_path, exports="trc")


def test_a_trial_without_strides_leaves_the_result_of_the_others(tmp_path):
    leg = LegMeasures(890.0, 105.0, 72.0)
    lab = gait_laboratory(WalkingBody(SubjectMeasures(leg, leg, mass_kg=70.0)), duration_s=3.0, rate=50.0)
    for name in ("walk", "static"):
        write_c3d(tmp_path / f"{name}.c3d", getattr(lab, name))
    walks = [tmp_path / "static.c3d", tmp_path / "walk.c3d"]
    twice = tmp_path / "walk.trc"
    found = gait_of_files(SubjectFiles(walks, left_out=[twice]), folder=tmp_path / "out", settings=QUICK)
    assert [file_note_text(note) for note in found.notes if str(twice) in note.names]
    told = next(f for f in found.figures["findings"] if f["kind"] == "gait_without_strides")
    assert told["severity"] == "amber" and f'--static "{walks[0]}"' in told["advice"]
    assert found.figures["verdict"]["grade"] == "amber"
    assert "measured to" not in panels_figure(found.curves, KINEMATICS).to_json()


def test_a_foot_beside_the_plates_has_no_moments(tmp_path):
    walk, static = (shared_data(f"mocap3d/{ADULT}{name}3_FF.c3d") for name in ("Motion", "Calibration"))
    found = gait_of_files(SubjectFiles([walk], static=static), folder=tmp_path, settings=QUICK)
    right = next(c for c in found.curves if c.name == "RAnkleMoment")
    stance = right.values[:, 20:50, 0]
    whole = np.isfinite(stance).all(1)
    assert whole.any() and not whole.all()
    assert np.nanmin(np.nanmax(stance[whole], axis=1)) > 1.0  # N·m/kg of push-off, in every stride that has one


@pytest.mark.parametrize(("asked", "status"), [((), 3), (("--fail-on", "never"), 0)])
def test_a_script_sees_that_there_is_no_result(tmp_path, asked, status):
    leg = LegMeasures(leg_mm=890.0, knee_mm=105.0, ankle_mm=72.0)
    body = WalkingBody(SubjectMeasures(leg, leg, mass_kg=70.0))
    write_c3d(tmp_path / "standing.c3d", gait_laboratory(body, seed=1).static)
    with pytest.raises(SystemExit) as ended:
        app(["gait", str(tmp_path / "standing.c3d"), "--no-uncertainty", *asked])
    assert (ended.value.code or 0) == status


@pytest.mark.parametrize("flat", [True, False])
def test_feet_that_the_file_took_the_other_way_are_told(flat, tmp_path):
    """The whole body's static trial was processed without a flat foot."""
    walk, static = (shared_data(f"mocap3d/pig_wholebody/{name}_trial.c3d") for name in ("Movement", "Static"))
    settings = replace(QUICK, flat_foot=flat)
    found = gait_of_files(SubjectFiles([walk], static=static), settings=settings, folder=tmp_path).figures["findings"]
    told = [f for f in found if f["kind"] == "gait_feet_otherwise"]
    assert len(told) == flat
    if flat:
        assert "--no-flat-foot" in str(told) and told[0]["values"]["by_deg"] == pytest.approx(2.3, abs=0.05)


def test_the_trunk_has_its_place_on_the_page_and_is_printed_with_moments_and_powers(tmp_path):
    """A row of three panels is not left alone on a printed page."""
    walk, static = (shared_data(f"mocap3d/pig_wholebody/{name}_trial.c3d") for name in ("Movement", "Static"))
    gait_of_files(SubjectFiles([walk], static=static), settings=QUICK, folder=tmp_path)
    page = (tmp_path / "gait.html").read_text()
    places = [page.index(f'<section id="{name}">') for name in ("kinematics", "trunk", "kinetics")]
    assert places == sorted(places) and '<a href="#trunk">' in page
    assert "#trunk + #kinetics { break-before: auto; }" in page


def test_one_stride_that_ends_with_the_recording_has_no_speed_and_gives_no_warning(tmp_path):
    whole = read_trial(shared_data("mocap3d/pig_gait_child/HC030A05.c3d"))
    paths = tuple(MarkerTrajectory.measured(p.name, p.xyz[:120]) for p in whole.trajectories)
    write_c3d(tmp_path / "walk.c3d", Trial("walk", Trajectories(paths, whole.trajectories.rate)))
    found = gait_of_files(SubjectFiles([tmp_path / "walk.c3d"]), settings=QUICK)  # warnings are errors here
    said = {one["kind"]: one["values"] for one in found.figures["verdict"]["statements"]}
    assert said["gait_measured"]["speed"] is None and said["gait_measured"]["right_strides"] == 1


def test_a_recording_under_two_names_counts_once(walk, capsys):
    """A folder held a walk and its processed copy: every step counted twice, and spreads were too small."""
    trial = read_trial(walk / "walk.c3d")
    cut = replace(trial, trajectories=trial.trajectories.frames(40, trial.trajectories.n_frames))
    write_c3d(walk / "walk_processed.c3d", cut)
    alone = gait_of_files(SubjectFiles([walk / "walk.c3d"], measures=walk / "anna.toml"), settings=QUICK).figures
    with pytest.raises(SystemExit) as ended:
        app(["gait", str(walk), "--measures", str(walk / "anna.toml"), "--no-uncertainty", "-o", str(walk / "all")])
    assert ended.value.code == 0
    assert "walk_processed is the same recording as walk." in capsys.readouterr().out
    figures = json.loads((walk / "all/gait.json").read_text())
    assert figures["time_distance"] == alone["time_distance"]
    assert [trial["name"] for trial in figures["trials"]] == ["walk"]


def test_where_nothing_was_measured_there_is_no_table_of_nothing(walk, capsys):
    """A static trial given as walk showed twelve lines without a number."""
    leg = LegMeasures(880, 100, 70)
    lab = gait_laboratory(WalkingBody(SubjectMeasures(leg, leg, mass_kg=70.0)), duration_s=2.0)
    write_c3d(walk / "standing.c3d", lab.static)
    with pytest.raises(SystemExit):
        app(["gait", str(walk / "standing.c3d"), "--no-uncertainty"])
    assert "walking speed" not in (out := capsys.readouterr().out) and "no foot strikes the floor twice" in out


def test_walks_themselves_are_no_conditions_to_compare(walk):
    """A C3D was refused as "a binary file, wanted text"."""
    with pytest.raises(KinemarkError, match=r"no gait\.json of kinemark gait. Run it"):
        compare_gait(walk / "walk.c3d", walk / "other.c3d", folder=walk / "compared")
