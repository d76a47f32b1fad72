"""A session is made from recordings by the studio: what is proposed, what is said, and what is written."""

import os

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.engine.session import Session
from kinemark.engine.simulate import Scene, simulate
from kinemark.io.video import write_video
from support.studio import Studio

SMALL = Scene(seconds=0.3, size_px=(376, 292), focal_px=385.0, noise=1.0, cameras=3)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """Rendered videos without a session."""
    root = tmp_path_factory.mktemp("laboratory")
    simulate(root / "monday", scene=SMALL)
    (root / "monday" / "session.toml").rename(root / "session.was")
    return root


@pytest.fixture
def folder(recordings, tmp_path):
    """A copy of a test's own; the videos, which nobody changes, are the same files."""
    for path in recordings.rglob("*"):
        if path.is_file():
            target = tmp_path / "lab" / path.relative_to(recordings)
            target.parent.mkdir(parents=True, exist_ok=True)
            os.link(path, target)
    return tmp_path / "lab"


@pytest.fixture
def studio(folder):
    return Studio(folder)


def folders(studio):
    return studio.page.get("/api/recordings").json()["folders"]


def proposal(studio, **said):
    (only,) = [one for one in folders(studio) if one["title"] == "monday"]
    return studio.page.post(f"/api/recordings/{only['id']}/proposal", said).json()


def test_folders_of_recordings_are_listed_until_they_have_a_session(studio, folder):
    assert [one["folder"] for one in folders(studio)] == ["lab/monday"]
    (folder / "monday" / "session.toml").write_text("name = 'x'\n")
    assert folders(studio) == []


@pytest.mark.skipif(os.name == "nt", reason="Windows lets administrators alone make links")
def test_a_link_leads_to_no_folder_outside(folder, tmp_path):
    (tmp_path / "roots").mkdir()
    (tmp_path / "roots" / "out").symlink_to(folder)
    assert folders(Studio(tmp_path / "roots")) == []


def test_what_is_proposed_is_written_and_runs(studio, folder):
    found = proposal(studio)
    assert found["lacking"] == "" and found["rate"] and len(found["cameras"]) == 3
    answer = studio.page.post(f"/api/recordings/{found['id']}/session", {"name": "Monday's walk"})
    assert answer.status == 200, answer.body
    opened = Session.open(folder / "monday")
    assert opened.settings.name == "Monday's walk"
    home = studio.page.get("/api/home").json()["sessions"]
    assert [one["id"] for one in home] == [answer.json()["session"]]
    assert [one["id"] for one in home[0]["trials"]] == answer.json()["trials"]


def test_an_existing_session_is_never_overwritten(studio, folder):
    found = proposal(studio)
    (folder / "monday" / "session.toml").write_text("# mine\n")
    answer = studio.page.post(f"/api/recordings/{found['id']}/session", {})
    assert answer.status == 404 and (folder / "monday" / "session.toml").read_text() == "# mine\n"


def test_what_is_said_goes_before_what_was_guessed(studio, folder):
    rows = {one["role"]: one for one in proposal(studio)["recordings"]}
    walk = rows["trial"]
    said = {
        "rate": 123, "date": "2026-01-02", "fields": "top", "names": {walk["id"]: "walk A"},
        "answers": {question["key"]: "9.5" for question in proposal(studio)["questions"] if question["optional"]},
    }  # fmt: skip
    found = proposal(studio, **said)
    for words in ("rate_hz = 123", "date = 2026-01-02", 'interlaced = "top"', 'name = "walk A"'):
        assert words in found["text"]
    assert studio.page.post(f"/api/recordings/{found['id']}/session", said).status == 200
    settings = Session.open(folder / "monday").settings
    assert settings.trials[0].name == "walk A" and settings.rate_hz == 123


def test_a_labelled_trial_is_proposed_for_the_names_and_may_be_left_out(studio, folder):
    row = next(one for one in proposal(studio)["recordings"] if one["file"] == "earlier.c3d")
    assert row["role"] == "template" and "names of markers" in row["why"]
    assert 'template = ["earlier.c3d"]' in proposal(studio)["text"]
    assert "template =" not in proposal(studio, roles={row["id"]: "unused"})["text"]
    key = proposal(studio)["id"]
    walk = next(one for one in proposal(studio)["recordings"] if one["role"] == "trial")
    wrong = studio.page.post(f"/api/recordings/{key}/proposal", {"roles": {walk["id"]: "template"}})
    assert wrong.status == 422 and "names no markers" in wrong.json()["words"]
    studio.page.post(f"/api/recordings/{key}/session", {})
    assert Session.open(folder / "monday").settings.label.template == ("earlier.c3d",)


def test_without_a_calibration_or_a_trial_nothing_is_written(studio, folder):
    found = proposal(studio)
    for role, words in (("trial", "No recording is a trial"), (None, "Nothing calibrates")):
        roles = {one["id"]: "unused" for one in found["recordings"] if (one["role"] == role) == (role is not None)}
        said = proposal(studio, roles=roles)
        assert words in said["lacking"]
        answer = studio.page.post(f"/api/recordings/{found['id']}/session", {"roles": roles})
        assert answer.status == 422 and words in answer.json()["words"]
    assert not (folder / "monday" / "session.toml").exists()


@pytest.mark.parametrize(
    "said",
    [
        {"roles": {"0" * 16: "trial"}}, {"names": {"../x": "y"}}, {"rate": 0}, {"rate": "NaN"}, {"date": "2026-99-99"},
        {"roles": {"0" * 16: "king"}}, {"path": "/etc"}, {"name": "x" * 101},
    ],
    ids=str,
)  # fmt: skip
def test_what_cannot_be_is_refused_in_words(studio, said):
    key = folders(studio)[0]["id"]
    for what in ("proposal", "session"):
        answer = studio.page.post(f"/api/recordings/{key}/{what}", said)
        assert answer.status == 422 and answer.json()["words"]


def test_names_that_no_folder_can_have_are_not_written(studio, folder):
    walk = next(one for one in proposal(studio)["recordings"] if one["role"] == "trial")
    found = proposal(studio, names={walk["id"]: "../../etc"})
    assert "name" in found["lacking"] and str(folder) not in found["lacking"]


def test_without_a_word_for_a_calibration_all_folders_are_listed(recordings, tmp_path):
    """Nothing says which of them is the session's; images of a camera are no folder of their own."""
    for day in ("monday", "tuesday"):
        for camera in ("cam1", "cam2"):
            (tmp_path / "lab" / day / camera).mkdir(parents=True)
            os.link(recordings / "monday" / "calib" / "cam1.png", tmp_path / "lab" / day / camera / "0001.png")
    assert [one["folder"] for one in folders(Studio(tmp_path / "lab"))] == ["lab", "lab/monday", "lab/tuesday"]


def test_answers_are_asked_for_and_said_to_be_wrong(tmp_path):
    rng = np.random.default_rng(1)
    for name in ("walk", "calibration"):
        for camera in ("cam1", "cam2"):
            (tmp_path / "lab" / name).mkdir(parents=True, exist_ok=True)
            clip = rng.integers(0, 90, (31, 48, 64)).astype(np.uint8)
            write_video(tmp_path / "lab" / name / f"{camera}.mkv", clip, rate=50)
    studio = Studio(tmp_path / "lab")
    key = folders(studio)[0]["id"]

    def found(**answers):
        return studio.page.post(f"/api/recordings/{key}/proposal", {"answers": answers}).json()

    assert found()["questions"][0]["key"] == "calibration.way" and found()["lacking"]
    assert "calibration.wand.lengths_mm" in [one["key"] for one in found(**{"calibration.way": "wand"})["questions"]]
    wrong = found(**{"calibration.way": "wand", "calibration.wand.lengths_mm": "many"})
    assert [one["wrong"] for one in wrong["questions"] if one["wrong"]] and wrong["lacking"]
    right = found(**{"calibration.way": "wand", "calibration.wand.lengths_mm": "500"})
    assert right["lacking"] == "" and "lengths_mm = [500]" in right["text"]
