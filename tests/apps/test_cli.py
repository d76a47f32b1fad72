"""The command line, the formats behind it, the simulation and the demonstration."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import kinemark
from kinemark.apps.demo import demo
from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories, Trial, same
from kinemark.engine.formats import convert, describe
from kinemark.engine.session import Session
from kinemark.engine.simulate import Scene, simulate
from kinemark.io.c3d import read_c3d, write_c3d
from kinemark.io.detections_csv import read_detections_csv
from kinemark.io.records import load, save
from kinemark.io.rig_toml import read_rig_toml, write_rig_toml
from kinemark.io.trc import read_trc
from kinemark.synth.score import score
from support.laboratory import observe, ring
from support.motions import swarm
from support.shared import shared_data


def kinemark_command(*arguments, folder=None):
    """Runs the command as a user would."""
    command = [sys.executable, "-m", "kinemark", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, check=False)


@pytest.fixture
def trial(tmp_path):
    """A C3D file with two markers, one of them with a gap."""
    xyz = np.cumsum(np.random.default_rng(0).normal(size=(2, 20, 3)), axis=1).astype(np.float32) + 500
    xyz[1, 5:8] = np.nan
    paths = tuple(MarkerTrajectory.measured(name, p) for name, p in zip(("hip", "knee"), xyz, strict=True))
    write_c3d(tmp_path / "trial.c3d", Trial("trial", Trajectories(paths, 100.0)))
    return tmp_path / "trial.c3d"


SMALL = Scene(seconds=1.0, size_px=(376, 292), focal_px=385.0, noise=1.0)


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """A demonstration in a small laboratory."""
    folder = tmp_path_factory.mktemp("demo") / "session"
    return folder, demo(folder, scene=SMALL)


def test_the_demonstration_recovers_every_marker(shown):
    _, result = shown
    assert result.passed
    assert result.score.recall > 0.97
    assert result.score.rmse < 1.0
    assert 0.85 < result.score.coverage <= 1
    assert f"{result.score.found} of 15" in result.text()
    assert json.dumps(result.figures())


def test_the_demonstration_sees_only_the_images(shown, tmp_path):
    """Without the truth beside it the session gives the same tracks."""
    folder, result = shown
    for part in ("session.toml", "rods.toml", "calib", "walk01", "earlier.c3d"):
        (tmp_path / part).symlink_to(folder / part)
    blind = Session.open(tmp_path).run(to="label")["walk01"]
    assert same(blind.tracks, result.results.tracks)


def test_a_second_demonstration_does_not_simulate_again(shown):
    folder, first = shown
    again = demo(folder)
    assert again.results.computed == ()
    assert same(again.results.tracks, first.results.tracks)


def test_fields_of_interlaced_video_are_frames(tmp_path):
    """At half the height and twice the rate of the images, with the bottom field's half line in its place."""
    scene = Scene(seconds=0.4, noise=1.0, interlaced=True)
    simulate(tmp_path / "s", scene=scene)
    result = Session.open(tmp_path / "s").run(to="track")["walk01"]
    truth = np.load(tmp_path / "s" / "truth.npz")["xyz"]
    assert result.tracks.cloud.n_frames == truth.shape[1] == 20
    found = score(result.tracks, truth)
    assert found.recall > 0.97
    off = result.tracks.cloud.xyz - truth[found.owner, result.tracks.cloud.frame]
    by_field = [off[(found.owner >= 0) & (result.tracks.cloud.frame % 2 == k)].mean(0) for k in (0, 1)]
    assert np.abs(by_field[0] - by_field[1]).max() < 0.3  # half a line is 1.4 mm here


@pytest.mark.parametrize("motion", ["feeding", "circle", "flexion"])
def test_other_motions_are_simulated_and_processed(tmp_path, motion):
    lens = {} if motion == "feeding" else {"barrel": 0.0}  # one of them is calibrated with a grid besides
    scene = Scene(motion=motion, seconds=0.4, rate_hz=30.0, cameras=4, size_px=(480, 360), focal_px=500.0, **lens)
    simulate(tmp_path / "s", scene=scene)
    session = Session.open(tmp_path / "s")
    (result,) = session.run(to="track").values()
    found = score(result.tracks, np.load(tmp_path / "s" / "truth.npz")["xyz"])
    assert found.recall > 0.9
    assert found.swaps == 0


def test_a_simulated_arm_can_be_calibrated_as_well_as_its_images_are(tmp_path):
    """Eight balls do not show a lens; the grid does, and without a lens there is none."""
    scene = Scene(motion="feeding", seconds=0.02, cameras=2, size_px=(480, 360), focal_px=500.0)
    path = simulate(tmp_path / "s", scene=scene)
    made = Session.open(path).calibrate()
    assert made.figures["verdict"]["grade"] == "green"
    truth = np.load(tmp_path / "s" / "truth.npz")
    centres = -np.einsum("cji,cj->ci", truth["R"], truth["t"])
    path.write_text("\n".join(line for line in path.read_text().splitlines() if "linearisation" not in line))
    blind = Session.open(path).calibrate()
    off, without = (np.abs(each.rig.centres - centres).max() for each in (made, blind))
    assert off < 0.6 < 5 < without
    straight = Session.open(simulate(tmp_path / "p", scene=replace(scene, barrel=0.0)))
    assert straight.settings.calibration.linearisation is None


def test_nothing_is_simulated_over_what_is_there(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(KinemarkError, match="nothing in it is overwritten"):
        simulate(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_trajectories_convert_there_and_back(trial):
    source = read_c3d(trial).trajectories
    for name in ("a.trc", "a.csv"):
        convert(trial, trial.with_name(name))
        convert(trial.with_name(name), trial.with_name(f"{name}.c3d"), what="trajectories")
        back = read_c3d(trial.with_name(f"{name}.c3d")).trajectories
        assert back.names == source.names
        assert back.rate == source.rate
        assert np.allclose(back.xyz, source.xyz, atol=1e-3, equal_nan=True)
    assert read_trc(trial.with_name("a.trc"))["knee"].gaps == [(5, 8)]


def test_rigs_and_detections_convert(tmp_path):
    rig = ring(3, lens=np.zeros(5))
    write_rig_toml(tmp_path / "rig.toml", rig)
    convert(tmp_path / "rig.toml", tmp_path / "dlt.csv")
    convert(tmp_path / "dlt.csv", tmp_path / "back.toml", length_unit="mm")
    assert np.allclose(read_rig_toml(tmp_path / "back.toml").P, rig.P, rtol=1e-6)
    detections, _ = observe(rig, swarm(n=3, frames=4))
    save(tmp_path / "d.h5", detections)
    convert(tmp_path / "d.h5", tmp_path / "d.csv")
    assert np.array_equal(read_detections_csv(tmp_path / "d.csv", rate=100.0).uv, detections.uv)
    convert(tmp_path / "d.csv", tmp_path / "e.h5", rate_hz=100.0)
    assert same(load(tmp_path / "e.h5").uv, detections.uv)


def test_impossible_conversions_are_explained(trial, tmp_path):
    with pytest.raises(KinemarkError, match="nothing is overwritten"):
        convert(trial, trial)
    with pytest.raises(KinemarkError, match=r"has trajectories; \.toml can hold rig"):
        convert(trial, tmp_path / "a.toml")
    write_rig_toml(tmp_path / "bent.toml", ring(2))
    with pytest.raises(KinemarkError, match="lens distortion"):
        convert(tmp_path / "bent.toml", tmp_path / "bent.csv")
    assert not (tmp_path / "bent.csv").exists()


def test_files_are_described(trial, shown):
    folder, _ = shown
    assert describe(trial)["markers"] == ["hip", "knee"]
    assert describe(trial)["gaps"] == {"count": 1, "longest_frames": 3}
    assert "walk01" in describe(folder)["trials"]
    assert len(describe(folder / "results" / "rig.toml")["cameras"]) == 6
    assert describe(folder / "results" / "walk01" / "tracks.h5")["holds"] == "tracks"
    assert describe(folder / "walk01" / "cam1.mkv")["frames"] == 50


def test_commands_run_and_say_what_to_do(shown, trial):
    folder, result = shown
    done = kinemark_command("run", folder)
    assert done.returncode == 0, done.stderr
    assert "nothing: all is unchanged" in done.stdout
    figures = json.loads(kinemark_command("run", folder, "--json").stdout)
    assert figures["walk01"] == json.loads(json.dumps(result.results.quality))
    assert "hip, knee" in kinemark_command("info", trial).stdout
    assert kinemark_command("convert", trial, trial.with_suffix(".trc")).returncode == 0
    assert trial.with_suffix(".trc").is_file()
    failed = kinemark_command("run", trial.parent / "nowhere")
    assert failed.returncode == 1
    assert "kinemark simulate" in failed.stderr
    assert "Traceback" not in failed.stderr
    assert kinemark_command("--version").stdout.strip() == kinemark.__version__


def test_the_public_names_are_a_decision():
    """Whoever adds or removes one changes this list with it."""
    records = "Analog AngleModel Angles Camera Cloud Detections Events ForcePlate MarkerSet Matches Origin"
    records += " MarkerTrajectory Poses Rig Rods Signal Signals Tracks Trajectories Trial Validity KinemarkError"
    methods = "Centroids ControlPoints EpipolarTriplets ExtrapolationLadder LeastSquares"
    methods += (
        " CameraPairs DistanceOnly FormerTwoCameras KissTracking KissTriplets NearestEpipolar Simultaneous Swamidas"
    )
    methods += " Dlt KissNearest KissScanning Linearisation Masks Wand Auto InverseCosines SignedAngles"
    stages = "calibrate_control_frame calibrate_control_points detect match reconstruct score to_trajectories track"
    stages += " ambiguous_decisions track_detections track_simultaneously diagnose diagnose_tracks"
    stages += " fill Filled FilledGap place_absent trim_edges joint_angles"
    stages += " calibrate_points calibrate_sticks calibrate_wand learn_masks linearise predicted_covariance propose"
    geometry = "project refine triangulate undistort"
    kinds = "c3d detections_csv dlt_csv rig_toml trajectories_csv trc"
    files = " ".join(f"read_{k} write_{k}" for k in kinds.split())
    labelling = "Distances Labels SubjectTemplate Template label learn_marker_set learn_template named static_template"
    labelling += " figure_template marker_sets read_marker_set write_marker_set"
    gait = "GaitCurves GaitTrial LegMeasures Physical PlugInGait SubjectMeasures analyse_gait foot_events gait_curves"
    gait += " marker_points read_measures strides with_static_offsets"
    files += " read_tdf read_trial write_trial load load_model save open_images"
    names = " ".join([records, methods, stages, geometry, labelling, gait, files, "__version__"]).split()
    assert sorted(kinemark.__all__) == sorted(names)
    assert all(hasattr(kinemark, name) for name in names)


def test_the_library_alone_goes_from_detections_to_trajectories(tmp_path):
    rig, points = ring(4), swarm(n=4, frames=30)
    seen, _ = observe(rig, points, noise=0.1)
    cloud = kinemark.reconstruct(kinemark.match(seen, rig), seen, rig)
    trajectories = kinemark.to_trajectories(kinemark.track(cloud), rig)
    kinemark.write_c3d(tmp_path / "walk.c3d", kinemark.Trial("walk", trajectories))
    assert len(kinemark.read_c3d(tmp_path / "walk.c3d").trajectories) == 4


def test_scenes_that_cannot_be_are_refused_and_leave_nothing(tmp_path):
    for wrong in ({"seconds": -1}, {"rate_hz": 0}, {"focal_px": 0}, {"size_px": (0, 10)}, {"cameras": 1}):
        with pytest.raises(KinemarkError, match=next(iter(wrong))):
            simulate(tmp_path / "s", scene=Scene(**wrong))
    assert not list(tmp_path.iterdir())


def test_a_simulation_that_is_cut_off_leaves_nothing(tmp_path):
    def stop(*told):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(tmp_path / "s", scene=SMALL, progress=stop)
    assert not list(tmp_path.iterdir())


def test_a_bts_file_becomes_a_c3d_file(tmp_path):
    source = shared_data("cameras/gait9_bts/gait9.tdf")
    convert(source, tmp_path / "gait.c3d")
    trial = read_c3d(tmp_path / "gait.c3d")
    assert "sacrum" in trial.trajectories.names
    assert len(trial.plates) == 2
    with pytest.raises(KinemarkError, match="Say which with --what"):
        convert(source, tmp_path / "gait.csv")


def test_only_positions_go_into_a_trc_file(tmp_path):
    source = shared_data("mocap3d/pig_gait_child/HC030A05.c3d")
    convert(source, tmp_path / "walk.trc")
    assert not [name for name in read_trc(tmp_path / "walk.trc").names if name.endswith(("Angles", "Moment", "Power"))]
    with pytest.raises(KinemarkError, match="no markers"):
        convert(next(shared_data("mocap3d/c3d_malformed").glob("Mega*")), tmp_path / "none.trc")


def test_unknown_files_are_said_to_be_unknown(tmp_path):
    (tmp_path / "a.mot").write_text("x")
    with pytest.raises(KinemarkError, match="no known kind"):
        describe(tmp_path / "a.mot")
    detections, _ = observe(ring(2), swarm(n=1, frames=2))
    kinemark.write_detections_csv(tmp_path / "d.csv", detections)
    with pytest.raises(KinemarkError, match="--rate-hz"):
        convert(tmp_path / "d.csv", tmp_path / "d.h5")
