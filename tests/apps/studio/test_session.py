"""A session in the studio: run, seen with its cameras, told of; images where there are some."""

import asyncio
import json
import shutil
import time
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.apps.studio import live, messages
from kinemark.engine.session import Session
from support.sessions import folder_of
from support.studio import Studio, file_in


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return folder_of(tmp_path_factory.mktemp("session"), 4)[0]


@pytest.fixture(scope="module")
def studio(folder):
    """It was run by a job of the studio's own."""
    studio = Studio(folder)
    card = studio.page.get("/api/home").json()["sessions"][0]["trials"][0]
    assert card["state"] == "not run" and studio.page.get(studio.trial).status == 424
    job = studio.page.post(f"{studio.trial}/run", {}).json()
    again = studio.page.post(f"{studio.trial}/run", {})
    assert job["state"] == "running" and again.status == 422
    assert again.json()["words"] == "one of this session is running already. Wait for it, or cancel it."
    began = time.monotonic()
    while (job := studio.page.get("/api/jobs").json()[-1])["state"] == "running":
        assert time.monotonic() - began < 120
        time.sleep(0.1)
    assert job["state"] == "done", job["words"]
    return studio


@pytest.fixture
def own(studio, folder, tmp_path):
    """A copy, of which something may be said."""
    return Studio(shutil.copytree(folder, tmp_path / "own"))


def test_a_run_trial_is_shown_with_its_cameras_and_detections(studio, folder):
    header = studio.page.get(studio.trial).json()
    rig = Session.open(folder).calibrate().rig
    assert [camera["name"] for camera in header["cameras"]] == list(rig.names)
    assert np.allclose(header["cameras"][2]["K"], rig[2].K) and header["has_detections"] and not header["has_images"]
    answer = studio.page.get(f"{studio.trial}/detections?first=2&last=4")
    about = json.loads(answer.headers["x-kinemark-detections"])
    n, d = 4 * 3, about["detections"]
    counts = np.frombuffer(answer.body[: n * 4], "<u4").reshape(4, 3)
    track = np.frombuffer(answer.body[n * 4 + d * 8 : n * 4 + d * 12], "<i4")
    assert counts.sum() == d and len(answer.body) == n * 4 + d * 13
    assert set(track[:5].tolist()) == set(range(5)), "every marker has an image of its own in the first frame"
    home = studio.page.get("/api/home").json()["sessions"][0]["trials"][0]
    assert (home["state"], home["frames"], home["markers"], home["named"]) == ("done", 20, 5, 0)


def test_what_is_said_makes_results_stale_and_the_file_follows_by_a_run(own, tmp_path):
    assert own.page.post(f"{own.trial}/export", {}).json()["name"] == "results/one/one.c3d"
    assert own.act(kind="claim", track="*1", name="LKNE").status == 200
    assert own.page.get(own.trial).json()["stale"]
    assert own.page.get("/api/home").json()["sessions"][0]["trials"][0]["state"] == "stale"
    assert own.page.post(f"{own.trial}/export", {}).status == 422
    assert (tmp_path / "own" / "edits" / "one.jsonl").is_file()


OWN_SET = '[markers]\nA = { meaning = "one" }\nB = { meaning = "other" }\n'


def test_a_marker_set_is_stated_in_the_sessions_file(own, tmp_path):
    """Labels said which key of session.toml it is, and which command lists the sets."""
    file = tmp_path / "own" / "session.toml"
    before = file.read_text("utf-8")
    (tmp_path / "own" / "mine.toml").write_text(OWN_SET, encoding="utf-8")
    sets = [one["name"] for one in own.page.get(f"{own.trial}/marker-sets").json()]
    assert {"kiss-15", "mine.toml"} < {*sets} and "session.toml" not in sets
    for name in ("um2as-7", "mine.toml"):
        now = own.page.post(f"{own.trial}/marker-set", {"name": name}).json()
        assert [one["name"] for one in now if one["worn"]] == [name]
        assert f'marker_set = "{name}"' in file.read_text("utf-8")
        assert len(own.page.get(own.trial).json()["marker_set"]["names"]) == {"um2as-7": 7, "mine.toml": 2}[name]
    assert own.page.post(f"{own.trial}/marker-set", {"name": None}).status == 200
    assert own.page.get(own.trial).json()["marker_set"] is None
    assert file.read_text("utf-8").split() == before.split()


def test_the_report_has_no_origin_and_all_that_it_draws_with(studio):
    answer = studio.page.get(f"{studio.trial}/report")
    assert answer.status == 200 and answer.headers["content-security-policy"].startswith("sandbox allow-scripts ")
    assert b'src="../assets' not in answer.body and len(answer.body) > 1_000_000


def test_where_there_is_no_report_it_is_said_why(studio, own, tmp_path):
    assert studio.page.get(f"{studio.trial}/standing?screen=report").json() == {
        "ready": True,
        "words": "",
        "runs": True,
    }
    (tmp_path / "own" / "results" / "one" / "report.html").unlink()
    stands = own.page.get(f"{own.trial}/standing?screen=report").json()
    assert not stands["ready"] and "run the trial" in stands["words"]
    (tmp_path / "file").mkdir()
    file_in(tmp_path / "file")
    file = Studio(tmp_path / "file")
    stands = file.page.get(f"{file.trial}/standing?screen=report").json()
    assert not stands["ready"] and "walk.c3d is a file of trajectories" in stands["words"]
    assert file.page.get("/api/trials/none/standing?screen=report").status == 404


def test_without_a_browser_a_pdf_of_the_report_is_refused_in_words(studio, monkeypatch):
    monkeypatch.setenv("KINEMARK_BROWSER", "")
    answer = studio.page.get(f"{studio.trial}/report.pdf")
    assert answer.status == 422 and "print it to a file there" in answer.json()["words"]


def test_a_trial_without_images_says_so(studio):
    assert studio.page.get(f"{studio.trial}/mosaic/1").json()["words"] == "This trial has no images."


def test_open_pages_are_told_when_somebody_says_something(own):
    address = f"{own.trial}/acts"

    async def told():
        said, gone = asyncio.Queue(), asyncio.Event()

        async def receive(first=[True]):  # noqa: B006  one socket
            if first.pop() if first else False:
                return {"type": "websocket.connect"}
            await gone.wait()
            return {"type": "websocket.disconnect", "code": 1000}

        socket = asyncio.create_task(own.guard(own.page.scope("websocket", "/api/live"), receive, said.put))
        assert (await said.get())["type"] == "websocket.accept"
        head = await asyncio.to_thread(own.head)
        body = {"head": head, "act": {"kind": "claim", "track": "*2", "name": "RKNE"}, "why": ""}
        done = await asyncio.to_thread(own.page.post, address, body)
        while (message := json.loads((await asyncio.wait_for(said.get(), 20))["text"]))["kind"] != "trial":
            pass
        gone.set()
        await socket
        return message, done.json()["head"]

    message, head = asyncio.run(told())
    assert message["head"] == head


@pytest.mark.parametrize("others", [False, True])
def test_small_pictures_are_begun_once_all_runs_are_over(studio, monkeypatch, others):
    running, begun = studio.app.state.live, []
    mosaics = SimpleNamespace(begin=lambda: begun.append(True))
    monkeypatch.setattr(live, "mosaics_of", lambda document: mosaics)
    key = studio.trial.rsplit("/", 1)[1]
    monkeypatch.setitem(running.jobs, "a", messages.Job(id="a", trial=key, state="running"))
    if others:
        monkeypatch.setitem(running._running, "b", (running.desk.place(key), None))
    running._follow("a", key, SimpleNamespace(progress=lambda: iter([("write", 1, 1)])))
    assert running.jobs["a"].state == "done" and begun == ([] if others else [True])
