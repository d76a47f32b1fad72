"""An operator digitises in the studio: what is asked, what is kept, and that it is what the terminal gives."""

import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

import numpy as np

from kinemark.data.answers import Point, Revisit, Undo, answer_text
from kinemark.digitise import DigitisingPhase
from kinemark.engine.digitising.files import digitise_trial
from kinemark.engine.session import Session
from kinemark.io.answers_csv import read_answers
from kinemark.io.um2as import read_da, write_rf
from support.eating import Knowing, footage
from support.feeding import NAMES, feeding_in, not_set_up
from support.studio import Studio

FRAMES = 5
KINDS = {"-": "absent", "y": "yes", "n": "no"}


def operators(wrong=()):
    """One a camera who knows the markers; `wrong`: the numbers of questions at which they err first."""
    _, _, sight, _ = footage(FRAMES / 30)
    cameras = iter(range(3))

    def of_reel(reel):
        knowing, asked, taken_back = Knowing(sight, next(cameras), reel), [0], []

        def operator(question, state):
            if taken_back:
                return taken_back.pop()
            asked[0] += 1
            answer = knowing(question, state)
            if asked[0] in wrong and isinstance(answer, Point) and question.phase is DigitisingPhase.POINT:
                taken_back.append(Undo())
                u, v = next(uv for uv in reel(question.frame).uv if np.hypot(*(uv - [answer.u, answer.v])) > 20)
                return Point(round(float(u)), round(float(v)))
            return answer

        return operator

    return of_reel


@pytest.fixture(scope="module")
def typed(tmp_path_factory):
    """A session that was digitised at a terminal, with wrong clicks taken back, and run."""
    folder = feeding_in(tmp_path_factory.mktemp("typed"), FRAMES, confirm=True)
    session = Session.open(folder)
    digitise_trial(session.digitising("feeding", session.calibrate().rig), operator=operators(wrong=(3, 9)))
    session.run(to="detect")
    return folder


def given(folder):
    """The answers of each camera in the order of its cameras, as the page says them."""
    for c in range(3):
        for _, _, answer in read_answers(folder / "answers" / f"cam{c + 1}.csv"):
            text = answer_text(answer)
            if isinstance(answer, Point):
                yield {"kind": "point", "u": answer.u, "v": answer.v}
            elif isinstance(answer, Revisit):
                yield {"kind": "frame", "frame": answer.frame + 1}
            else:
                yield {"kind": KINDS.get(text, text)}


def said(studio, answer, now):
    body = {"camera": now["camera"], "kept": now["kept"], "said": answer}
    return studio.page.post(f"{studio.address}/answers", body)


def now_of(studio):
    return studio.page.get(studio.address).json()


def all_said(studio, answers, *, again=()):
    """Say them; where `again` counts, the studio is started anew in the midst."""
    now = now_of(studio)
    for k, answer in enumerate(answers):
        if k in again:
            studio = opened(studio.folder)
            assert now_of(studio) == now, "it goes on where it was"
        found = said(studio, answer, now)
        assert found.status == 200, found.json()
        now = found.json()
    return now


def opened(folder):
    studio = Studio(folder)
    studio.folder, studio.address = folder, f"{studio.trial}/digitise"
    return studio


def test_the_same_answers_give_the_same_files_to_the_last_bit(typed, tmp_path):
    folder = feeding_in(tmp_path / "clicked", FRAMES, confirm=True)
    now = all_said(opened(folder), [*given(typed)], again=(7, 40))
    assert now["finished"] and [camera["saved"] for camera in now["cameras"]] == [FRAMES] * 3
    Session.open(folder).run(to="detect")
    for name in [f"answers/cam{c}.csv" for c in (1, 2, 3)] + [f"results/feeding/feeding.da{c}" for c in (1, 2, 3)]:
        assert (folder / name).read_bytes() == (typed / name).read_bytes(), name


def test_the_first_two_frames_are_asked_for_and_then_the_reference_marker(typed, tmp_path):
    studio = opened(feeding_in(tmp_path, FRAMES, confirm=True))
    now = now_of(studio)
    assert (now["question"]["words"], now["question"]["frame"], now["camera"]) == ("Where is ACR1?", 1, "cam1")
    assert now["markers"] == list(NAMES) and not now["can_undo"]
    asked = []
    for answer in given(typed):
        last, now = now, said(studio, answer, now).json()
        if last["question"]["phase"] == now["question"]["phase"] == "point" and now["question"]["frame"] == 1:
            first = now["question"]["spots"][0]  # which a key takes: it was ACR1's for all of them
            assert all(np.hypot(first[0] - m["u"], first[1] - m["v"]) > 1 for m in now["draft"] if m["u"] is not None)
        asked.append((now["question"]["phase"], now["question"]["frame"]))
        if now["question"]["phase"] == "reference":
            break
    assert asked[-1] == ("reference", 3)
    assert now["question"]["words"] == "Is this the reference marker, REF?" and now["question"]["at"]
    now = said(studio, {"kind": "no"}, now).json()
    assert (now["question"]["phase"], now["question"]["marker"]) == ("point", "REF")
    u, v = footage(FRAMES / 30)[2].uv[0, 7, 2]
    now = said(studio, {"kind": "point", "u": round(u), "v": round(v)}, now).json()
    assert (now["question"]["phase"], now["question"]["marker"]) == ("reference", "REF"), "it is asked again"
    now = said(studio, {"kind": "yes"}, now).json()
    assert now["question"]["words"].startswith("Have successfully detected all markers")
    assert {marker["how"] for marker in now["draft"]} == {"automatic", "pointed"}
    now = said(studio, {"kind": "verify"}, now).json()
    assert now["question"]["words"] == "Is this ACR1?"
    corrected = said(studio, {"kind": "no"}, now).json()
    assert corrected["question"]["words"] == "Click where the centre of ACR1 is."
    moved = said(studio, {"kind": "point", "u": 100.5, "v": 90.25}, corrected).json()
    assert studio.page.get(f"{studio.address}/frames/3").status == 422, "it is not saved yet"
    saved = studio.page.get(f"{studio.address}/frames/2").json()
    assert {marker["how"] for marker in saved} == {"pointed"} and saved[0]["name"] == "ACR1"
    assert moved["draft"][0] == {"name": "ACR1", "u": 100.5, "v": 90.25, "how": "placed"}


def test_what_cannot_be_is_refused_and_nothing_is_kept(tmp_path):
    folder = feeding_in(tmp_path, FRAMES)
    studio = opened(folder)
    now = now_of(studio)
    for answer, words in (
        ({"kind": "point", "u": 3, "v": 3}, "no white pixel"),
        ({"kind": "point", "u": 9999, "v": 3}, "outside the image"),
        ({"kind": "yes"}, "Nothing is proposed"),
        ({"kind": "save"}, "no answer to a question of the kind 'point'"),
        ({"kind": "undo"}, "no answer to take back"),
        ({"kind": "frame", "frame": 4}, "has not been saved yet"),
        ({"kind": "frame", "frame": -7}, "There is no frame"),
    ):
        refused = said(studio, answer, now)
        assert refused.status == 422
        assert words in refused.json()["words"]
        assert now_of(studio) == now
    assert not (folder / "answers").exists()
    assert said(studio, {"kind": "absent"}, now).status == 200
    assert said(studio, {"kind": "absent"}, now).status == 409, "another window has answered meanwhile"
    assert len(read_answers(folder / "answers" / "cam1.csv")) == 1


def test_what_is_typed_meanwhile_is_seen(tmp_path):
    folder = feeding_in(tmp_path, FRAMES)
    studio = opened(folder)
    now = said(studio, {"kind": "absent"}, now_of(studio)).json()
    with (folder / "answers" / "cam1.csv").open("a", encoding="utf-8") as file:
        file.write("1,ACR2,-\n")
    after = now_of(studio)
    assert (after["kept"], after["question"]["marker"]) == (2, "ARM3")
    assert said(studio, {"kind": "absent"}, now).status == 409


def test_a_camera_is_gone_back_to_until_the_next_is_begun(typed, tmp_path):
    folder, all_of = feeding_in(tmp_path, FRAMES, confirm=True), [*given(typed)]
    first = len(read_answers(typed / "answers" / "cam1.csv"))
    studio = opened(folder)
    now = all_said(studio, all_of[:first])
    assert now["camera"] == "cam2" and now["can_undo"] and now["kept"] == 0
    now = said(studio, {"kind": "undo"}, now).json()
    assert (now["camera"], now["question"]["phase"], now["question"]["frame"]) == ("cam1", "review", FRAMES)
    now = said(studio, {"kind": "frame", "frame": 2}, now).json()
    assert (now["question"]["phase"], now["question"]["frame"]) == ("review", 2)
    now = said(studio, {"kind": "save"}, now).json()
    assert (now["camera"], now["question"]["frame"]) == ("cam1", FRAMES)
    for _ in range(40):
        if now["camera"] == "cam2":
            break
        kind = {"reference": "yes", "point": "absent"}.get(now["question"]["phase"], "save")
        now = said(studio, {"kind": kind}, now).json()
    assert now["camera"] == "cam2"
    assert now_of(opened(folder)) == now, "what was taken back and said again leads there once more"
    now = all_said(studio, all_of[first : first + 1])
    assert said(studio, {"kind": "undo"}, now).json()["camera"] == "cam2"


def test_the_other_cameras_propose_and_draw_their_lines(typed, tmp_path):
    studio, all_of = opened(feeding_in(tmp_path, FRAMES, confirm=True)), [*given(typed)]
    first = [len(read_answers(typed / "answers" / f"cam{c}.csv")) for c in (1, 2)]
    now = all_said(studio, all_of[: first[0]])
    lines = now["question"]["lines"]
    assert [line["camera"] for line in lines] == ["cam1"]
    truth, line = footage(FRAMES / 30)[2].uv[1, 0, 0], np.array(lines[0]["points"])
    a, b = line[:-1], line[1:]
    along = (((truth - a) * (b - a)).sum(1) / ((b - a) ** 2).sum(1)).clip(0, 1)
    assert np.hypot(*(a + along[:, None] * (b - a) - truth).T).min() < 1.0
    now = all_said(studio, all_of[first[0] : sum(first)])
    question = now["question"]
    assert len(question["lines"]) == 2 and question["said"]["seen"]
    assert question["spots"][0] == question["said"]["at"] and len(question["spots"]) >= 8
    assert np.hypot(*(np.array(question["said"]["at"]) - footage(FRAMES / 30)[2].uv[2, 0, 0])) < 1.0
    now = said(studio, {"kind": "yes"}, now).json()
    assert now["draft"][0]["how"] == "proposed"


def test_a_trial_that_nobody_digitises_is_set_up(tmp_path):
    folder = not_set_up(feeding_in(tmp_path, FRAMES))
    file, studio = folder / "session.toml", opened(folder)
    refused = studio.page.get(studio.address)
    assert refused.status == 422 and "Nobody digitises feeding by hand" in refused.json()["words"]
    before = file.read_bytes()
    for body, words in (
        ({"markers": []}, "Name 1 to 30"),
        ({"markers": ["A", "A"]}, "each name once"),
        ({"markers": ["A"], "reference": "B"}, "reference is 'B'"),
        ({"markers": ["A"] * 31}, "at most 30"),
        ({"markers": ["A"], "history": 1}, "history is 1"),
    ):
        answer = studio.page.post(f"{studio.address}/setup", body)
        assert answer.status == 422 and words in answer.json()["words"], answer.json()
        assert file.read_bytes() == before
    now = studio.page.post(f"{studio.address}/setup", {"markers": ["A", "REF"], "reference": "REF"}).json()
    assert (now["markers"], now["reference"]) == (["A", "REF"], "REF")
    assert "# the arm study, recorded in the basement" in file.read_text("utf-8")
    now = studio.page.post(f"{studio.address}/setup", {"markers": ["B", "REF"], "reference": "REF"}).json()
    assert now["question"]["words"] == "Where is B?"
    assert studio.page.request("DELETE", f"{studio.address}/setup").status == 204
    assert now_of(studio)["words"].startswith("Nobody") and "\nanswers" not in file.read_text("utf-8")
    now = studio.page.post(f"{studio.address}/setup", {"markers": ["1", "REF"], "reference": "REF"}).json()
    assert now["question"]["words"] == "Where is marker 1?"
    assert said(studio, {"kind": "absent"}, now).status == 200
    assert (folder / "answers" / "feeding" / "cam1.csv").is_file()
    answer = studio.page.post(f"{studio.address}/setup", {"markers": ["C"]})
    assert answer.status == 422 and "cam1.csv has 1 answers" in answer.json()["words"]
    assert studio.page.request("DELETE", f"{studio.address}/setup").status == 422


def test_the_last_frame_and_the_files_of_the_thesis(tmp_path):
    """UM²AS's start-up: where the reference marker was is read of its files, and frames after the last are left out."""
    folder = not_set_up(feeding_in(tmp_path, FRAMES))
    text = (folder / "session.toml").read_text("utf-8")
    (folder / "session.toml").write_text(text.partition("[calibration.reference_marker]")[0] + "[[trials]]" +
                                         text.partition("[[trials]]")[2], "utf-8")  # fmt: skip
    places = footage(FRAMES / 30)[2].uv[:, 7, 0]
    for c, place in enumerate(places):
        write_rf(folder / f"box.rf{c + 1}", place)
    write_rf(folder / "half.rf1", places[0])
    studio = opened(folder)
    start = studio.page.get(f"{studio.address}/setup").json()
    assert (start["frames"], start["reference_files"]) == (FRAMES, ["box"])
    wanted = {"markers": list(NAMES), "reference": "REF", "confirm_reference": False, "last_frame": 3}
    wanted["recorded"] = "1992-11-27"
    refused = studio.page.post(f"{studio.address}/setup", wanted | {"reference_files": "../box"})
    assert refused.status == 422 and "there are box" in refused.json()["words"]
    now = studio.page.post(f"{studio.address}/setup", wanted | {"reference_files": "box"}).json()
    assert now["frames"] == 3
    task = Session.open(folder).digitising("feeding", Session.open(folder).calibrate().rig)
    np.testing.assert_allclose(task.constants, places, atol=1e-6)
    again = studio.page.get(f"{studio.address}/setup").json()["now"]
    assert again == wanted | {"take_proposals": False, "history": 2, "every": 1, "reference_files": None}
    digitise_trial(task, operator=operators())
    done = Session.open(folder).run()["feeding"]
    assert str(Session.open(folder).trial("feeding").entry.date) == "1992-11-27"
    assert done.trajectories.n_frames == 3 and done.trajectories.names == NAMES
    assert read_da(folder / "results" / "feeding" / "feeding.da1").shape == (8, 3, 2)
    assert now_of(studio)["finished"]


def test_the_picture_is_the_frame(typed):
    from kinemark.io.images import read_image

    studio = Studio(typed)
    for frame in (4, 1, 5):
        body = studio.page.get(f"{studio.trial}/pictures/cam2/{frame}").body
        (typed / "shown.png").write_bytes(body)
        np.testing.assert_array_equal(read_image(typed / "shown.png"), footage(FRAMES / 30)[3][1][frame - 1])
    for path in ("pictures/cam2/0", "pictures/cam2/99", "pictures/cam9/1"):
        assert studio.page.get(f"{studio.trial}/{path}").status == 422
