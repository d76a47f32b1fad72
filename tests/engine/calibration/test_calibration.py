"""Every way of calibrating in a session: from what lies in the folder to rig.toml, the page and the trial."""

import json
import shutil
import subprocess
import sys
from contextlib import suppress
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import Detections, KinemarkError, Rig
from kinemark.engine.calibration.from_moved_target import method_of
from kinemark.engine.detection.proposals import learn_session_masks
from kinemark.engine.session import Session
from kinemark.engine.simulate import Scene, simulate
from kinemark.geometry import project_all
from kinemark.io.detections_csv import write_detections_csv
from kinemark.io.images import write_png
from kinemark.io.rig_toml import read_rig_toml, write_rig_toml
from kinemark.report.words import text_of
from kinemark.synth import Optics, control_frame, dot_grid, render, wand, write_calibration
from kinemark.synth.score import score
from support.calibrations import (
    BY_POINTS,
    BY_WAND,
    HEAD,
    L_FRAME,
    NAMES,
    POINTS,
    SMALL,
    TRIAL,
    WAVED,
    detected,
    lay_out_wand,
    off,
    points_csv,
    session,
)
from support.findings import found, kinds
from support.laboratory import camera
from support.schema import check_findings, check_quality

GRID = """\
[calibration.linearisation]
grid = [12, 9]
pitch_mm = 50.0
images = "grid/{camera}.png"
radial = 1
tangential = false
"""


@pytest.fixture(scope="module")
def waved(tmp_path_factory):
    """A session calibrated with a wand and run."""
    folder = tmp_path_factory.mktemp("wand")
    lay_out_wand(folder)
    opened = session(folder, f"{BY_WAND}\n{L_FRAME}")
    return folder, opened.run()["one"]


def test_a_wand_and_an_l_frame_calibrate_a_session(waved):
    folder, result = waved
    assert score(result.tracks, TRIAL).recall == 1
    assert score(result.tracks, TRIAL).rmse < 1.0
    figures = json.loads((folder / "results/calibration.json").read_text())
    check_findings(figures)
    assert figures["wand"]["known_mm"] == [500]
    assert figures["wand"]["poses"] > 0.9 * WAVED.shape[1]
    assert abs(figures["wand"]["error_mean_mm"]) < 0.2
    assert figures["checks"][0]["known_mm"] == 800
    assert abs(figures["checks"][0]["found_mm"] - 800) < 1
    assert figures["verdict"]["grade"] != "red"
    room = figures["room"]
    assert 0 < room["centre_sd_mm"] < room["sd_median_mm"] < room["sd_95_mm"] < 1.0
    assert result.quality["calibration"]["room"]["covariance"] == room["covariance"]
    assert 0 < result.quality["calibration"]["room"]["sd_at_subject_mm"] < 1.0
    assert "room_deviation_of_trial" in [one["kind"] for one in result.quality["verdict"]["statements"]]
    assert figures["fit"]["left_out_rms_px"] == pytest.approx(0.05 * np.sqrt(2), rel=0.3)


def test_the_trial_tells_how_good_its_calibration_is(waved):
    folder, result = waved
    assert result.quality["calibration"]["verdict"]["headline"]
    check_quality(result.quality)
    page = (folder / "results/one/report.html").read_text()
    assert 'href="../calibration.html"' in page
    assert 'data-for="calibration"' in page
    assert (folder / "results/calibration.html").stat().st_size > 50_000


def test_a_wand_alone_makes_a_world_of_its_own_and_says_so(waved, tmp_path):
    shutil.copytree(waved[0], tmp_path / "s", ignore=shutil.ignore_patterns("results"))
    with pytest.raises(KinemarkError, match=r"knows none\. Give l_frame or world_points"):
        session(tmp_path / "s", BY_WAND).calibrate()
    made = session(tmp_path / "s", BY_WAND, HEAD.replace("volume_mm", "# volume_mm")).calibrate()
    assert "world_of_first_camera" in kinds(made.figures)
    assert not made.figures["volume"]["given"]
    span = np.ptp(np.array(made.figures["volume"]["corners_mm"]), axis=0)
    assert (span > 800).all()
    assert np.allclose(made.rig[0].R, np.eye(3))


@pytest.mark.parametrize("interlaced", [False, "top"])
def test_a_field_of_interlaced_video_has_pixels_half_as_high(tmp_path, interlaced):
    head = HEAD if not interlaced else HEAD.replace("[cameras]", '[cameras]\ninterlaced = "top"')
    task = SimpleNamespace(settings=session(tmp_path, BY_WAND, head).settings)
    assert method_of(task, fields=True).aspect == (0.5 if interlaced else None)
    assert method_of(task, fields=False).aspect is None


def test_control_points_give_a_wand_its_world(waved, tmp_path):
    shutil.copytree(waved[0], tmp_path / "s", ignore=shutil.ignore_patterns("results"))
    points_csv(tmp_path / "s")
    made = session(tmp_path / "s", f'{BY_WAND}\nworld_points = {{ points = "points.csv" }}').calibrate()
    assert off(made.rig) < 0.3
    assert abs(made.figures["checks"][0]["error_share"]) < 1e-3


def test_a_single_marker_takes_its_scale_from_a_known_distance(tmp_path):
    place = np.random.default_rng(0).uniform(SMALL.volume[0] + 150, SMALL.volume[1] - 150, (1, 150, 3))
    write_detections_csv(tmp_path / "led.csv", detected(place))
    two = np.array([[600.0, 700, 900], [1800, 700, 900]])
    write_detections_csv(tmp_path / "two.csv", detected(two[:, None]))
    way = 'single_marker = { detections = "led.csv", distance = { mm = 1200.0, detections = "two.csv" } }'
    made = session(tmp_path, way, HEAD.replace("volume_mm", "# volume_mm")).calibrate()
    base = [np.linalg.norm(rig.centres[2] - rig.centres[0]) for rig in (made.rig, SMALL)]
    assert base[0] == pytest.approx(base[1], rel=2e-3)
    assert made.figures["wand"] is None
    assert made.figures["fit"]["left_out_rms_px"] < 0.15


def test_a_control_frame_in_images(tmp_path):
    (tmp_path / "calib").mkdir()
    write_calibration(tmp_path, SMALL, control_frame(), write_image=write_png, optics=Optics(read_noise=1.0))
    made = session(tmp_path, 'control_frame = { rods = "rods.toml", images = "calib/{camera}.png" }').calibrate()
    assert off(made.rig) < 0.1
    assert [p["name"] for p in made.figures["points"]]
    assert made.figures["verdict"]["grade"] == "green"
    rig = read_rig_toml(tmp_path / "results/rig.toml")
    assert (rig.P == made.rig.P).all()
    metadata = (tmp_path / "results/rig.toml").read_text()
    assert 'verdict = "green"' in metadata
    assert "sd_per_axis_95_mm" in metadata


def grid_images(folder, *, barrel=-0.15, near=700.0):
    """One image of a grid of dots for each camera, seen from near by."""
    (folder / "grid").mkdir(parents=True)
    grid = dot_grid(9, 12, pitch_mm=50.0, radius_mm=8.0)
    facing = camera("x", (60.0, -near, 20.0), (0.0, 0.0, 0.0), focal=650.0, size=(640, 480))
    for k, cam in enumerate(SMALL):
        here = replace(facing, name=cam.name, K=cam.K, distortion=np.array([barrel, 0, 0, 0, 0]))
        image = render(
            here, grid.xyz[:, 0], grid.radius_mm, optics=Optics(read_noise=1.0), rng=np.random.default_rng(k)
        )
        write_png(folder / "grid" / f"{cam.name}.png", image)


def test_a_grid_gives_the_lenses_and_the_points_the_rest(tmp_path):
    """Seven points cannot tell a lens; with one known beforehand they place the cameras."""
    grid_images(tmp_path, barrel=-0.1)
    uv = project_all(SMALL, POINTS) + 0.05 * np.random.default_rng(1).normal(size=(4, len(POINTS), 2))
    uv[:, np.setdiff1d(np.arange(24), [0, 3, 5, 8, 11, 14, 18, 21, 23])] = np.nan
    points_csv(tmp_path, uv=uv)
    plain = session(tmp_path, BY_POINTS).calibrate()
    way = f"{BY_POINTS}\n{GRID}"
    made = session(tmp_path, way).calibrate()
    assert off(made.rig) < 0.5 * off(plain.rig)
    before, after = made.figures["straightness"][0]["before_px"], made.figures["straightness"][0]["after_px"]
    assert before > 0.5 > 10 * after


def test_a_part_of_a_grid_is_enough_for_a_lens_and_said(tmp_path):
    grid_images(tmp_path, barrel=-0.1, near=540.0)
    points_csv(tmp_path)
    way = f"{BY_POINTS}\n{GRID}"
    made = session(tmp_path, way).calibrate()
    assert off(made.rig) < 0.2
    assert len(found(made.figures, "grid_partly_used")) >= 1


def test_a_grid_that_is_not_there_is_named(tmp_path):
    grid_images(tmp_path)
    points_csv(tmp_path)
    write_png(tmp_path / "grid" / "cam2.png", np.full((480, 640), 20, np.uint8))
    way = f"{BY_POINTS}\n{GRID}"
    with pytest.raises(KinemarkError, match="Camera cam2: the grid is in none of its images"):
        session(tmp_path, way).calibrate()


@pytest.mark.parametrize("by", [1.0, 6.0])
def test_fixed_marks_undo_a_shift_of_the_images(tmp_path, by):
    """As in the digitised films of a moved projector: all that a camera sees is shifted, the mark with it."""
    points_csv(tmp_path)
    shift = by * np.array([[6.0, -3.0], [-4.0, 2.0], [0.0, 5.0], [3.0, 3.0]])
    mark = np.array([1200.0, 700.0, 100.0])
    before = project_all(SMALL, mark)
    marks = ", ".join(f"{name} = [[{u}, {v}]]" for name, (u, v) in zip(SMALL.names, before, strict=True))
    truth = np.concatenate([TRIAL, np.tile(mark, (1, TRIAL.shape[1], 1))])
    found = detected(truth)
    way = f"{BY_POINTS}\nreference_marker = {{ {marks} }}"
    one = session(tmp_path, way if by == 1 else f"{way}\nmark_reach_px = 50")
    write_detections_csv(one.root / "one.csv", replace(found, uv=found.uv + shift[found.camera]))
    assert score(one.run(to="track")["one"].tracks, truth).rmse < 1.0
    plain = session(tmp_path, BY_POINTS if by == 1 else way)  # without marks, or looked for too near
    write_detections_csv(one.root / "one.csv", replace(found, uv=found.uv + shift[found.camera]))
    if by == 1:
        bad = plain.run(to="track")["one"]
        assert not score(bad.tracks, truth).recall > 0.5 or score(bad.tracks, truth).rmse > 5
    else:
        with pytest.raises(KinemarkError, match=r"its fixed mark 1 is seen within 20 px"):
            plain.run()


def test_marks_that_did_not_shift_alike_name_their_camera_and_how_much_is_allowed(tmp_path):
    points_csv(tmp_path)
    before = {name: [[100.0, 100.0], [500.0, 400.0]] for name in SMALL.names}
    now = {**before, "cam3": [[100.0, 100.0], [507.0, 400.0]]}
    said = [", ".join(f"{name} = {places}" for name, places in each.items()) for each in (before, now)]
    for tolerance, fine in ((3, False), (9, True)):
        one = session(tmp_path, f"{BY_POINTS}\nreference_marker = {{ {said[0]} }}\nmark_tolerance_px = {tolerance}")
        with (tmp_path / "session.toml").open("a") as file:
            file.write(f"reference_marker = {{ {said[1]} }}\n")
        opened = Session.open(one.root)
        if fine:
            assert opened.run(to="detect")["one"].detections.n_frames == TRIAL.shape[1]
        else:
            with pytest.raises(KinemarkError, match=r"Camera cam3: its 2 fixed marks .* 3 px are allowed"):
                opened.run()


def test_marks_that_do_not_fit_are_explained(tmp_path):
    points_csv(tmp_path)
    one = session(tmp_path, f"{BY_POINTS}\nreference_marker = {{ cam1 = [[10.0, 10.0]] }}")
    with pytest.raises(KinemarkError, match="no place for cam2, cam3, cam4"):
        one.run()


def test_masks_learned_from_an_empty_volume_leave_strobes_out(tmp_path):
    """A lamp in view of each camera would be a second marker."""
    rig = Rig(tuple(replace(c, size=np.array([96, 72]), K=np.diag([0.15, 0.15, 1]) @ c.K) for c in SMALL))
    write_rig_toml(tmp_path / "rig.toml", rig)
    path = np.array([1200.0, 700, 900]) + np.linspace(-300, 300, 20)[:, None] * [1, 0.5, 0.2]
    v, u = np.mgrid[:72, :96]
    lamp = 230.0 * (np.hypot(u - 80, v - 10) < 4)
    for name, uv in zip(rig.names, project_all(rig, path), strict=True):
        for kind, spots in (("empty", np.zeros((3, 0, 2))), ("one", uv[:, None])):
            for f, spot in enumerate(spots):
                (tmp_path / kind / name).mkdir(parents=True, exist_ok=True)
                image = lamp + sum(200 * np.exp(-((u - a) ** 2 + (v - b) ** 2) / 6) for a, b in spot) + 5
                write_png(tmp_path / kind / name / f"{f:03d}.png", np.minimum(image, 255).astype(np.uint8))
    text = f'name = "m"\nrate_hz = 50.0\n[cameras]\nnames = [{NAMES}]\n[calibration]\nfile = "rig.toml"\n'
    text += '[[trials]]\nname = "one"\nimages = "one/{camera}/*.png"\n'
    (tmp_path / "session.toml").write_text(text)
    plain = Session.open(tmp_path).run(to="detect")["one"].detections
    assert plain.valid.sum() == 2 * 4 * 20
    (tmp_path / "session.toml").write_text(text + '[masks]\nempty = "empty/{camera}/*.png"\n')
    result = Session.open(tmp_path).run(to="detect")["one"]
    assert result.computed[0] == "detect"
    assert result.detections.valid.sum() == 4 * 20
    unnamed = text.replace(f"names = [{NAMES}]\n", "")  # the calibration names the cameras
    (tmp_path / "session.toml").write_text(unnamed + '[masks]\nempty = "empty/{camera}/*.png"\n')
    assert learn_session_masks(tmp_path, tmp_path / "masks.toml") >= 4
    (tmp_path / "session.toml").write_text(text + '[masks]\nfile = "masks.toml"\n')
    assert Session.open(tmp_path).run(to="detect")["one"].detections.valid.sum() == 4 * 20


# -- results -----------------------------------------------------------------------------------------------------------


def test_former_calibrations_are_kept_and_compared(tmp_path):
    rig = SMALL
    write_rig_toml(tmp_path / "rig.toml", rig)
    one = session(tmp_path, 'file = "rig.toml"')
    assert one.calibrate().figures["change"] is None
    first = (tmp_path / "results/rig.toml").read_bytes()
    assert not one.calibrate().computed
    kicked = replace(rig[2], t=rig[2].t + np.array([0, 0, 15.0]))
    write_rig_toml(tmp_path / "rig.toml", replace(rig, cameras=(*rig.cameras[:2], kicked, *rig.cameras[3:])))
    made = one.calibrate()
    (kept,) = (tmp_path / "results/calibrations").iterdir()
    assert kept.read_bytes() == first
    assert made.figures["change"]["since"] == f"calibrations/{kept.name}"
    moved = {c["name"]: c["moved_mm"] for c in made.figures["change"]["cameras"]}
    assert moved["cam3"] == pytest.approx(15, abs=1e-3)
    assert max(moved[name] for name in ("cam1", "cam2", "cam4")) < 1e-3
    assert [one.cameras for one in found(made.figures, "cameras_moved_since")] == [("cam3",)]
    write_rig_toml(tmp_path / "rig.toml", rig)
    one.calibrate()
    assert len(list((tmp_path / "results/calibrations").iterdir())) == 2
    assert kept.read_bytes() == first


def test_a_calibration_that_stands_is_not_made_again_and_what_is_lost_is(tmp_path):
    points_csv(tmp_path)
    one = session(tmp_path, BY_POINTS)
    assert one.calibrate().computed
    times = {p: p.stat().st_mtime_ns for p in (tmp_path / "results").iterdir()}
    again = one.calibrate()
    assert not again.computed
    assert {p: p.stat().st_mtime_ns for p in times if p.name != "steps.json"} == {
        p: t for p, t in times.items() if p.name != "steps.json"
    }
    assert again.figures["verdict"]["headline"]
    for name in ("calibration.html", "calibration.json"):
        (tmp_path / "results" / name).unlink()
        assert one.calibrate().computed
        assert (tmp_path / "results" / name).is_file()
    assert not (tmp_path / "results/calibrations").exists()


def command(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "kinemark", *map(str, arguments)], capture_output=True, text=True, check=False
    )


def test_the_commands(tmp_path, capsys):
    def said(*arguments):
        capsys.readouterr()
        with suppress(SystemExit):
            app([str(argument) for argument in arguments])
        return json.loads(capsys.readouterr().out)

    points_csv(tmp_path)
    session(tmp_path, BY_POINTS)
    done = command("calibrate", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "per axis in 95" in done.stdout
    assert "calibration.html" in done.stdout
    figures = said("calibrate", tmp_path, "--json")
    assert figures == json.loads((tmp_path / "results/calibration.json").read_text())
    image = render(SMALL[0], POINTS, np.full(len(POINTS), 12.5), rng=np.random.default_rng(0))
    write_png(tmp_path / "frame.png", image)
    proposed = said("detect", tmp_path / "frame.png", "--propose", "--json")
    assert 20 < proposed["frame.png"]["threshold"] < 200
    with pytest.raises(KinemarkError, match="--propose"):
        app(["detect", str(tmp_path)])


def test_a_simulated_laboratory_can_have_a_wand(tmp_path):
    with pytest.raises(KinemarkError, match="goes with the walk"):
        simulate(tmp_path / "x", scene=Scene(motion="circle", calibration="wand"))
    scene = Scene(seconds=0.04, cameras=2, size_px=(188, 146), focal_px=192.0, calibration="wand")
    settings = Session.open(simulate(tmp_path / "s", scene=scene)).settings.calibration
    assert (settings.way, settings.wand.lengths_mm, settings.l_frame.arms_mm) == ("wand", (500.0,), (800.0, 600.0))
    assert {p.name for p in (tmp_path / "s/wand").iterdir()} == {"cam1.mkv", "cam2.mkv"}
    assert {p.name for p in (tmp_path / "s/lframe").iterdir()} == {"cam1.png", "cam2.png"}


def three_markers(folder, *, frames=25, pushed=0):
    """A session's wand of 200 + 300 mm, and an L-frame over some frames, pushed aside in the last ones."""
    folder.mkdir()
    write_detections_csv(folder / "wand.csv", detected(wand((0.0, 200.0, 500.0), duration_s=48.0, rate=2.5).xyz))
    corner = np.array([[0, 0, 12.5], [800, 0, 12.5], [0, 600, 12.5]], float)
    places = np.repeat(corner[:, None], frames, 1)
    places[:, frames - pushed :] += np.array([60.0, 25.0, 0.0])
    write_detections_csv(folder / "lframe.csv", detected(places, noise=0.4, seed=1))
    return folder


def test_gaps_of_a_wand_that_are_measured_wrong_are_said_and_the_calibration_goes_on(tmp_path):
    folder = three_markers(tmp_path / "s")
    by_wand = 'wand = {{ lengths_mm = {}, detections = "wand.csv" }}\n'
    right = session(folder, by_wand.format([200.0, 300.0]) + L_FRAME).calibrate()
    wrong = session(folder, by_wand.format([201.8, 298.2]) + L_FRAME).calibrate()
    assert not {"wand_gaps_differ", "camera_moved_while_calibrating"} & set(kinds(right.figures))
    (said,) = found(wrong.figures, "wand_gaps_differ")
    assert said.severity == "amber"
    assert list(said.values["seen_mm_list"]) == pytest.approx([200.0, 300.0], abs=0.15)
    assert ("gaps seen as" in wrong.rig.method, "gaps seen as" in right.rig.method) == (True, False)
    assert np.abs(wrong.rig.centres - right.rig.centres).max() < 1.0  # mm
    check_findings(wrong.figures)


def test_a_camera_that_is_moved_while_the_wand_is_waved_is_told_with_when(tmp_path):
    folder = three_markers(tmp_path / "s")
    waved = detected(wand((0.0, 200.0, 500.0), duration_s=96.0, rate=2.5).xyz, noise=0.3)
    uv = waved.uv + np.where(((waved.camera == 1) & (waved.frame >= 120))[:, None], 1.5, 0.0)
    write_detections_csv(folder / "wand.csv", Detections.build(waved.cameras, 2.5, waved.counts, uv))
    made = session(folder, BY_WAND.replace("500.0", "200.0, 300.0") + "\n" + L_FRAME).calibrate()
    check_findings(made.figures)
    (said,) = found(made.figures, "camera_moved_while_calibrating")
    assert (said.severity, said.cameras) == ("amber", (waved.cameras[1],))
    assert said.values["kept"] == "after" and "before that were left out" in text_of(said)
    assert said.values["offset_px"] == pytest.approx(1.5 * np.sqrt(2), rel=0.2)
    assert said.frames[0] == (121, waved.n_frames)  # counted from 1
    assert "was probably moved while calibrating: from about frame" in text_of(said)


def test_images_that_a_camera_lost_while_the_wand_was_waved_are_told(tmp_path):
    folder = three_markers(tmp_path / "s")
    waved = detected(wand((0.0, 200.0, 500.0), duration_s=10.0, rate=20).xyz)
    shown = np.arange(200) + (np.arange(200) >= 80)
    parts = [waved[c, f] for c in range(4) for f in (np.minimum(shown, 199) if c == 1 else range(200))]
    counts = np.reshape([len(part) for part in parts], (4, 200))
    write_detections_csv(folder / "wand.csv", Detections.build(waved.cameras, 20, counts, np.concatenate(parts)))
    made = session(folder, BY_WAND.replace("500.0", "200.0, 300.0") + "\n" + L_FRAME).calibrate()
    check_findings(made.figures)
    (said,) = found(made.figures, "camera_lost_images_while_calibrating")
    assert (said.severity, said.cameras, said.values["images"]) == ("amber", (waved.cameras[1],), 1)
    assert said.frames[0][0] - 3 <= 81 <= said.frames[0][1] + 3  # counted from 1
    assert f"Camera {waved.cameras[1]} lost 1 image of the wand" in text_of(said)
    assert not found(made.figures, "camera_moved_while_calibrating")


def test_the_world_rests_on_all_frames_of_the_l_frame(tmp_path):
    one = session(three_markers(tmp_path / "one", frames=1), BY_WAND.replace("500.0", "200.0, 300.0") + "\n" + L_FRAME)
    many = session(
        three_markers(tmp_path / "many", pushed=4), BY_WAND.replace("500.0", "200.0, 300.0") + "\n" + L_FRAME
    )
    off = {}
    for name, opened in (("one", one), ("many", many)):
        made = opened.calibrate()
        off[name] = np.abs(made.figures["checks"][0]["found_mm"] - 800)
        assert [one.values["frame_count"] for one in found(made.figures, "l_frame_moved")] == (
            [4] if name == "many" else []
        )
    assert off["many"] < 0.6 * off["one"]
