"""The flow of UM²AS at the command line and in a session."""

import io
import json
import re

import numpy as np
import pytest
from scipy import ndimage

from kinemark.apps import um2as as um2as_cli
from kinemark.apps.cli import app
from kinemark.data import KinemarkError
from kinemark.digitise import SemiAutomatic
from kinemark.engine.digitising.files import DigitisedFrames, digitise_camera
from kinemark.engine.session import Session
from kinemark.geometry import project_all
from kinemark.io.answers_csv import read_answers
from kinemark.io.c3d import read_c3d
from kinemark.io.images import open_images, write_png
from kinemark.io.um2as import read_angles, read_cp, read_rf, read_tdc, write_cp, write_da, write_msr
from kinemark.io.video import write_video
from kinemark.report.terminal_summary import summary
from kinemark.synth import Optics, render
from support.boxed import BALLS, MARKERS, files
from support.command_line import command
from support.eating import POST, Knowing, footage, image_source
from support.schema import check_quality

FRAMES = 6


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
    operator = Knowing(sight, c, image_source(images[c]))
    reel = DigitisedFrames(open_images(folder / f"cam{c + 1}.mkv"))
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


def test_white_pixels_give_the_centroids_of_the_thesis(recorded, capsys, monkeypatch):
    folder, balls = recorded
    monkeypatch.chdir(folder)
    at = ("--at", f"{balls[0][8][0]:.0f} {balls[0][8][1]:.0f}")
    command("um2as", "reference", "box1.png", "white.rf1", *at, "--white-pixels")
    command("um2as", "snap", "box1.png", "white.png")
    capsys.readouterr()
    groups = ndimage.label(next(open_images(folder / "white.png").frames()) > 0, np.ones((3, 3)))[0]
    u, v = np.rint(balls[0][8]).astype(int)
    mean = ndimage.center_of_mass(groups == groups[v, u])[::-1]
    np.testing.assert_allclose(read_rf(folder / "white.rf1"), mean, atol=1e-6)


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


def test_a_reel_goes_back_further_than_it_keeps(recorded, monkeypatch):
    folder, _ = recorded
    monkeypatch.setattr("kinemark.engine.digitising.files.KEPT", 1)
    reel = DigitisedFrames(open_images(folder / "cam1.mkv"))
    first = [reel(f).uv for f in range(FRAMES)]
    for f in (4, 1, 5, 0):
        np.testing.assert_array_equal(reel(f).uv, first[f])


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
    check_quality(quality)
    assert quality["digitising"]["questions"] == 48 and set(quality["digitising"]["cameras"]) == {
        "cam1",
        "cam2",
        "cam3",
    }
    page = (done.folder / "report.html").read_text()
    assert "An operator digitised this trial: 48 questions for 144 images of markers" in page
    assert "An operator digitised this trial: 48 questions" in summary(quality)
    assert session.run()["feeding"].computed == ()


@pytest.mark.parametrize("times", ["delays_ms = { cam2 = 5 }", "rates_hz = { cam2 = 29.9 }"])
def test_digitised_trials_refuse_cameras_with_times_of_their_own(recorded, monkeypatch, tmp_path, times):
    folder = prepared(recorded, monkeypatch)
    session_of(folder, tmp_path, f'images = "{folder}/{{camera}}.mkv"\nanswers = "answers/{{camera}}.csv"')
    settings = tmp_path / "session.toml"
    settings.write_text(settings.read_text("utf-8").replace("[calibration]", f"{times}\n[calibration]", 1), "utf-8")
    with pytest.raises(KinemarkError, match="'feeding' is digitised, for which all cameras count as synchronous"):
        Session.open(tmp_path).run()


def test_answers_that_no_question_was_put_for_are_refused(recorded, monkeypatch, tmp_path):
    folder = prepared(recorded, monkeypatch)
    kept = tmp_path / "cam3.csv"
    answered(folder, 2, kept)
    with kept.open("a") as file:
        file.write("5,,frame 2\n")
    with pytest.raises(KinemarkError, match="1 answers to questions that were not put"):
        digitise_camera(
            DigitisedFrames(open_images(folder / "cam3.mkv")), method=SemiAutomatic(MARKERS, "REF"), answers=kept
        )


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
    with pytest.raises(KinemarkError, match="There is no trial drinking; the session has feeding"):
        app(["digitise", str(tmp_path), "drinking"])
    text = (tmp_path / "session.toml").read_text("utf-8")
    without = re.sub(r"(?m)^answers.*\n|^\[reconstruct\]\n(?:[^\[].*\n)*", "", text)
    (tmp_path / "session.toml").write_text(without, "utf-8")
    with pytest.raises(KinemarkError, match=r"Trial feeding has no answers\. Write .* below \[digitise\] the names"):
        app(["digitise", str(tmp_path), "feeding"])
    (tmp_path / "session.toml").write_text(text, "utf-8")
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
    assert read_c3d(again.folder / "feeding.c3d").trajectories.names[-1] == "POST"
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
