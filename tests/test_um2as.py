"""The flow of UM²AS from control balls to angles: functions, files, the command line, a session."""

import io
import json
from datetime import date
from itertools import combinations

import numpy as np
import pytest
from eating import POST, SIZE, Knowing, footage, laboratory, looks_of, meal

from kinemark import um2as_cli
from kinemark.cli import app
from kinemark.data import KinemarkError
from kinemark.digitise import SemiAutomatic
from kinemark.digitising import Reel, digitise_camera
from kinemark.formats import convert, describe
from kinemark.geometry import from_dlt, project_all, to_dlt, triangulate
from kinemark.io.answers_csv import append_answer, read_answers, write_answers
from kinemark.io.c3d import markers, read_c3d
from kinemark.io.images import open_images, write_png
from kinemark.io.um2as import (
    read_angles,
    read_cp,
    read_rf,
    read_tdc,
    trajectories_of_tdc,
    write_cp,
    write_da,
    write_msr,
    write_tdc,
)
from kinemark.io.video import write_video
from kinemark.reconstruct import LeastSquares
from kinemark.reconstruct.pairs import agreeing
from kinemark.session import Session
from kinemark.synth import Optics, render, ring, truth
from kinemark.um2as import (
    angles_files,
    calibrate_file,
    calibrated,
    coordinates_files,
    limb_angles,
    placed,
    table,
)

CM = ((72.2, 40.5, -6.4), (60.0, 31.8, 31.5), (63.6, 5.8, 59.5), (46.8, 16.8, -7.5))
CM += ((21.0, 5.7, 73.9), (13.7, 46.7, 37.8), (48.3, 72.3, 62.2), (32.5, 31.2, 58.9))
BALLS = 10 * np.array(CM)
"""mm; the places that figure 3.5 of the thesis prints."""

MARKERS = ("1", "2", "3", "4", "5", "6", "7", "REF")


def seen_balls(noise=0.1, seed=0):
    rig = laboratory()
    uv = project_all(rig, BALLS)
    return rig, uv + np.random.default_rng(seed).normal(0, noise, uv.shape)


def seen_meal(noise=0.1, seed=1, seconds=1.5):
    """(rig, subject, uv (C, M, F, 2)) with what the lamp hides as NaN."""
    rig, subject = laboratory(), meal(seconds)
    sight = truth(rig, subject)
    uv = sight.uv + np.random.default_rng(seed).normal(0, noise, sight.uv.shape)
    uv[sight.visible < 0.5] = np.nan
    return rig, subject, uv


def files(tmp_path, cameras=(0, 1, 2)):
    """box.msr, box.cpN and feed.daN of these cameras, and the subject."""
    write_msr(tmp_path / "box.msr", BALLS)
    _, balls = seen_balls()
    _, subject, uv = seen_meal()
    for c in cameras:
        calibrate_file(tmp_path / "box.msr", tmp_path / f"box.cp{c + 1}", balls[c], made=date(1992, 11, 27))
        write_da(tmp_path / f"feed.da{c + 1}", uv[c])
    return [tmp_path / f"box.cp{c + 1}" for c in cameras], [tmp_path / f"feed.da{c + 1}" for c in cameras], subject


# ---- Calibration ----


def test_parameters_without_noise_are_those_of_the_cameras():
    rig, uv = seen_balls(noise=0)
    found = calibrated(rig.names, BALLS, uv)
    np.testing.assert_allclose(to_dlt(found.P), to_dlt(rig.P), rtol=1e-6, atol=1e-9)


def test_parameters_see_the_balls_as_those_of_the_thesis_do():
    """Equation 2.4 in the raw coordinates weighs errors a little otherwise: by less than a tenth of the noise."""
    rig, uv = seen_balls(noise=0.3)
    found = project_all(calibrated(rig.names, BALLS, uv), BALLS)
    one = np.ones((8, 1))
    for c, own in enumerate(uv):
        u, v = own[:, :1], own[:, 1:]
        A = np.zeros((16, 11))
        A[::2] = np.hstack([BALLS, one, 0 * BALLS, 0 * one, -u * BALLS])
        A[1::2] = np.hstack([0 * BALLS, 0 * one, BALLS, one, -v * BALLS])
        L = np.linalg.lstsq(A, own.ravel(), rcond=None)[0]
        x = np.hstack([BALLS, one]) @ from_dlt(L).T
        assert np.abs(found[c] - x[:, :2] / x[:, 2:]).max() < 0.03


def test_a_camera_from_measured_places_to_its_file(tmp_path):
    write_msr(tmp_path / "box.msr", BALLS)
    rig, uv = seen_balls()
    made, off = calibrate_file(tmp_path / "box.msr", tmp_path / "box.cp2", uv[1])
    assert made.names == ("cam2",) and 0.01 < np.sqrt((off**2).mean()) < 0.2
    np.testing.assert_allclose(read_cp(tmp_path / "box.cp2").L, to_dlt(made.P)[0], atol=0.51e-7)
    moved = project_all(made, BALLS)[0] - project_all(rig, BALLS)[1]
    assert np.abs(moved).max() < 0.5
    with pytest.raises(KinemarkError, match="8 control balls, and 7 were digitised"):
        calibrate_file(tmp_path / "box.msr", tmp_path / "box.cp2", uv[1, :7])
    with pytest.raises(ValueError, match="date"):
        calibrate_file(tmp_path / "box.msr", tmp_path / "box.cp1", uv[0])


def test_balls_that_make_no_camera_are_refused(tmp_path):
    rig, uv = seen_balls()
    with pytest.raises(KinemarkError, match="5 control points are seen"):
        calibrated(rig.names, BALLS[:5], uv[:, :5])
    flat = BALLS * (1, 1, 0)
    with pytest.raises(KinemarkError, match="plane"):
        calibrated(rig.names, flat, project_all(rig, flat))


# ---- Places ----


def test_places_are_right_and_those_of_one_camera_are_not_known():
    rig, subject, uv = seen_meal()
    uv[1:, 3, 5] = np.nan  # one camera left
    uv[:, 6] = np.nan  # none
    found = placed(rig, uv, names=subject.names)
    off = np.linalg.norm(found.xyz - subject.xyz, axis=-1)
    expected = np.isfinite(uv[..., 0]).sum(0) >= 2
    assert (np.isfinite(off) == expected).all()
    assert np.sqrt(np.nanmean(off**2)) < 0.5 and found.names == subject.names
    sd = np.sqrt(np.trace(np.array([p.cov for p in found.paths]), axis1=-2, axis2=-1))
    assert np.sqrt(np.nanmean((off / sd) ** 2)) == pytest.approx(1, abs=0.3)


@pytest.mark.parametrize("cameras", [(0, 1), (1, 2), (0, 2), (0, 1, 2)])
def test_two_and_three_cameras_from_files_to_a_file(tmp_path, cameras):
    cps, das, subject = files(tmp_path, cameras)
    found = coordinates_files(cps, das[::-1], tmp_path / "feed.tdc", markers=8)
    np.testing.assert_allclose(read_tdc(tmp_path / "feed.tdc"), found.xyz, atol=0.51e-6)
    off = np.linalg.norm(found.xyz - subject.xyz, axis=-1)
    assert np.sqrt(np.nanmean(off**2)) < 1.5


def test_four_cameras(tmp_path):
    rig = ring(4, radius=2400.0, target=(420.0, 300.0, 400.0), focal_px=1080.0, size=SIZE)
    subject = meal(0.5)
    sight = truth(rig, subject)
    uv = sight.uv + np.random.default_rng(0).normal(0, 0.1, sight.uv.shape)
    write_msr(tmp_path / "box.msr", BALLS)
    for c, balls in enumerate(project_all(rig, BALLS)):
        calibrate_file(tmp_path / "box.msr", tmp_path / f"box.cp{c + 1}", balls, made=date(2026, 1, 2))
        write_da(tmp_path / f"feed.da{c + 1}", uv[c])
    cps, das = ([tmp_path / f"{n}{c}" for c in (1, 2, 3, 4)] for n in ("box.cp", "feed.da"))
    off = np.linalg.norm(coordinates_files(cps, das, tmp_path / "feed.tdc").xyz - subject.xyz, axis=-1)
    assert np.sqrt((off**2).mean()) < 0.5


def test_equation_2_5_weighs_a_little_otherwise():
    """By the scale of L instead of by depth, which moves places by a small part of their error."""
    rig, subject, uv = seen_meal(noise=0.2)
    ours = placed(rig, uv).xyz
    P = from_dlt(to_dlt(rig.P))
    seen = uv.reshape(3, -1, 2).transpose(1, 0, 2)
    pairs = list(combinations(range(3), 2))
    each = np.stack([triangulate(seen[:, pair], P[list(pair)]) for pair in pairs], 1)
    kept = agreeing(each, np.isfinite(seen[..., 0]).sum(1))
    thesis = (np.nansum(np.where(kept[..., None], each, 0), 1) / kept.sum(1)[:, None]).reshape(ours.shape)
    off = [np.sqrt(np.nanmean((xyz - subject.xyz) ** 2)) for xyz in (ours, thesis)]
    assert off[0] == pytest.approx(off[1], rel=0.1)
    assert np.sqrt(np.nanmean((ours - thesis) ** 2)) < off[0] / 2


def test_other_methods_of_reconstruction_do_as_well():
    rig, subject, uv = seen_meal(noise=0.3)
    pairs, least = (np.nanmean((placed(rig, uv, **m).xyz - subject.xyz) ** 2) for m in ({}, {"method": LeastSquares()}))
    assert least < pairs


def test_sets_that_do_not_fit_are_refused(tmp_path):
    cps, das, _ = files(tmp_path)
    out = tmp_path / "feed.tdc"
    for some_cps, some_das, message in (
        (cps[:2], das, "calibration is of cam1, cam2 and the motion of cam1, cam2, cam3"),
        (cps[:2], das[::2], "files of the same cameras"),
        (cps[:1], das[:1], "needs two"),
        ([cps[0], cps[0]], das[:2], "both of camera 1"),
        (cps[1:], das[1:], "does not say how many markers"),
    ):
        with pytest.raises(KinemarkError, match=message):
            coordinates_files(some_cps, some_das, out)
        assert not out.exists()
    with pytest.raises(ValueError, match="names"):
        placed(laboratory(), np.zeros((3, 2, 4, 2)), names=["a"])


# ---- Angles ----


def test_angles_from_files_are_those_that_made_the_motion(tmp_path):
    cps, das, subject = files(tmp_path)
    coordinates_files(cps, das, tmp_path / "feed.tdc")
    angles_files(tmp_path / "feed.tdc")
    for j, ending in enumerate((".shd", ".elb", ".wst")):
        off = read_angles(tmp_path / f"feed{ending}") - subject.angles.deg[j]
        assert np.sqrt(np.nanmean(off**2)) < 1.0


def test_inverse_cosines_have_no_sign(tmp_path):
    subject = meal(1.0)
    paths = placed(laboratory(), truth(laboratory(), subject).uv)
    signed, plain = limb_angles(paths), limb_angles(paths, signed=False)
    np.testing.assert_allclose(plain.deg[:, :, 0], np.abs(signed.deg[:, :, 0]), atol=0.5)
    assert (signed.deg[2, :, 0] < -1).any()


def test_named_outputs_and_wrong_ones(tmp_path):
    cps, das, _ = files(tmp_path)
    tdc = tmp_path / "feed.tdc"
    coordinates_files(cps, das, tdc)
    angles_files(tdc, [tmp_path / "only.elb"])
    assert {p.name for p in tmp_path.glob("*.elb")} == {"only.elb"} and not list(tmp_path.glob("*.shd"))
    with pytest.raises(KinemarkError, match="does not end in"):
        angles_files(tdc, [tmp_path / "feed.txt"])
    with pytest.raises(KinemarkError, match="names are given"):
        trajectories_of_tdc(tdc, rate=30.0, names=["a"])


def test_places_become_a_c3d_file(tmp_path):
    xyz = np.random.default_rng(0).normal(0, 500, (3, 5, 3)).round(1)
    write_tdc(tmp_path / "feed.tdc", xyz)
    convert(tmp_path / "feed.tdc", tmp_path / "feed.c3d", rate_hz=60.0)
    back = markers(read_c3d(tmp_path / "feed.c3d"))
    np.testing.assert_allclose(back.xyz, xyz, atol=1e-3)
    assert back.rate == 60.0 and back.names == ("1", "2", "3")
    assert describe(tmp_path / "feed.tdc")["rate"] == "30 Hz"


def test_every_file_can_be_looked_at(tmp_path):
    cps, das, _ = files(tmp_path)
    coordinates_files(cps, das, tmp_path / "feed.tdc")
    angles_files(tmp_path / "feed.tdc")
    for name, rows in (("box.msr", 8), ("box.cp1", 11), ("feed.da1", 360), ("feed.tdc", 360), ("feed.wst", 45)):
        assert len(table(tmp_path / name)[1]) == rows
    assert table(tmp_path / "box.msr")[1][0] == pytest.approx((1, 72.2, 40.5, -6.4))
    with pytest.raises(KinemarkError, match="none of UM²AS's files"):
        table(tmp_path / "feed.c3d")


# ---- The answers' file ----


def test_answers_are_kept_as_they_were_given(tmp_path):
    path = tmp_path / "a" / "cam1.csv"
    assert read_answers(path) == []
    path.parent.mkdir()
    path.write_text("frame,marker,answer\n1,ELB4,312 204\n1,MC37,-\n1,,save\n")
    given = read_answers(path)
    assert [g.frame for g in given] == [0, 0, 0] and given[2].marker == ""
    append_answer(path, given[0])
    assert read_answers(path) == [*given, given[0]]
    write_answers(tmp_path / "b.csv", given)
    assert read_answers(tmp_path / "b.csv") == given


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("marker,frame,answer\n", "line 1: wanted the heading"),
        ("frame,marker,answer\n1,a\n", "line 2: has 2 cells"),
        ("frame,marker,answer\n0,a,-\n", "frame is '0'"),
        ("frame,marker,answer\n1,a,maybe\n", "line 2: 'maybe' is not understood"),
    ],
)
def test_wrong_answers_are_refused(tmp_path, text, message):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(KinemarkError, match=message):
        read_answers(tmp_path / "a.csv")


# ---- At the command line and in a session ----

FRAMES = 6


def command(*words):
    try:
        app([str(word) for word in words])
    except SystemExit as stop:
        assert not stop.code


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A folder with images of the control balls and of a motion, and the pixels of the balls (C, 9, 2)."""
    folder = tmp_path_factory.mktemp("recorded")
    rig, _, _, images = footage(FRAMES / 30)
    write_msr(folder / "box.msr", BALLS)
    balls = np.concatenate([BALLS, POST[None]])
    rng = np.random.default_rng(0)
    for c, camera in enumerate(rig):
        write_png(folder / f"box{c + 1}.png", render(camera, balls, 17.0, optics=Optics(subsamples=2), rng=rng))
        write_video(folder / f"cam{c + 1}.mkv", images[c], 30.0)
    return folder, project_all(rig, balls)


def answered(folder, c, path):
    """The operator digitises camera c, and his answers are kept."""
    _, _, sight, images = footage(FRAMES / 30)
    operator = Knowing(sight, c, looks_of(images[c]))
    reel = Reel(open_images(folder / f"cam{c + 1}.mkv"))
    method = SemiAutomatic(MARKERS, "REF")
    return digitise_camera(
        reel, method=method, answers=path, operator=operator, constant=read_rf(folder / f"box.rf{c + 1}")
    )


def test_the_whole_menu_from_images_to_angles(recorded, capsys, monkeypatch):
    folder, balls = recorded
    monkeypatch.chdir(folder)
    command("um2as", "snap", "box1.png", "white.png")
    assert "9 markers" in capsys.readouterr().out
    for c, places in enumerate(balls):
        at = [f"{u:.0f} {v:.0f}" for u, v in places]
        command("um2as", "reference", f"box{c + 1}.png", f"box.rf{c + 1}", "--at", at[8])
        command("um2as", "calibrate", "box.msr", f"box{c + 1}.png", f"box.cp{c + 1}", "--at", *at[:8])
        given = folder / "answers" / f"cam{c + 1}.csv"
        given.parent.mkdir(exist_ok=True)
        answered(folder, c, given)
        reference = ("--reference", "REF", "--reference-file", f"box.rf{c + 1}", "--answers", given)
        command("um2as", "digitise", f"cam{c + 1}.mkv", f"feed.da{c + 1}", "--markers", *MARKERS, *reference)
    said = capsys.readouterr().out
    assert said.count("px off on average") == 3 and said.count("16 questions were asked (16 first two frames)") == 3
    names = [[f"{stem}{c}" for c in (1, 2, 3)] for stem in ("box.cp", "feed.da")]
    command("um2as", "coordinates", "feed.tdc", "--calibration", *names[0], "--data", *names[1])
    command("um2as", "angles", "feed.tdc")
    command("um2as", "view", "feed.tdc", "--frame", "2")
    assert capsys.readouterr().out.splitlines()[-8].startswith("2\t1\t")
    subject = footage(FRAMES / 30)[1]
    assert np.abs(read_tdc(folder / "feed.tdc") - subject.xyz).max() < 1.0
    assert np.abs(read_angles(folder / "feed.shd") - subject.angles.deg[0]).max() < 1.5


def test_an_operator_types_stops_and_goes_on(recorded, capsys, monkeypatch, tmp_path):
    folder, _ = recorded
    sight = footage(FRAMES / 30)[2]
    at = ["{:.0f} {:.0f}".format(*uv) for uv in sight.uv[2, :, 0]]
    second = ["{:.0f} {:.0f}".format(*uv) for uv in sight.uv[2, :, 1]]
    u, v = sight.uv[2, 7, 0].round() + 0.25
    typed = ["nonsense", "3 3", at[1], "undo", *at, "verify", *["y"] * 7, "n", f"{u} {v}", "save", second[0], "quit"]
    monkeypatch.setattr("sys.stdin", io.StringIO("\n".join(typed) + "\n"))
    output = tmp_path / "feed.da1"
    words = ("um2as", "digitise", folder / "cam3.mkv", output, "--markers", "8")
    command(*words)
    said = capsys.readouterr().out
    assert "not understood" in said and "no white pixel" in said and "5 frames are still to be digitised" in said
    first = output.read_text().splitlines()
    assert first[0] == "Number of frames: 1 Number of markers: 8" and first[8] == f"{u:.7f}\t{v:.7f}"
    typed = [*second[1:], "save", *["save"] * (FRAMES - 2)]
    monkeypatch.setattr("sys.stdin", io.StringIO("\n".join(typed) + "\n"))
    command(*words)
    assert output.read_text().splitlines()[1:9] == first[1:9]
    said = capsys.readouterr().out
    assert f"{FRAMES} frames of 8 markers, 0 not present." in said and "1 places corrected" in said
    assert said.count("point at marker") == 7  # the other answers were kept


def test_other_cameras_are_asked_at_the_command_line(recorded, capsys, monkeypatch, tmp_path):
    folder, _ = recorded
    monkeypatch.chdir(tmp_path)
    cps, _, _ = files(tmp_path)
    sight = footage(FRAMES / 30)[2]
    for c in (1, 2):
        write_da(tmp_path / f"feed.da{c + 1}", sight.uv[c])
    monkeypatch.setattr("sys.stdin", io.StringIO("nothing is read\n"))
    known = ("--calibration", *cps, "--others", "feed.da2", "feed.da3", "--take-proposals", "--save-all")
    command("um2as", "digitise", folder / "cam1.mkv", "feed.da1", "--markers", "8", *known, "--json")
    figures = json.loads(capsys.readouterr().out)
    assert figures["questions"] == 0 and figures["proposals_taken_unasked"] >= 16
    with pytest.raises(KinemarkError, match="--calibration must name"):
        app(["um2as", "digitise", str(folder / "cam1.mkv"), "feed.da1", "--markers", "8", "--others", "feed.da2"])


def test_help_explains_every_option(capsys):
    for name in ("snap", "reference", "calibrate", "digitise", "coordinates", "angles", "view"):
        command("um2as", name, "--help")
        said = capsys.readouterr().out
        bare = [line for line in said.splitlines() if line.startswith("│") and line.strip("│ *").startswith("--")]
        assert all(len(line.strip("│ *").split("  ", 1)) == 2 for line in bare)
    assert um2as_cli.um2as.help


def session_of(folder, tmp_path, trial):
    marks = "\n".join(f"cam{c} = [{read_rf(folder / f'box.rf{c}').tolist()}]" for c in (1, 2, 3))
    text = f"""
name = "eating"
rate_hz = 30.0
[cameras]
names = ["cam1", "cam2", "cam3"]
[calibration]
file = "{folder}/box.cp1"
[calibration.reference_marker]
{marks}
[digitise]
markers = {list(MARKERS)}
reference = "REF"
[reconstruct]
method = "camera_pairs"
within_volume = false
[[trials]]
name = "feeding"
{trial}
"""
    (tmp_path / "session.toml").write_text(text, "utf-8")
    return Session.open(tmp_path)


def prepared(recorded, monkeypatch):
    """The calibration's files, which the session's tests share with the menu's."""
    folder, balls = recorded
    monkeypatch.chdir(folder)
    for c, places in enumerate(balls):
        at = [f"{u:.0f} {v:.0f}" for u, v in places]
        command("um2as", "reference", f"box{c + 1}.png", f"box.rf{c + 1}", "--at", at[8])
        command("um2as", "calibrate", "box.msr", f"box{c + 1}.png", f"box.cp{c + 1}", "--at", *at[:8])
    return folder


def test_a_session_digitises_by_answers_and_says_how_many_questions_there_were(recorded, monkeypatch, tmp_path):
    folder = prepared(recorded, monkeypatch)
    trial = f'images = "{folder}/{{camera}}.mkv"\nanswers = "answers/{{camera}}.csv"'
    session = session_of(folder, tmp_path, trial)
    with pytest.raises(KinemarkError, match=r"Frame 1: point at marker 1.*Answer it: kinemark digitise"):
        session.run()
    (tmp_path / "answers").mkdir()
    for c in range(3):
        answered(folder, c, tmp_path / "answers" / f"cam{c + 1}.csv")
    done = session.run()["feeding"]
    subject = footage(FRAMES / 30)[1]
    assert np.abs(done.trajectories.xyz - subject.xyz).max() < 1.0 and done.trajectories.names == MARKERS
    quality = json.loads((done.folder / "quality.json").read_text())
    assert quality["digitising"]["questions"] == 48 and set(quality["digitising"]["cameras"]) == {
        "cam1",
        "cam2",
        "cam3",
    }
    assert session.run()["feeding"].computed == ()


def test_answers_that_no_question_was_put_for_are_refused(recorded, monkeypatch, tmp_path):
    folder = prepared(recorded, monkeypatch)
    kept = tmp_path / "cam3.csv"
    answered(folder, 2, kept)
    with kept.open("a") as file:
        file.write("5,,frame 2\n")
    with pytest.raises(KinemarkError, match="1 answers to questions that were not put"):
        digitise_camera(Reel(open_images(folder / "cam3.mkv")), method=SemiAutomatic(MARKERS, "REF"), answers=kept)


def test_a_sessions_operator_types(recorded, capsys, monkeypatch, tmp_path):
    """The answers of two cameras are there, and two other cameras propose those of the third; then one goes missing."""
    folder = prepared(recorded, monkeypatch)
    trial = f'images = "{folder}/{{camera}}.mkv"\nanswers = "answers/{{camera}}.csv"'
    session_of(folder, tmp_path, trial)
    (tmp_path / "answers").mkdir()
    for c in range(2):
        answered(folder, c, tmp_path / "answers" / f"cam{c + 1}.csv")
    sight = footage(FRAMES / 30)[2]
    reference = "{:.0f} {:.0f}".format(*sight.uv[2, 7, 0])
    by_hand = [*["y"] * 7, reference, "save"]
    monkeypatch.setattr("sys.stdin", io.StringIO("\n".join([*by_hand * 2, *["save"] * (FRAMES - 2)]) + "\n"))
    command("digitise", tmp_path, "feeding")
    said = capsys.readouterr().out
    assert said.count("The other cameras say: it is at") == 14 and "48 questions were asked" in said
    assert len(read_answers(tmp_path / "answers" / "cam3.csv")) == 16 + FRAMES
    with pytest.raises(KinemarkError, match="no camera 'cam9'"):
        app(["digitise", str(tmp_path), "feeding", "--camera", "cam9"])
    with pytest.raises(KinemarkError, match="no trial with images and answers"):
        app(["digitise", str(tmp_path), "drinking"])
    L = read_cp(folder / "box.cp2").L
    before = Session.open(tmp_path).calibrate().rig
    write_cp(folder / "box.cp2", L * (1, 1, 1, 1.01, 1, 1, 1, 1, 1, 1, 1))
    assert not np.array_equal(Session.open(tmp_path).calibrate().rig.P, before.P)  # any of the set's files counts


def test_a_session_takes_digitised_files(recorded, monkeypatch, tmp_path):
    folder = prepared(recorded, monkeypatch)
    _, subject, sight, _ = footage(FRAMES / 30)
    for c, uv in enumerate(sight.uv):
        write_da(tmp_path / f"feed.da{c + 1}", uv)
    done = session_of(folder, tmp_path, 'detections = "feed.da1"').run()["feeding"]
    assert done.trajectories.names == MARKERS
    assert np.abs(done.trajectories.xyz - subject.xyz).max() < 0.5
    text = (tmp_path / "session.toml").read_text()
    (tmp_path / "session.toml").write_text(text.replace("'REF'", "'POST'").replace('"REF"', '"POST"'))
    again = Session.open(tmp_path).run()["feeding"]
    assert again.trajectories.names[-1] == "POST"
    assert markers(read_c3d(again.folder / "feeding.c3d")).names[-1] == "POST"
    (tmp_path / "feed.da3").unlink()
    with pytest.raises(KinemarkError, match="a set of 2 cameras, and the calibration has cam1, cam2, cam3"):
        session_of(folder, tmp_path, 'detections = "feed.da1"').run()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('detections = "feed.da1"', 'detections = "feed.da1"\nanswers = "a"', "answers, which are of images"),
        ('[digitise]\nmarkers = ["1"]', "", "give \\[digitise\\]"),
        ('markers = ["1"]', 'markers = ["1"]\ngrid = 0', "grid"),
        ('markers = ["1"]', 'markers = ["1"]\ngreed = 5', "'greed' is not a parameter"),
    ],
)
def test_settings_that_do_not_fit_are_refused(tmp_path, old, new, message):
    text = """
name = "x"
[calibration]
file = "box.cp1"
[digitise]
markers = ["1"]
[[trials]]
name = "t"
TRIAL
"""
    trial = 'detections = "feed.da1"' if "detections" in old else 'images = "{camera}.mkv"\nanswers = "{camera}.csv"'
    (tmp_path / "session.toml").write_text(text.replace("TRIAL", trial).replace(old, new))
    with pytest.raises(KinemarkError, match=message):
        Session.open(tmp_path)
