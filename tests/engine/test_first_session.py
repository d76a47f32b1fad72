"""`kinemark init`: a folder's recordings propose its first session.toml."""

import io
import shlex
import shutil
import subprocess
import sys

import numpy as np
import pytest

from kinemark.apps.commands.new_session import init
from kinemark.data import KinemarkError
from kinemark.detect.interlacing import Interlacing
from kinemark.engine.first_session import (
    Role,
    answered,
    propose,
    propose_session,
    session_text,
    with_role,
    write_first_session,
)
from kinemark.engine.session import Session
from kinemark.engine.simulate import Scene, simulate
from kinemark.io.detections_csv import write_detections_csv
from kinemark.io.images import write_png
from kinemark.io.rig_toml import write_rig_toml
from kinemark.io.um2as import write_msr
from kinemark.io.video import write_video
from support.laboratory import observe, ring
from support.motions import swarm
from support.shared import shared_data

SMALL = {"seconds": 0.4, "size_px": (376, 292), "focal_px": 385.0, "noise": 1.0, "cameras": 3}


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """A session of the virtual laboratory."""
    folder = tmp_path_factory.mktemp("simulated") / "session"
    simulate(folder, scene=Scene(**SMALL))
    return folder


@pytest.fixture
def waved(tmp_path):
    """The recordings of two cameras that a wand and an L-frame calibrate."""
    for c in (1, 2):
        for k, name in enumerate(("walk", "wand", "lframe")):
            clip(tmp_path / name / f"cam{c}.mkv", 31 + k, seed=c)
    return tmp_path


def test_a_simulated_session_without_its_file_runs_again(simulated, tmp_path):
    folder = tmp_path / "bare"
    shutil.copytree(simulated, folder)
    (folder / "session.toml").unlink()
    write_first_session(propose_session(folder))
    proposed, given = Session.open(folder), Session.open(simulated)
    for part in ("rate_hz", "calibration", "label", "trials", "cameras"):
        assert getattr(proposed.settings, part) == getattr(given.settings, part)
    assert len(proposed.run(to="track")["walk01"].tracks) >= 15


def test_what_no_file_tells_is_asked_and_then_known(waved):
    asked = propose_session(waved)
    assert [one.key for one in asked.open] == ["calibration.wand.lengths_mm", "calibration.l_frame.arms_mm"]
    half = answered(asked, "calibration.wand.lengths_mm", "500")
    assert "# ? l_frame" in session_text(half)
    assert "# ? wand" not in session_text(half)
    whole = answered(half, "calibration.l_frame.arms_mm", "800, 600")
    assert asked.rate is not None  # the clips say it, and may be played slower than they were recorded
    write_first_session(answered(answered(whole, "calibration.l_frame.height_mm", "12.5"), "rate_hz", "100"))
    settings = Session.open(waved).settings
    way = settings.calibration
    assert settings.rate_hz == 100
    assert way.wand.lengths_mm == (500,)
    assert way.l_frame.arms_mm == (800, 600) and way.l_frame.height_mm == 12.5


def test_without_answers_the_file_says_what_is_wanted(waved):
    text = write_first_session(propose_session(waved)).read_text("utf-8")
    assert '# ? wand = { images = "wand/{camera}.mkv", lengths_mm = [?] }' in text
    with pytest.raises(KinemarkError, match=r"begin with # \? want a value, .*: wand, l_frame\."):
        Session.open(waved)
    completed = text.replace("# ? wand", "wand").replace("lengths_mm = [?]", "lengths_mm = [500]")
    (waved / "session.toml").write_text(completed, "utf-8")
    assert Session.open(waved).settings.calibration.way == "wand"


def test_trials_that_nothing_names_are_named_by_the_first_that_somebody_names(waved):
    write_first_session(propose_session(waved))
    assert "[label] # name the markers of one trial" in (waved / "session.toml").read_text("utf-8")


def test_commands_in_messages_can_be_typed_as_they_stand(waved, capsys):
    """A folder of the day is often called by date and person, with spaces."""
    folder = waved.rename(waved.parent / "Labor Müller 7")
    init(folder, yes=True)
    said = capsys.readouterr().out.rpartition("kinemark calibrate ")[2]
    assert shlex.split(said) == [str(folder)]
    with pytest.raises(KinemarkError) as error:
        init(folder, yes=True)
    assert shlex.split(str(error.value).rpartition("kinemark calibrate ")[2]) == [str(folder)]


def test_an_existing_session_is_never_overwritten(waved):
    command = [sys.executable, "-m", "kinemark", "init", waved, "--answer", "calibration.wand.lengths_mm=120 280"]
    first, again = (subprocess.run(command, capture_output=True, text=True, check=False) for _ in range(2))
    assert not first.returncode, first.stderr
    assert "arms_mm" in first.stdout
    assert again.returncode == 1
    assert "not overwritten" in again.stderr
    assert Session.open(waved).settings.calibration.wand.lengths_mm == (120, 280)
    with pytest.raises(KinemarkError, match="not overwritten"):
        write_first_session(propose_session(waved))


def clip(path, n_frames, *, seed=0, rate=50.0, woven="", dark=False):
    """A small video of a bright disc that moves, or a dark one; as two fields where `woven` says which comes first."""
    path.parent.mkdir(parents=True, exist_ok=True)
    row, column = np.mgrid[:48, :64]
    rng = np.random.default_rng(seed)
    x0, v = rng.uniform(12, 20), rng.uniform(1.2, 1.8)

    def at(t):
        away = (row - 24) ** 2 + (column - 12 - (x0 + v * t) % 40) ** 2
        disc = 200 / (1 + np.exp(np.minimum(away / 9 - 3, 50)))
        image = (disc + rng.normal(20, 1.5, disc.shape)).clip(0, 255).astype(np.uint8)
        return np.uint8(235) - np.minimum(image, 235) if dark else image

    def frame(k):
        if not woven:
            return at(k)
        first, second = at(2 * k), at(2 * k + 1)
        top, bottom = (first, second) if woven == "top" else (second, first)
        image = top.copy()
        image[1::2] = bottom[1::2]
        return image

    write_video(path, (frame(k) for k in range(n_frames)), rate)


NAMINGS = {
    "walk01_cam1": ("{trial}_cam{c}.mkv", ("cam1", "cam2", "cam3")),
    "folders of cameras": ("cam{c}/{trial}.mkv", ("cam1", "cam2", "cam3")),
    "letters": ("{trial}/Camera_{L}.mkv", ("Camera_A", "Camera_B", "Camera_C")),
    "zeros": ("{trial}-cam0{c}.mkv", ("cam01", "cam02", "cam03")),
    "sides": ("{trial}_{side}.mkv", ("front", "left", "right")),
    "date stamps": ("2026-05-03_{trial}_c{c}.mkv", ("c1", "c2", "c3")),
    "numbers alone": ("{trial}/{c}.mkv", ("1", "2", "3")),
    "camera said twice": ("cam{c}/{trial}_cam{c}.mkv", ("cam1", "cam2", "cam3")),
    "serial numbers": ("{trial}_2199032{c}.mkv", ("21990321", "21990322", "21990323")),
    "letters alone": ("{L}/{trial}.mkv", ("A", "B", "C")),
    "names of one's own, first": ("{own}_{trial}.mkv", ("Fenster", "Tor", "Wand")),
}


@pytest.mark.parametrize("naming", NAMINGS)
def test_cameras_and_trials_follow_from_names(naming, tmp_path):
    form, cameras = NAMINGS[naming]
    for k, trial in enumerate(("walk01", "walk02", "wand")):
        for c in (1, 2, 3):
            said = form.format(trial=trial, c=c, L="ABC"[c - 1], side=("left", "right", "front")[c - 1],
                               own=("Tor", "Fenster", "Wand")[c - 1])  # fmt: skip
            clip(tmp_path / said, 35 + 3 * k, seed=c)
    found = propose_session(tmp_path)
    assert found.cameras == cameras
    assert found.rate == pytest.approx(50)
    assert [len(one.cameras) for one in found.trials] == [3, 3]
    assert all("walk0" in one.name for one in found.trials)
    assert found.way is not None
    assert found.way.role is Role.WAND
    write_first_session(answered(found, "calibration.wand.lengths_mm", "120 280"))
    session = Session.open(tmp_path)
    for one in found.trials:
        for name in session.settings.cameras.names:
            assert (tmp_path / one.path.replace("{camera}", name)).is_file()
    assert (str(session.settings.date) == "2026-05-03") == (naming == "date stamps")


def test_folders_that_say_what_was_recorded_are_no_cameras(tmp_path):
    """Cameras are bare numbers, and wand and walk are equally long: only the word says which of both is which."""
    for name, c in ((name, c) for name in ("wand", "dyn1") for c in (1, 2, 3)):
        clip(tmp_path / name / f"{c}.mkv", 20, seed=c)
    found = propose_session(tmp_path)
    assert (found.cameras, [one.path for one in found.trials]) == (("1", "2", "3"), ["dyn1/{camera}.mkv"])


def test_images_that_cannot_be_opened_are_named(tmp_path):
    for c in (1, 2):
        clip(tmp_path / f"walk_cam{c}.mkv", 20, seed=c)
    (tmp_path / "walk_cam3.mkv").write_bytes(b"")
    assert "# walk_cam3.mkv cannot be opened: copy it again" in session_text(propose_session(tmp_path))


@pytest.mark.parametrize("first", ["top", "bottom", ""])
def test_fields_are_seen_in_what_moves(first, tmp_path):
    for c in (1, 2):
        clip(tmp_path / f"cam{c}.mkv", 20, seed=c, rate=25.0, woven=first)
    found = propose_session(tmp_path)
    assert found.interlaced == (first or False)
    assert found.rate == pytest.approx(50 if first else 25)
    assert found.interlaced_why.kind == ("fields" if first else "whole_frames")


@pytest.mark.parametrize("votes, first", [(("bottom", None, None), False), (("top", "top", None), "top")])
def test_one_camera_alone_does_not_make_fields(votes, first, tmp_path, monkeypatch):
    """Big soft spots that hardly move at 500 Hz look nearly as woven ones to single cameras."""
    for c in (1, 2, 3):
        clip(tmp_path / f"cam{c}.mkv", 20, seed=c)
    said = iter(votes)
    monkeypatch.setattr(propose, "interlacing", lambda frames: Interlacing(next(said), 0.41, 5000))
    assert propose_session(tmp_path).interlaced == first


@pytest.mark.parametrize("dark", [True, False])
def test_dark_markers_are_seen(dark, tmp_path):
    for c in (1, 2):
        clip(tmp_path / f"walk_cam{c}.mkv", 20, seed=c, dark=dark)
        clip(tmp_path / f"wand_cam{c}.mkv", 25, seed=c, dark=dark)
    write_first_session(answered(propose_session(tmp_path), "calibration.wand.lengths_mm", "120 280"))
    assert Session.open(tmp_path).settings.detect.inverted == dark


def test_image_sequences_and_pictures_are_told_apart(tmp_path):
    image = np.zeros((16, 16), np.uint8)
    for c in (1, 2):
        for k in range(4):
            for name in (f"walk/cam{c}/{k:06d}.png", f"static_cam{c}_{k + 1}.png"):
                (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
                write_png(tmp_path / name, image)
        (tmp_path / "floor").mkdir(exist_ok=True)
        write_png(tmp_path / f"floor/cam{c}.png", image)
    paths = {one.path: one for one in propose_session(tmp_path).recordings}
    assert set(paths) == {"walk/{camera}/%06d.png", "static_{camera}_%d.png", "floor/{camera}.png"}
    assert paths["walk/{camera}/%06d.png"].role is Role.TRIAL
    assert paths["static_{camera}_%d.png"].role is Role.STATIC
    assert paths["floor/{camera}.png"].role is Role.L_FRAME


@pytest.mark.parametrize(
    ("form", "names"),
    [
        ("{trial}/cam{c}/img_{k}.png", {"walk01", "walk02"}),
        ("{trial}/cam{c}/Frame{k:04d}.png", {"walk01", "walk02"}),
        ("images/cam{c}/{trial}_{k:04d}.png", {"walk01", "walk02"}),
        ("cam{c}/img_{k}.png", {"img"}),
    ],
)
def test_a_trial_is_not_called_as_any_image_is(form, names, tmp_path):
    for trial in sorted(names):
        for c, k in ((c, k) for c in (1, 2) for k in range(4)):
            path = tmp_path / form.format(trial=trial, c=c, k=k)
            path.parent.mkdir(parents=True, exist_ok=True)
            write_png(path, np.zeros((16, 16), np.uint8))
    assert {one.name for one in propose_session(tmp_path).trials} == names


def test_files_of_points_make_a_session(tmp_path):
    rig = ring(3)
    for name in ("walk", "wand"):
        write_detections_csv(tmp_path / f"{name}.csv", observe(rig, swarm(5, frames=40, seed=2))[0])
    found = propose_session(tmp_path)
    assert found.cameras == rig.names
    assert {one.key for one in found.open} == {"rate_hz", "calibration.wand.lengths_mm", "cameras.size_px"}
    for key, text in (("rate_hz", "100"), ("calibration.wand.lengths_mm", "400"), ("cameras.size_px", "1280 1024")):
        found = answered(found, key, text)
    write_first_session(found)
    assert Session.open(tmp_path).settings.cameras.size_px == (1280, 1024)


def test_a_person_may_say_what_a_recording_is(tmp_path):
    for c in (1, 2):
        for name in ("dance", "calibration"):
            clip(tmp_path / f"{name}_cam{c}.mkv", 40, seed=c)
    found = propose_session(tmp_path)
    assert [one.key for one in found.open] == ["calibration.way"]
    assert answered(found, "calibration.way", "wand").way.path == "calibration_{camera}.mkv"
    stated = with_role(found, "dance_{camera}.mkv", Role.WAND)
    assert stated.way.path == "dance_{camera}.mkv"
    with pytest.raises(ValueError, match="none of wand"):
        answered(found, "calibration.way", "tripod")


def test_a_folder_without_recordings_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("nothing")
    with pytest.raises(KinemarkError, match="no recordings"):
        propose_session(tmp_path)
    clip(tmp_path / "holiday.mkv", 5)
    with pytest.raises(KinemarkError, match="which camera took which"):
        propose_session(tmp_path)


def test_a_bts_file_is_trial_and_calibration(tmp_path):
    shutil.copy(shared_data("cameras/gait9_bts/gait9.tdf"), tmp_path / "gait9.tdf")
    write_first_session(propose_session(tmp_path))
    settings = Session.open(tmp_path).settings
    assert settings.calibration.way == "file"
    assert len(settings.cameras.names) == 7
    assert settings.rate_hz == 250


def test_at_a_terminal_roles_are_confirmed_and_questions_asked(waved, monkeypatch, capsys):
    """What is typed goes into the file; what is no answer is asked again."""

    typed = io.StringIO("9 wand\n2 king\n2 static\n\nmany\n500\n\n")
    typed.isatty = lambda: True
    monkeypatch.setattr("sys.stdin", typed)
    found = [one.path for one in propose_session(waved).recordings]
    init(waved)
    said = capsys.readouterr().out
    assert "from 1 to 3" in said and "'king' is no role" in said and "is not made of numbers" in said
    text = (waved / "session.toml").read_text("utf-8")
    assert "static" in text and "lengths_mm = [500]" in text and "# ? l_frame" in text, found


@pytest.mark.parametrize(("stills", "role"), [("box", Role.CONTROL_POINTS), ("feeding", Role.TRIAL)])
def test_stills_that_are_called_as_measured_places_show_them(tmp_path, stills, role):
    """`box.msr` beside `box_cam1.png`; others are a trial, as before."""
    write_msr(tmp_path / "box.msr", np.arange(24.0).reshape(8, 3))
    for name in ("cam1", "cam2"):
        write_png(tmp_path / f"{stills}_{name}.png", np.zeros((6, 8), np.uint8))
        write_video(tmp_path / f"walk_{name}.mkv", np.zeros((4, 6, 8), np.uint8), 50.0)
    proposal = propose_session(tmp_path)
    assert next(one.role for one in proposal.recordings if one.path.startswith(stills + "_")) is role
    assert ('images = "box_' in session_text(proposal).split("[[trials]]")[0]) == (role is Role.CONTROL_POINTS)
    assert [one.name for one in proposal.trials][-1] == "walk"


def test_a_calibration_of_another_program_asks_its_unit(tmp_path):
    """Their TOML files do not say it; one that cannot be used is told, with the reason."""
    rig = ring(3)
    write_detections_csv(tmp_path / "walk.csv", observe(rig, swarm(5, frames=40, seed=2))[0])
    file = tmp_path / "calibration.toml"
    write_rig_toml(file, rig)
    ours = propose_session(tmp_path)
    assert (ours.way.path, [one.key for one in ours.questions]) == ("calibration.toml", ["rate_hz"])
    theirs = file.read_text().replace('units = "mm"\n', "")
    file.write_text(theirs)
    found = propose_session(tmp_path)
    assert found.way.path == "calibration.toml" and "# ? length_unit" in session_text(found)
    for key, said in (("rate_hz", "100"), ("calibration.length_unit", "mm")):
        found = answered(found, key, said)
    write_first_session(found)
    assert len(Session.open(tmp_path).run(to="track")["walk"].tracks) == 5
    file.write_text(theirs.replace("fisheye = false", "fisheye = true"))
    refused = propose_session(tmp_path)
    assert refused.way is None and "fisheye lenses are not supported" in session_text(refused)


def test_the_calibration_of_the_trials_own_day_is_taken(tmp_path):
    """Of several files that calibrate; where only another day's is there, that is told."""
    rig = ring(3)
    write_detections_csv(tmp_path / "2018-08-17_walk.csv", observe(rig, swarm(5, frames=40, seed=2))[0])
    write_rig_toml(tmp_path / "2018-07-28_rig.toml", rig)
    other = propose_session(tmp_path)
    assert other.way.path == "2018-07-28_rig.toml"
    assert "another day, 2018-07-28: check that no camera was moved" in session_text(other)
    write_rig_toml(tmp_path / "2018-08-17_rig.toml", rig)
    found = propose_session(tmp_path)
    text = session_text(found)
    assert found.way.path == "2018-08-17_rig.toml" and "another day" not in text
    assert "2018-07-28_rig.toml could calibrate as well" in text and "not used" not in text


@pytest.mark.parametrize(
    ("files", "told"), [(("a.png",), "has 1 recording, and"), (("a.png", "b.mkv"), "has 2 recordings")]
)
def test_recordings_of_no_camera_are_counted_in_words(tmp_path, files, told):
    """It had "1 recordings"."""
    for name in files:
        (clip if name.endswith("mkv") else lambda path, *_, **__: write_png(path, np.zeros((8, 8), np.uint8)))(
            tmp_path / name, 5, seed=1
        )
    with pytest.raises(KinemarkError, match=told):
        propose_session(tmp_path)
