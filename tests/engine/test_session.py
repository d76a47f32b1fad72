"""A session from its file to its results: settings, running, resuming, and what is said when it cannot be done."""

import json
import re
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import Detections, KinemarkError
from kinemark.detect import detect, learn_masks
from kinemark.engine.calibration.results import LOCK
from kinemark.engine.progress import SILENT, Cancelled
from kinemark.engine.session import Session
from kinemark.engine.settings import SETTABLE, read_settings
from kinemark.engine.settings.method_tables import COMMON
from kinemark.engine.store import Store
from kinemark.geometry import project_all, to_dlt
from kinemark.io.c3d import read_c3d
from kinemark.io.control_points import read_control_points
from kinemark.io.detections_csv import write_detections_csv
from kinemark.io.dlt_csv import write_dlt_csv
from kinemark.io.images import open_images, write_png
from kinemark.io.rig_toml import read_rig_toml, write_rig_toml
from kinemark.io.video import write_video
from kinemark.synth.score import score
from support.findings import found, kinds
from support.laboratory import observe, ring
from support.motions import swarm
from support.schema import check_quality
from support.sessions import OF_FILE, session_of_points
from support.shared import shared_data

POINTS = swarm(n=6, frames=40)


@pytest.fixture
def folder(tmp_path):
    """A session with detections and a ready-made calibration."""
    return session_of_points(tmp_path, POINTS)


def changed(folder, old, new):
    file = folder / "session.toml"
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, new))
    return folder


def run(folder, to="write"):
    return Session.open(folder).run(to=to)["one"]


def recomputed(trial):
    """The stages that were computed, but for the two that tell of the others."""
    return tuple(stage for stage in trial.computed if stage not in ("quality", "write"))


def test_a_session_gives_tracks_c3d_report_and_figures(folder):
    given = {path: path.read_bytes() for path in folder.iterdir()}
    result = run(folder)
    found = score(result.tracks, POINTS)
    assert (found.recall, found.swaps) == (1.0, 0)
    trial = read_c3d(folder / "results/one/one.c3d")
    assert trial.trajectories.names == tuple(f"*{i + 1}" for i in range(6))
    assert trial.trajectories.rate == 100
    assert np.nanmax(np.abs(trial.trajectories.xyz - result.trajectories.xyz)) < 1e-3
    figures = json.loads((folder / "results/one/quality.json").read_text())
    check_quality(figures)
    assert figures["session"] == "test"
    assert "<html" in (folder / "results/one/report.html").read_text()
    assert {path: path.read_bytes() for path in given} == given
    assert {path.name for path in folder.iterdir()} == {path.name for path in given} | {"results"}


STAGED = '[track]\nmethod = "extrapolation_ladder"\n[calibration]'


def test_a_second_run_does_only_what_changed(folder):
    assert recomputed(run(folder)) == ("detect", "track")
    before = {p: p.stat().st_mtime_ns for p in (folder / "results/one").glob("*.h5")}
    assert recomputed(run(folder)) == ()
    assert {p: p.stat().st_mtime_ns for p in before} == before
    changed(folder, "[calibration]", "[track]\ngate = 4.0\n[calibration]")
    assert recomputed(run(folder, "track")) == ("track",)
    changed(folder, "[track]", "[reconstruct]\nmarker_diameter = 25.0\n[track]")
    assert recomputed(run(folder, "track")) == ("track",)
    rig = read_rig_toml(folder / "rig.toml")
    write_rig_toml(folder / "rig.toml", replace(rig, cameras=rig.cameras[:3]))
    assert recomputed(run(folder, "track")) == ("detect", "track")


@pytest.mark.parametrize("staged", [False, True])
def test_what_a_calibration_says_of_itself_is_what_the_trial_says(folder, staged):
    changed(folder, "[calibration]", STAGED if staged else "[calibration]")
    run(folder)
    rig = read_rig_toml(folder / "rig.toml")
    other = tuple(replace(camera, residual=0.25) for camera in rig)
    write_rig_toml(folder / "rig.toml", replace(rig, cameras=other, method="by hand"))
    quality = run(folder).quality
    assert quality["calibration"]["method"] == "by hand" and quality["cameras"][0]["calibration_residual_px"] == 0.25


def test_a_tracker_of_points_runs_the_stages_before_it(folder):
    changed(folder, "[calibration]", STAGED)
    assert recomputed(run(folder, "track")) == ("detect", "match", "reconstruct", "track")
    changed(folder, "[track]", "[reconstruct]\ndegrees_of_freedom = 2.0\n[track]")
    assert recomputed(run(folder, "track")) == ("reconstruct", "track")
    changed(folder, "extrapolation_ladder", "kiss_tracking")
    assert recomputed(run(folder, "track")) == ("track",)
    changed(folder, "[reconstruct]", '[match]\nmethod = "kiss_triplets"\n[reconstruct]')
    assert recomputed(run(folder, "track")) == ("match", "reconstruct", "track")
    assert score(run(folder, "track").tracks, POINTS).recall > 0.99


def test_stages_that_would_do_nothing_are_refused(folder):
    changed(folder, "[calibration]", "[match]\nsearch_band = 3.0\n[calibration]")
    with pytest.raises(KinemarkError, match=r"\[match\] would do nothing.*extrapolation_ladder"):
        run(folder)
    changed(folder, "[match]\nsearch_band = 3.0", '[reconstruct]\nmethod = "camera_pairs"')
    with pytest.raises(KinemarkError, match=r"\[reconstruct\] would do nothing"):
        run(folder)


def test_what_the_tracker_doubts_outlives_the_run(folder):
    first = run(folder, "quality")
    said = json.loads((folder / "results/one/ambiguous_decisions.json").read_text())
    assert set(said) == {"ambiguous_decisions", "cameras", "diagnostics"}
    again = run(folder, "quality")
    assert recomputed(again) == () and again.quality["ambiguous_decisions"] == first.quality["ambiguous_decisions"]
    (folder / "results/one/ambiguous_decisions.json").write_text("{")
    assert recomputed(run(folder, "track")) == ("track",)


def test_what_is_lost_or_damaged_is_made_again(folder):
    results = folder / "results/one"
    first = run(changed(folder, "[calibration]", STAGED))
    (results / "report.html").unlink()
    assert recomputed(run(folder)) == ()
    assert (results / "report.html").is_file()
    (results / "cloud.h5").write_bytes(b"damaged")
    assert recomputed(run(folder, "track")) == ("reconstruct",)
    (results / "steps.json").write_text("{")
    assert recomputed(run(folder, "track")) == ("detect", "match", "reconstruct", "track")
    assert np.array_equal(run(folder, "track").tracks.id, first.tracks.id)


def test_a_run_that_was_cut_off_goes_on(folder, monkeypatch):
    def fail(*args, **kwargs):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("kinemark.engine.tracking_in_time.track_simultaneously", fail)
        with pytest.raises(KeyboardInterrupt):
            run(folder, "track")
    assert not list(folder.rglob("*.part*"))
    assert recomputed(run(folder, "track")) == ("track",)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('name = "test"', 'name = "test"\ntreshold = 3', r"treshold: there is no such key.*there are name"),
        ("[calibration]", "[trakc]\n[calibration]", r"trakc: there is no such key \(did you mean 'track'\?\)"),
        ("[calibration]", "[track]\ngaet = 3\n[calibration]", r"did you mean 'gate'"),
        ("[calibration]", '[track]\nmethod = "magic"\n[calibration]', r"'magic' is not known; there are simultaneous"),
        ("[calibration]", '[track]\ngate = "far"\n[calibration]', r"track"),
        ("[calibration]", "[detect]\nthreshold = 900\n[calibration]", r"threshold is 900"),
        ("rate_hz = 100.0", "rate_hz = -3", r"rate_hz: .*greater than 0"),
        ("rate_hz = 100.0", "", r"does not say its frame rate. Set rate_hz"),
        ('file = "rig.toml"', "", r"exactly one of file, .*wand and single_marker, found none"),
        ('file = "rig.toml"', 'file = "nowhere.toml"', r"nowhere.toml is not a file"),
        ('detections = "one.csv"', "", r"wants either images or detections"),
        ('detections = "one.csv"', 'detections = "two.csv"', r"two.csv is not a file"),
        ('name = "one"', 'name = "a/b"', r"trials #1\.name"),
        ("[calibration]", '[cameras]\nnames = ["c0", "c9"]\n[calibration]', r"not c9"),
        ("[calibration]", '[cameras]\nnames = ["c0"]\n[calibration]', r"1 camera, and a point in space needs two"),
        ("[calibration]", "[calibration", r"is no TOML"),
        ("[calibration]", "x = " + "[" * 5000, r"is no TOML"),
    ],
)
def test_settings_that_cannot_be_used_are_explained(folder, old, new, said):
    with pytest.raises(KinemarkError, match=said):
        run(changed(folder, old, new))
    assert not (folder / "results/one").exists()


def test_no_session_says_how_to_make_one(tmp_path):
    with pytest.raises(KinemarkError, match="kinemark simulate"):
        Session.open(tmp_path)


def test_a_trial_that_is_not_there_is_named(folder):
    with pytest.raises(KinemarkError, match=r"no trial.*the session has one"):
        Session.open(folder).run(["two"])


def test_a_bad_recording_keeps_nobody_from_the_others(folder):
    (folder / "bad.csv").write_text("frame,camera\n1,nothing\n")
    changed(folder, "[[trials]]", '[[trials]]\nname = "bad"\ndetections = "bad.csv"\n[[trials]]')
    with pytest.raises(KinemarkError, match=r"bad\.csv"):
        Session.open(folder).run()
    assert not (folder / "results" / "one").exists()
    done = Session.open(folder).run(keep_going=True)
    assert "bad.csv" in str(done["bad"].failed) and "bad.csv" in done["bad"].summary()["error"]
    assert done["one"].failed is None and (folder / "results/one/one.c3d").is_file()


def test_the_exit_status_tells_errors_and_bad_verdicts(folder, capsys):
    def status(*arguments):
        with pytest.raises(SystemExit) as ended:
            app([*map(str, arguments)], exit_on_error=False)
        return ended.value.code

    grade = run(folder).quality["verdict"]["grade"]
    assert grade in ("green", "amber")
    assert status("run", folder) == 0
    assert status("run", folder, "--fail-on", "amber") == (3 if grade == "amber" else 0)
    rig, lines = ring(4), []
    for c, name in enumerate(rig.names):  # each camera sees another scene
        write_detections_csv(folder / "other.csv", observe(rig, swarm(n=6, frames=40, seed=10 + c), noise=0.1)[0])
        head, *rows = (folder / "other.csv").read_text().splitlines()
        lines += [row for row in rows if name in row.split(",")]
    (folder / "one.csv").write_text("\n".join([head, *lines]) + "\n")
    assert status("run", folder) == 3
    assert status("run", folder, "--fail-on", "never") == 0


def test_every_method_can_be_written_in_the_file(folder):
    given = (folder / "session.toml").read_text()
    for stage, methods in SETTABLE.items():
        for name, declared in methods.items():
            staged = '[track]\nmethod = "swamidas"\n' if stage in ("match", "reconstruct") else ""
            needed = 'markers = ["A", "B"]\n' if stage == "digitise" else ""
            (folder / "session.toml").write_text(f'{given}{staged}[{stage}]\nmethod = "{name}"\n{needed}')
            found = getattr(read_settings(folder / "session.toml"), stage)
            assert type(found.method if stage in COMMON else found) is declared.kind


def test_dlt_files_need_their_unit_and_then_give_the_same_points(folder):
    rig = ring(4, lens=np.zeros(5))
    write_detections_csv(folder / "one.csv", observe(rig, POINTS)[0])
    write_rig_toml(folder / "rig.toml", rig)
    direct = run(folder, "track").tracks
    metres = to_dlt(rig.P) * np.array([1000, 1000, 1000, 1, 1000, 1000, 1000, 1, 1000, 1000, 1000])
    write_dlt_csv(folder / "rig.csv", metres)
    changed(folder, "rig.toml", "rig.csv")
    changed(folder, "[calibration]", '[cameras]\nnames = ["c0", "c1", "c2", "c3"]\n[calibration]')
    with pytest.raises(KinemarkError, match="length_unit"):
        run(folder, "track")
    by_dlt = run(changed(folder, "[calibration]", '[calibration]\nlength_unit = "m"'), "track")
    assert np.abs(by_dlt.tracks.cloud.xyz - direct.cloud.xyz).max() < 1e-3


IMAGES = """\
name = "images"
rate_hz = 50.0
[cameras]
names = ["c0", "c1", "c2"]
[calibration]
file = "rig.toml"
[[trials]]
name = "one"
images = "one/{camera}.mkv"
[track]
max_sd = 30.0
"""


def dots(uv, size=(96, 64)):
    """An image with a round spot at each place."""
    u, v = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    image = np.zeros(size[::-1])
    for place in np.atleast_2d(uv):
        image += 200 * np.exp(-((u - place[0]) ** 2 + (v - place[1]) ** 2) / 6)
    return np.minimum(image + 5, 255).astype(np.uint8)


@pytest.fixture
def filmed(tmp_path):
    """A session with small videos of one marker in three cameras."""
    rig = ring(3, focal=90.0, size=(96, 64), lens=np.zeros(5))
    write_rig_toml(tmp_path / "rig.toml", rig)
    (tmp_path / "one").mkdir()
    path = np.array([[0, 0, 900]]) + np.linspace(-300, 300, 30)[:, None] * [[1, 0.5, 0.2]]
    for name, uv in zip(rig.names, project_all(rig, path), strict=True):
        write_video(tmp_path / "one" / f"{name}.mkv", [dots(p) for p in uv], 50.0)
    (tmp_path / "session.toml").write_text(IMAGES)
    return tmp_path, path


def test_masks_are_learned_once_for_all_trials(filmed, monkeypatch):
    folder, _ = filmed
    text = (folder / "session.toml").read_text()
    second = '[[trials]]\nname = "two"\nimages = "one/{camera}.mkv"\n'
    (folder / "session.toml").write_text(f'{text}{second}[masks]\nempty = "empty/{{camera}}.mkv"\n')
    learned = []

    def counted(*given, **options):
        learned.append(learn_masks(*given, **options))
        return learned[-1]

    monkeypatch.setattr("kinemark.engine.recordings.learn_masks", counted)

    def record(frames):
        (folder / "empty").mkdir(exist_ok=True)
        for name in ("c0", "c1", "c2"):
            write_video(folder / "empty" / f"{name}.mkv", [dots([8, 8])] * frames, 50.0)

    record(5)
    assert set(Session.open(folder).run()) == {"one", "two"} and len(learned) == 1
    assert learned[0].pixels("c0")[8, 8] and not learned[0].pixels("c0")[40, 40]
    record(7)  # another recording of the empty volume
    done = Session.open(folder).run()
    assert len(learned) == 2 and all("detect" in result.computed for result in done.values())


def test_videos_are_processed(filmed):
    folder, path = filmed
    result = score(run(folder, "track").tracks, path[None], within=20.0)  # a pixel is 30 mm, and the spots are no discs
    assert result.recall == 1.0
    assert result.rmse < 1.5


def test_one_frame_of_so_many_is_processed(filmed):
    """At a rate that is so many times lower, as the videos contradict nothing; numbers of frames are of those."""
    folder, path = filmed
    whole = run(folder, "track").trajectories
    trial = run(changed(folder, 'name = "one"\n', 'name = "one"\nevery = 3\n'), "quality")
    assert (trial.trajectories.n_frames, trial.trajectories.rate) == (10, whole.rate / 3)
    assert "detect" in trial.computed and "frame_rate_contradicted" not in kinds(trial.quality)
    assert score(trial.tracks, path[None, ::3], within=20.0).recall == 1.0
    source = Session.open(folder).trial("one").source(Session.open(folder).calibrate().rig)
    np.testing.assert_array_equal(source.pictures([9, 0, 0])[0], list(open_images(folder / "one/c0.mkv"))[27])
    part = run(changed(folder, "every = 3\n", "every = 3\nframes = [4, 10]\n"), "track").trajectories
    assert part.n_frames == 7 and part.first_frame == 4


def test_one_image_of_so_many_is_taken_of_a_slower_camera_too(filmed):
    """Which has images at half as many times, and so when one of two is taken."""
    folder, path = filmed
    half = [image for k, image in enumerate(open_images(folder / "one/c1.mkv")) if k % 2 == 0]
    write_video(folder / "one" / "c1.mkv", half, 25.0)
    changed(folder, "[calibration]", "rates_hz = { c1 = 25 }\n[calibration]")
    trial = run(changed(folder, 'name = "one"\n', 'name = "one"\nevery = 2\n'), "track")
    assert score(trial.tracks, path[None, ::2], within=20.0).recall == 1.0
    source = Session.open(folder).trial("one").source(Session.open(folder).calibrate().rig)
    np.testing.assert_array_equal(source.pictures([0, 12, 0])[1], half[12])


def test_frames_of_detections_are_not_left_out(folder):
    with pytest.raises(KinemarkError, match="every = 2, which is of images"):
        run(changed(folder, 'detections = "', 'every = 2\ndetections = "'))


def test_the_report_shows_the_frames_that_it_names(filmed):
    folder, _ = filmed
    session = Session.open(folder)
    rig = session.calibrate().rig
    source = session.trial("one").source(rig)
    asked = [0, 7, 29]
    for name, f, picture in zip(rig.names, asked, source.pictures(asked), strict=True):
        np.testing.assert_array_equal(picture, list(open_images(folder / f"one/{name}.mkv"))[f])
    page = (run(folder).folder / "report.html").read_text(encoding="utf-8")
    (spec,) = re.findall(r'<script type="application/json" data-for="spots">(.*?)</script>', page)
    assert [trace["type"] for trace in json.loads(spec)["data"]].count("image") == 3


def test_videos_that_contradict_are_refused(filmed):
    folder, _ = filmed
    video = folder / "one" / "c1.mkv"
    whole = video.read_bytes()
    with pytest.raises(KinemarkError, match=r"c0 30.*c1 20"):
        write_video(video, [dots([40, 30])] * 20, 50.0)
        run(folder)
    video.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(KinemarkError, match=r"c1"):
        run(folder)
    write_video(video, [dots([40, 30], (80, 64))] * 30, 50.0)
    with pytest.raises(KinemarkError, match=r"calibrated at 96 × 64 px and its images are 80 × 64"):
        run(folder)
    video.unlink()
    with pytest.raises(KinemarkError, match=r"Camera 'c1' of \[cameras\] has no usable images"):
        run(folder)
    assert not (folder / "results/one").exists() or not list((folder / "results/one").glob("*.c3d"))


def test_a_pattern_without_camera_is_refused(filmed):
    folder, _ = filmed
    with pytest.raises(KinemarkError, match=r"no \{camera\} in it"):
        run(changed(folder, "one/{camera}.mkv", "one/c1.mkv"))


def test_digitised_control_points_snap_to_markers(tmp_path):
    uv = np.array([[20.3, 30.6], [60.1, 20.2]])
    write_png(tmp_path / "c0.png", dots(uv))
    head = "name,x_mm,y_mm,z_mm,c0_u_px,c0_v_px\n"
    (tmp_path / "points.csv").write_text(head + "a,0,0,0,22,29\nb,1,0,0,60,22\nd,2,0,0,,\n")
    seen = detect([open_images(tmp_path / "c0.png")], cameras=["c0"], rate=1.0)
    points = read_control_points(tmp_path / "points.csv", ["c0"], seen)
    assert np.abs(points.uv[0, :2] - uv).max() < 0.2
    assert np.isnan(points.uv[0, 2]).all()
    (tmp_path / "points.csv").write_text(head + "a,0,0,0,80,50\n")
    with pytest.raises(KinemarkError, match="no marker within 8 px of point 1"):
        read_control_points(tmp_path / "points.csv", ["c0"], seen)
    (tmp_path / "points.csv").write_text("name,x_mm,y_mm\na,0,0\n")
    with pytest.raises(KinemarkError, match="lacks the columns z_mm, c0_u_px"):
        read_control_points(tmp_path / "points.csv", ["c0"])


def test_a_bts_file_is_a_whole_session(tmp_path):
    file = shared_data("cameras/gait9_bts/gait9.tdf")
    (tmp_path / "session.toml").write_text(
        f'name = "gait"\n[calibration]\nfile = "{file}"\n[[trials]]\nname = "one"\ndetections = "{file}"\n'
    )
    result = run(tmp_path)
    assert result.tracks.cloud.n_frames == 1686
    trial = read_c3d(tmp_path / "results/one/one.c3d")
    assert trial.trajectories.rate == 250
    assert len(trial.plates) == 2
    assert "Fz1" in trial.analog[0].names
    assert Path(tmp_path / "results/one/report.html").stat().st_size < 2_000_000


def test_another_rate_is_another_input(folder):
    assert run(folder, "track").trajectories.rate == 100
    result = run(changed(folder, "rate_hz = 100.0", "rate_hz = 200.0"))
    assert result.computed[0] == "detect"
    assert read_c3d(folder / "results/one/one.c3d").trajectories.rate == 200


def test_outputs_that_were_not_written_are_written_by_the_next_run(folder, monkeypatch):
    run(folder)
    changed(folder, "[calibration]", "[track]\nmax_sd = 0.001\n[calibration]")

    def fail(*args, **kwargs):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("kinemark.engine.trial_graph.write_c3d", fail)
        with pytest.raises(KeyboardInterrupt):
            run(folder)
    assert recomputed(run(folder)) == ()
    assert len(read_c3d(folder / "results/one/one.c3d").trajectories) == 0
    run(changed(folder, 'name = "test"', 'name = "renamed"'))
    assert json.loads((folder / "results/one/quality.json").read_text())["session"] == "renamed"


@pytest.mark.parametrize("name", ["..", ".", "a/b", "", " ", "rig.toml", "a\\u0000b", "x" * 200])
def test_a_trial_cannot_write_outside_its_results(folder, name):
    with pytest.raises(KinemarkError, match=r"trials #1\.name"):
        run(changed(folder, 'name = "one"', f'name = "{name}"'))


def test_a_control_volume_reaches_the_calibration(folder):
    changed(folder, "[calibration]", "volume_mm = [[0, 0, 0], [2400, 1400, 2000]]\n[calibration]")
    Session.open(folder).calibrate()
    assert read_rig_toml(folder / "results/rig.toml").volume.tolist() == [[0, 0, 0], [2400, 1400, 2000]]
    with pytest.raises(KinemarkError, match="least corner first"):
        Session.open(changed(folder, "[[0, 0, 0], [2400", "[[9000, 0, 0], [2400"))


def test_a_recording_is_not_a_session(folder):
    with pytest.raises(KinemarkError, match="is a recording, not a session"):
        Session.open(folder / "one.csv")


def test_cameras_of_one_name_are_refused(folder):
    with pytest.raises(KinemarkError, match="names must differ"):
        run(changed(folder, "[calibration]", '[cameras]\nnames = ["c0", "c0"]\n[calibration]'))


def test_a_rate_that_the_videos_contradict_is_a_doubt(filmed):
    folder, _ = filmed
    assert "frame_rate_contradicted" not in kinds(run(folder, "quality").quality)
    figures = run(changed(folder, "rate_hz = 50.0", "rate_hz = 500.0"), "quality").quality
    (one,) = found(figures, "frame_rate_contradicted")
    assert one.cameras[0] == "c0" and one.values["rate_hz"] == 500 and set(one.values["stated_hz_list"]) == {50.0}
    assert figures["verdict"]["grade"] != "green"


def test_delays_that_are_known_are_taken_into_account(tmp_path):
    rate, delays, rates = 100.0, (0.0, 0.013, -0.006, 0.0), (100.0, 100.0, 100.0, 98.0)
    rig, fine = ring(4), swarm(n=6, frames=6000, rate=10_000.0)
    write_rig_toml(tmp_path / "rig.toml", rig)
    counts, uv = [], []
    for c, (late, own) in enumerate(zip(delays, rates, strict=True)):
        taken = np.clip(np.rint((np.arange(50) / own + late + 0.02) * 10_000).astype(int), 0, 5999)
        seen, _ = observe(rig, fine[:, taken], noise=0.1, rate=rate, seed=c)
        counts.append(seen.counts[c])
        uv.append(seen.uv[seen.camera == c])
    write_detections_csv(tmp_path / "one.csv", Detections.build(rig.names, rate, np.array(counts), np.concatenate(uv)))
    names = rig.names
    said = f"[cameras]\ndelays_ms = {{ {names[1]} = 13, {names[2]} = -6 }}\nrates_hz = {{ {names[3]} = 98 }}\n"
    (tmp_path / "session.toml").write_text(OF_FILE + said)
    tracks = run(tmp_path, to="track").tracks
    found = score(tracks, fine[:, 200::100][:, : tracks.cloud.n_frames])  # the slower camera sees one frame more
    assert (found.recall > 0.97, found.swaps, len(tracks)) == (True, 0, 6)
    changed(tmp_path, "= 13", "= 0")
    assert run(tmp_path, to="track").computed == ("detect", "track")  # the input is another one


def test_delays_of_cameras_that_are_not_there_are_refused(folder):
    changed(folder, "[calibration]", "[cameras]\ndelays_ms = { nobody = 3 }\n[calibration]")
    with pytest.raises(KinemarkError, match="name nobody, and the cameras are"):
        run(folder)


def test_who_waits_is_told_for_what(folder):
    """A second process on one session said "wait: 0 of 1"."""
    session = Session.open(folder)
    said, stop = [], threading.Event()

    def progress(stage, *_):
        said.append(stage)
        stop.set()

    with (
        Store.open(session.results, session.results / LOCK, SILENT.of("")),
        pytest.raises(Cancelled, match="wait for another run"),
    ):
        session.calibrate(progress=progress, cancel=stop)
    assert said == ["wait for another run"]
