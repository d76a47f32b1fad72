"""From a file to angles in CSV, C3D and a page; models as files; what is wrong is said."""

import csv
import json
import re
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

from kinemark.apps import cli
from kinemark.data import Angles, Cloud, Events, KinemarkError, MarkerTrajectory, Tracks, Trajectories, Trial, same
from kinemark.engine.angles.of_trial import AngleSettings, angles_of_file, model_of_file, trial_angles, with_angles
from kinemark.findings.angles import _jumps
from kinemark.io.c3d import read_c3d, write_c3d
from kinemark.io.model_toml import load_model
from kinemark.io.records import save
from kinemark.io.trial import read_trial
from kinemark.kinematics import joint_angles, named_angles, with_marker_sd
from kinemark.kinematics.chain import points_of
from kinemark.report.angles_page import angles_page
from kinemark.report.drawing_library import library_name
from kinemark.report.figures_angles import joint_figure
from kinemark.report.stick import MOST_FRAMES, stick_data
from kinemark.synth import walking
from kinemark.synth.arm import arm
from support.drawings import checked
from support.findings import found, kinds
from support.schema import check_findings
from support.shared import shared_data

UM2AS = load_model("um2as")


def eating(*, duration_s=6.0, sd=0.7, hole=True, first_frame=1):
    subject = arm(duration_s=duration_s, seed=2)
    xyz = subject.xyz + sd * np.random.default_rng(3).normal(size=subject.xyz.shape)
    if hole:
        xyz[3, 100:115] = np.nan
    paths = tuple(MarkerTrajectory.measured(n, x) for n, x in zip(subject.names, xyz, strict=True))
    events = Events(("Reach",) * 2 + ("Bite",), ("Right",) * 3, np.array([0.0, 3.0, 1.3]) + (first_frame - 1) / 50)
    return Trial("eating", Trajectories(paths, 50.0, first_frame), events=events), subject.angles


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("angles")
    trial, truth = eating()
    write_c3d(folder / "eating.c3d", trial)
    settings = AngleSettings(cycle=("0-3", "3-5.9"), marker_sd_mm=0.7)
    return angles_of_file(folder / "eating.c3d", model="um2as", settings=settings), truth


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    return {
        name: np.array([float(c) if c else np.nan for c in column])
        for name, column in zip(head, np.array(rows).T, strict=True)
    }


def test_csv_has_angles_with_their_sd_and_marks(written):
    result, truth = written
    table = rows_of(result.folder / "angles.csv")
    assert table["frame"][0] == 1 and np.isclose(table["time_s"][-1], 299 / 50)
    for column, (j, t) in {
        "shoulder_flexion": (0, 0),
        "elbow_pronation": (1, 2),
        "wrist_ulnar_deviation": (2, 1),
    }.items():
        found, sd = table[f"{column}_deg"], table[f"{column}_sd_deg"]
        assert np.allclose(found, result.angles.deg[j, :, t], atol=1e-6, equal_nan=True)
        z = ((found - truth.deg[j, :, t]) / sd)[np.isfinite(found)]
        assert 0.85 < z.std() < 1.15 and abs(z.mean()) < 0.25  # the SD is that of the error
        assert np.isnan(found[100:115]).all() and not table[f"{column}_outside"].any()
    assert not table["elbow_locked"].any()
    cycles = rows_of(result.folder / "cycles.csv")
    assert len(cycles["percent"]) == 101 and np.nanmax(cycles["elbow_flexion_sd_deg"]) < 8


def test_c3d_keeps_the_trial_and_gains_angles(written):
    result, _ = written
    before, after = (read_c3d(p) for p in (result.folder.parent / "eating.c3d", result.folder / "eating_angles.c3d"))
    assert same(after.trajectories, before.trajectories) and after.events.label == before.events.label
    assert after.source.texts("POINT", "ANGLES") == (
        "shoulder",
        "elbow",
        "wrist",
        "shoulder SD",
        "elbow SD",
        "wrist SD",
    )
    for j, joint in enumerate(result.angles.joints):
        signal = after.signals[joint]
        assert (signal.kind, signal.unit, signal.rate) == ("angle", "deg", 50.0)
        assert np.allclose(signal.values, result.angles.deg[j], atol=1e-4, equal_nan=True)
        assert np.allclose(signal.sd, result.angles.sd[j], atol=1e-4, equal_nan=True)
    assert after.signals["shoulder"].axes == ("flexion", "adduction", "internal rotation")
    again = with_angles(after, result.angles, result.model)  # replaced, not doubled
    assert again.signals.names == after.signals.names == ("shoulder", "elbow", "wrist")
    with pytest.raises(KinemarkError, match="frames"):
        with_angles(eating(duration_s=1.0)[0], result.angles, result.model)
    named = replace(
        before,
        trajectories=replace(before.trajectories, paths=(MarkerTrajectory.measured("elbow", np.ones((300, 3))),)),
    )
    with pytest.raises(KinemarkError, match="a marker called elbow"):
        with_angles(named, result.angles, result.model)


def test_angles_keep_their_lock_in_records(tmp_path):
    deg = np.zeros((1, 4, 3))
    angles = Angles(("j",), ("zxy",), deg, np.zeros((1, 4, 3, 3)), 50.0, np.array([[True, False, True, False]]))
    assert angles.locked.sum() == 2 and not Angles(("j",), ("zxy",), deg, np.zeros((1, 4, 3, 3)), 50.0).locked.any()
    with pytest.raises(ValueError, match="locked has shape"):
        Angles(("j",), ("zxy",), deg, np.zeros((1, 4, 3, 3)), 50.0, np.zeros((2, 4), bool))


def test_the_page_needs_nothing_else_and_tells_what_it_knows(written):
    result, _ = written
    html = (result.folder / "angles.html").read_text(encoding="utf-8")
    body = re.sub(r"<script>.*?</script>", "", html, flags=re.S)
    addresses = re.findall(r"""(?:src|href)=["'](?!#)([^"']*)""", body)
    assert addresses == [f"assets/{library_name()}"] and "@import" not in body
    assert (result.folder / addresses[0]).is_file()
    assert "default-src 'none'" in html and html.count('id="stick"') == 1
    for text in (
        "15 frames without angles of: shoulder, elbow, wrist",
        "0.7 mm along each axis",
        "Gimbal lock",
        "Cycles",
    ):
        assert text in html
    ids = re.findall(r'id="((?:joint|cycle)\d)"', html)
    assert sorted(ids) == ["cycle0", "cycle1", "cycle2", "joint0", "joint1", "joint2"]
    figures = json.loads((result.folder / "angles.json").read_text())
    assert figures["verdict"]["grade"] == "green" and len(figures["angles"]) == 8
    check_findings(figures)


def test_the_stick_figure_is_the_markers_seen_from_the_laboratory(written):
    result, _ = written
    data = stick_data(result.points, result.angles, UM2AS)
    frames = np.array([[p or [np.nan] * 3 for p in f] for f in data["frames"]])
    want = np.array([result.points[n] for n in data["names"]]).transpose(1, 0, 2)
    assert np.allclose(frames, want * [1, -1, 1], atol=0.06, equal_nan=True)  # right is −y where forward is x and up z
    assert {frozenset((data["names"][i], data["names"][j])) for i, j, _ in data["links"]} == {
        frozenset(link) for link in UM2AS.links
    }
    assert [row["name"] for row in data["angles"] if "deg" not in row] == ["shoulder", "elbow", "wrist"]
    turned = replace(UM2AS, up="+y", forward="-z")
    swapped = stick_data({n: x[:, [1, 2, 0]] * [-1, 1, -1] for n, x in result.points.items()}, result.angles, turned)
    again = np.array([p or [np.nan] * 3 for f in swapped["frames"] for p in f])
    assert np.allclose(again, frames.reshape(-1, 3), atol=0.06, equal_nan=True)


def test_long_trials_are_thinned_in_the_stick_figure():
    trial, _ = eating(duration_s=40.0, hole=False)
    result = trial_angles(trial, model=UM2AS)
    data = stick_data(result.points, result.angles, UM2AS)
    assert len(data["frames"]) <= MOST_FRAMES and np.isclose(data["step"] * len(data["frames"]), 40.0, atol=0.1)
    assert all(len(row["deg"]) == len(data["frames"]) for row in data["angles"] if "deg" in row)


def test_names_from_files_cannot_leave_their_place_in_the_page():
    trial, _ = eating(duration_s=1.0, hole=False)
    nasty = "</script><b onload=x>"
    model = replace(UM2AS, name=nasty, aliases={}, joints=tuple(replace(j, name=nasty + j.name) for j in UM2AS.joints))
    result = trial_angles(replace(trial, name=nasty), model=model)
    html = angles_page(figures=result.figures, angles=result.angles, model=model, points=result.points)
    assert nasty not in html and "&lt;/script&gt;" in html


def test_ranges_locks_and_joints_without_frames_are_told():
    trial, _ = eating(hole=False)
    narrow = tuple(
        replace(j, motions=tuple(None if m is None else replace(m, normal=(0.0, 100.0)) for m in j.motions))
        for j in UM2AS.joints
    )
    result = trial_angles(trial, model=replace(UM2AS, joints=narrow), settings=AngleSettings(lock_deg=85.0))
    beyond = [(one.values["joint"], one.values["angle"]) for one in found(result.figures, "angle_beyond_normal")]
    assert ("elbow", "flexion/extension") in beyond
    assert all(one.frames for one in found(result.figures, "gimbal_lock"))
    assert "gimbal_lock" in kinds(result.figures, "amber") and result.figures["verdict"]["grade"] == "amber"
    table = next(row for row in result.figures["angles"] if row["joint"] == "elbow" and row["positive"] == "flexion")
    assert table["frames"] == 300 and table["outside_frames"] > 0  # marked, not hidden
    shapes = checked(joint_figure(result.angles, result.model, 1)).layout.shapes
    assert sum(shape.type == "line" and shape.y0 == 100.0 for shape in shapes) == 1  # the limit of flexion
    assert sum(shape.type == "rect" for shape in shapes) == 2 * len(result.figures["joints"][1]["locked"])
    blind = replace(trial, trajectories=replace(trial.trajectories, paths=tuple(
        MarkerTrajectory.measured(p.name, np.full_like(p.xyz, np.nan)) if p.name == "MC37" else p
        for p in trial.trajectories
    )))  # fmt: skip
    without = trial_angles(blind, model=UM2AS)
    assert without.figures["verdict"]["grade"] == "red" and np.isfinite(without.angles.deg[:2]).all()
    assert [one.values["joints_list"] for one in found(without.figures, "joints_without_angles")] == [("wrist",)]
    page = angles_page(figures=without.figures, angles=without.angles, model=UM2AS, points=without.points)
    assert "No frame has angles of: wrist" in page


@pytest.mark.parametrize(("sd", "origin"), [(None, "estimated"), (2.0, "assumed")])
def test_it_is_said_where_the_sd_comes_from(sd, origin):
    trial, _ = eating(hole=False)
    result = trial_angles(trial, model=UM2AS, settings=AngleSettings(marker_sd_mm=sd))
    assert result.figures["noise_from"] == origin
    assert abs(result.figures["marker_sd_mm"] / (sd or 0.7) - 1) < 0.1
    stated = replace(trial, trajectories=with_marker_sd(trial.trajectories, 1.5))
    known = trial_angles(stated, model=UM2AS, settings=AngleSettings(marker_sd_mm=sd))
    assert known.figures["noise_from"] == "stated" and abs(known.figures["marker_sd_mm"] - 1.5) < 1e-9


def test_paths_that_were_smoothed_before_are_noticed():
    trial, _ = eating(sd=0.0, hole=False)
    result = trial_angles(trial, model=UM2AS)
    assert "markers_smoothed_before" in kinds(result.figures)


@pytest.mark.parametrize("smoothing", ["butterworth", "woltring"])
def test_smoothing_brings_angles_nearer_to_the_truth(smoothing):
    trial, truth = eating(hole=False)
    raw, smooth = (
        trial_angles(trial, model=UM2AS, settings=AngleSettings(smoothing=s, marker_sd_mm=0.7))
        for s in ("none", smoothing)
    )
    error = [np.abs(r.angles.deg - truth.deg)[..., :].mean() for r in (raw, smooth)]
    assert error[1] < 0.6 * error[0]
    assert (np.nanmedian(smooth.angles.sd, 1) < np.nanmedian(raw.angles.sd, 1)).sum() >= 8
    assert smoothing.title() in smooth.figures["smoothing"]


def test_cycles_by_events_count_from_the_recordings_start():
    trial, _ = eating(hole=False, first_frame=201)
    by_event = trial_angles(trial, model=UM2AS, settings=AngleSettings(cycle_event="Reach"))
    by_time = trial_angles(trial, model=UM2AS, settings=AngleSettings(cycle=("4-7",)))
    assert np.allclose(by_event.cycles.spans, [[0, 3]]) and np.allclose(by_event.cycles.mean, by_time.cycles.mean)
    for cycle, message in (("5", "no span of time"), ("7-4", "no span"), ("0-2", "is not in"), ("a-b", "no span")):
        with pytest.raises(KinemarkError, match=message):
            trial_angles(trial, model=UM2AS, settings=AngleSettings(cycle=(cycle,)))
    with pytest.raises(KinemarkError, match="there are Bite, Reach"):
        trial_angles(trial, model=UM2AS, settings=AngleSettings(cycle_event="Strike"))


def test_settings_refuse_what_goes_not_together():
    for bad, message in (
        (dict(cutoff_hz=6.0), "without a smoothing"),
        (dict(cycle=("0-1",), cycle_event="Reach"), "Choose one"),
        (dict(marker_sd_mm=0.0), "--marker-sd-mm is 0.0"),
        (dict(lock_deg=95.0), "--lock-deg is 95.0"),
    ):
        with pytest.raises(KinemarkError, match=message):
            AngleSettings(**bad)
    trial, _ = eating(duration_s=2.0, hole=False)
    with pytest.raises(KinemarkError, match="Change --cutoff-hz"):
        trial_angles(trial, model=UM2AS, settings=AngleSettings(smoothing="butterworth", cutoff_hz=30.0))
    empty = Trial("empty", Trajectories((), 50.0))
    with pytest.raises(KinemarkError, match="no frames"):
        trial_angles(empty, model=UM2AS)


def run(*words):
    try:
        cli.app([str(w) for w in words])
    except SystemExit as end:
        assert end.code in (0, None)


def test_the_command_prints_a_summary_or_json(tmp_path, capsys):
    trial, _ = eating(duration_s=3.0)
    write_c3d(tmp_path / "eating.c3d", trial)
    run("angles", tmp_path / "eating.c3d", "--model", "um2as", "--output", tmp_path / "out", "--marker-sd-mm", 0.7)
    said = capsys.readouterr().out
    assert "elbow flexion/extension" in said and str(tmp_path / "out") in said
    run(
        "angles",
        tmp_path / "eating.c3d",
        "--model",
        "um2as",
        "--inverse-cosines",
        "--cycle",
        "0-1",
        "--cycle",
        "1-2",
        "--json",
    )
    figures = json.loads(capsys.readouterr().out)
    assert figures["method"].startswith("By inverse cosines") and len(figures["cycles"]["spans_s"]) == 2
    assert (tmp_path / "eating_angles" / "cycles.csv").is_file()
    with pytest.raises(KinemarkError, match=r"neither a model nor a file. Models are isb_shoulder"):
        angles_of_file(tmp_path / "eating.c3d", model="nobody")


def test_without_a_model_the_one_whose_markers_are_there_is_taken(tmp_path, capsys):
    """Of lower limbs, which no such model describes, the angles are the gait model's."""
    trial, _ = eating(duration_s=1.0, hole=False)
    write_c3d(tmp_path / "eating.c3d", trial)
    run("angles", tmp_path / "eating.c3d", "--json")
    assert json.loads(capsys.readouterr().out)["model"] == "um2as"
    write_c3d(tmp_path / "walk.c3d", Trial("walk", walking(duration_s=2.0, rate=50.0, seed=1).trajectories))
    run("angles", tmp_path / "walk.c3d", "--fail-on", "never", "--json")
    capsys.readouterr()
    signals = read_c3d(tmp_path / "walk_angles" / "walk_gait.c3d").signals
    assert {"LHipAngles", "RKneeAngles", "RAnkleAngles"} <= set(signals.names)
    with pytest.raises(KinemarkError, match="have other options: kinemark gait"):
        cli.app(["angles", str(tmp_path / "walk.c3d"), "--lock-deg", "5"], exit_on_error=False)
    write_c3d(tmp_path / "few.c3d", replace(trial, trajectories=trial.trajectories.select(["ACR1", "ACR2"])))
    with pytest.raises(KinemarkError, match=r"none of the models isb_shoulder, .* gait model, which wants LASI"):
        model_of_file(tmp_path / "few.c3d")


def test_tracks_pass_on_the_covariance_of_their_reconstruction(tmp_path):
    """What C3D cannot hold is in the HDF5 file of tracks."""
    trial, _ = eating(duration_s=1.0, hole=False)
    m, f = len(trial.trajectories), trial.trajectories.n_frames
    sd = np.linspace(0.3, 0.9, m)
    cov = np.tile((sd**2)[:, None, None] * np.eye(3), (f, 1, 1))
    start, unknown = np.arange(f + 1) * m, np.zeros((f * m, 2), int)
    cloud = Cloud(50.0, start, trial.trajectories.xyz.transpose(1, 0, 2).reshape(-1, 3), cov, np.zeros(f * m), unknown)
    save(tmp_path / "tracks.h5", Tracks(cloud, np.tile(np.arange(m), f)))
    names = [p.name for p in trial.trajectories]
    model = replace(UM2AS, aliases={name: (f"*{k}",) for k, name in enumerate(names, 1)})
    found = trial_angles(read_trial(tmp_path / "tracks.h5"), model=model)
    stated = replace(trial.trajectories, paths=tuple(
        replace(p, cov=np.tile(s**2 * np.eye(3), (f, 1, 1))) for p, s in zip(trial.trajectories, sd, strict=True)
    ))  # fmt: skip
    assert found.figures["noise_from"] == "stated"
    assert np.allclose(found.angles.sd, joint_angles(stated, model=UM2AS).sd)


def test_real_left_arm_from_the_command_line(tmp_path, capsys):
    folder = shared_data("mocap3d/ulema_hand_to_head")
    run(
        "angles", folder / "HTH1.c3d", "--model", "isb_upper_limb", "--side", "left", "--output", tmp_path / "out",
        "--marker-sd-mm", 0.5, "--json",
    )  # fmt: skip
    figures = json.loads(capsys.readouterr().out)
    flexion = next(row for row in figures["angles"] if row["joint"] == "elbow" and row["positive"] == "flexion")
    assert flexion["frames"] == 993 and 88 < flexion["range_deg"] < 90 and 0.05 < flexion["sd_median_deg"] < 1
    after = read_c3d(tmp_path / "out" / "HTH1_angles.c3d")
    assert "LElbowFlExt" in after.source.texts("POINT", "ANGLES") and "elbow" in after.signals.names
    assert set(points_of(after.trajectories)) == set(points_of(read_c3d(folder / "HTH1.c3d").trajectories))


def test_clusters_static_and_functional_trials_from_the_command_line(tmp_path, capsys):
    """A model of one's own: ISB with ULEMA's clusters, and the glenohumeral centre from circling."""
    folder = shared_data("mocap3d/ulema_hand_to_head")
    text = files("kinemark.kinematics").joinpath("models/isb_upper_limb.toml").read_text(encoding="utf-8")
    bodies = {
        "thorax": ("ST", 3, ["C7", "T8", "IJ", "PX"]),
        "scapula": ("LACR", 3, []),
        "upper arm": ("LUA", 4, ["EL", "EM"]),
        "forearm": ("LLA", 4, ["RS", "US"]),
        "hand": ("LH", 3, ["MC3", "MCP2", "MCP3", "MCP5"]),
    }
    for name, (marker, n, points) in bodies.items():
        markers_ = [f"{marker}{k}" for k in range(1, n + 1)]
        text += f'\n[[cluster]]\nname = "{name}"\nmarkers = {json.dumps(markers_)}\npoints = {json.dumps(points)}\n'
    text += '\n[[centre]]\nname = "GH"\nbetween = ["upper arm", "scapula"]\n'
    (tmp_path / "own.toml").write_text(text, encoding="utf-8")
    run(
        "angles", folder / "HTH1.c3d", "--model", tmp_path / "own.toml", "--side", "left", "--marker-sd-mm", 0.5,
        "--static", folder / "calMARKERS.c3d", "--functional", folder / "GHr.c3d", "--output", tmp_path / "out",
        "--json",
    )  # fmt: skip
    rows = {(r["joint"], r["positive"]): r for r in json.loads(capsys.readouterr().out)["angles"]}
    assert abs(rows["elbow", "flexion"]["range_deg"] - 88.9) < 2  # ULEMA's, whose centre lies 13 mm away
    assert rows["elbow", "flexion"]["frames"] == 993 and rows["wrist", "flexion"]["sd_median_deg"] < 3
    with pytest.raises(KinemarkError, match="Give --static"):
        angles_of_file(folder / "HTH1.c3d", model="um2as", functional=folder / "GHr.c3d")


def upper_limb(side, names=lambda marker, letter: f"{letter}{marker}"):
    """A trial of the markers that isb_upper_limb wants, of one side by their names; x is mirrored for a left one."""
    model = load_model("isb_upper_limb", side=side)
    rng = np.random.default_rng(8)
    trunk = ("C7", "T8", "IJ", "PX")
    paths = []
    for name in model.markers:
        place = rng.normal(0, 300, 3) + np.cumsum(rng.normal(0, 0.5, (40, 3)), 0)
        paths.append(MarkerTrajectory.measured(name if name in trunk else names(name, side[0].upper()), place))
    return Trial(side, Trajectories(tuple(paths), 50.0))


@pytest.mark.parametrize("side", ["right", "left"])
def test_the_side_follows_from_the_names_of_the_markers_and_is_said(side, tmp_path):
    write_c3d(tmp_path / "trial.c3d", upper_limb(side))
    result = angles_of_file(tmp_path / "trial.c3d", model="isb_upper_limb")
    assert result.figures["side"] == result.model.side == side
    said = found(result.figures, "side_of_markers")
    assert [one.values["side"] for one in said] == ([] if side == "right" else ["left"])
    if side == "left":
        stated = angles_of_file(
            tmp_path / "trial.c3d", model="isb_upper_limb", folder=tmp_path / "s", settings=AngleSettings(side="left")
        )
        assert same(result.angles, stated.angles) and not found(stated.figures, "side_of_markers")
        with pytest.raises(KinemarkError, match="wants the markers"):
            angles_of_file(tmp_path / "trial.c3d", model="isb_upper_limb", settings=AngleSettings(side="right"))


def test_names_without_a_side_leave_the_models_own(tmp_path):
    write_c3d(tmp_path / "trial.c3d", upper_limb("left", names=lambda marker, letter: marker))
    assert angles_of_file(tmp_path / "trial.c3d", model="isb_upper_limb").figures["side"] == "right"


def test_a_jump_is_noticed_and_a_steady_trial_has_none():
    trial, _ = eating(hole=False)
    assert not found(trial_angles(trial, model=UM2AS).figures, "angle_jumps")
    xyz = trial.trajectories.xyz.copy()
    xyz[[4, 5], 120:140] = xyz[[5, 4], 120:140]  # the markers of the wrist are exchanged for a while
    paths = tuple(replace(p, xyz=x) for p, x in zip(trial.trajectories, xyz, strict=True))
    jumping = replace(trial, trajectories=replace(trial.trajectories, paths=paths))
    said = found(trial_angles(jumping, model=UM2AS).figures, "angle_jumps")
    assert said and {frame for one in said for frame in one.frames} == {(120, 121), (140, 141)}


@pytest.mark.parametrize("back", [False, True])
def test_a_marker_that_leaps_alone_is_noticed_by_what_the_angle_does_about_it(back):
    """A leap far below what an arm may turn, where the angle hardly moves before and after: a step, and a spike."""
    trial, _ = eating(hole=False)
    xyz = trial.trajectories.xyz.copy()
    xyz[4, 120 : 121 if back else None] += [0, 0, 60.0]
    paths = tuple(replace(p, xyz=x) for p, x in zip(trial.trajectories, xyz, strict=True))
    leaping = replace(trial, trajectories=replace(trial.trajectories, paths=paths))
    said = found(trial_angles(leaping, model=UM2AS).figures, "angle_jumps")
    assert said and {frame for one in said for frame in one.frames} == {(120, 121), *([(121, 122)] * back)}
    assert all(one.values["most_deg"] < 45 for one in said)


@pytest.mark.parametrize("rate", [25.0, 100.0])
def test_a_quick_motion_between_two_rests_is_no_jump(rate):
    """A finger or a head goes 30° in 0.12 s, which are three frames at 25 Hz."""
    t = np.arange(round(3 * rate)) / rate
    u = np.clip((t[:, None] - [0.51, 1.23, 2.02]) / 0.12, 0, 1)
    deg = 30 * (10 * u**3 - 15 * u**4 + 6 * u**5) @ [1, -1, 1]
    joints = len(UM2AS.joints)
    angles = Angles(
        tuple(joint.name for joint in UM2AS.joints), ("zxy",) * joints, np.tile(deg[:, None], (joints, 1, 3)),
        np.full((joints, len(t), 3, 3), np.nan), rate,
    )  # fmt: skip
    assert not list(_jumps(angles, UM2AS, 1))
    jump = np.where(np.arange(len(t)) < 40, 0.0, 25.0 if rate == 100 else 95.0)
    jumping = replace(angles, deg=angles.deg + jump[:, None])
    assert len(list(_jumps(jumping, UM2AS, 1))) == len(named_angles(UM2AS))
