"""A trial as an open document: stages by name, previews, cancelling, jobs, and results that nothing damages."""

import json
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Event, Thread

import numpy as np
import pytest

from kinemark import KinemarkError
from kinemark.data.progress import Cancelled
from kinemark.engine.jobs import Job
from kinemark.engine.session import Session
from kinemark.io.c3d import read_c3d
from support.motions import swarm
from support.sessions import OF_FILE, session_of_points

POINTS = swarm(n=5, frames=120)


@pytest.fixture
def folder(tmp_path):
    return session_of_points(tmp_path, POINTS)


def test_a_run_to_a_stage_does_what_that_needs_and_no_more(folder):
    trial = Session.open(folder).trial("one")
    assert trial.stages == ("detect", "track", "quality", "write")
    assert trial.state() == dict.fromkeys(trial.stages, False)
    tracked = trial.run("track")
    assert tracked.computed == ("detect", "track") and not list(tracked.folder.glob("*.c3d"))
    assert tracked.state() == {"detect": True, "track": True, "quality": False, "write": False}
    assert len(tracked.tracks) == 5
    assert tracked.run().computed == ("quality", "write")
    assert trial.run().computed == ()  # the value that was opened first is as it was, the results are not


def test_a_trial_that_was_not_run_says_so(folder):
    trial = Session.open(folder).trial("one")
    with pytest.raises(KinemarkError, match="has no detect yet: run it to 'track' first"):
        _ = trial.tracks
    with pytest.raises(KinemarkError, match="no stage 'trakc' here; there are detect, track"):
        trial.run("trakc")


def test_a_trial_that_is_opened_again_has_what_is_up_to_date(folder):
    run = Session.open(folder).trial("one").run("track")
    opened = Session.open(folder).trial("one")
    assert opened.done("track") and not opened.done("write")
    np.testing.assert_array_equal(opened.tracks.cloud.xyz, run.tracks.cloud.xyz)
    with pytest.raises(KinemarkError, match="has no quality yet: run it to 'quality' first"):
        _ = opened.quality
    other = Session.open(folder, overrides=["track.gate=4.0"]).trial("one")
    with pytest.raises(KinemarkError, match="has no track yet"):
        _ = other.tracks  # those of the run were made with another gate


def test_results_that_were_replaced_are_not_taken_for_those_of_the_run(folder):
    before = Session.open(folder).trial("one").run("track")
    Session.open(folder, overrides=["track.gate=4.0"]).trial("one").run("track")
    with pytest.raises(KinemarkError, match="was changed since"):
        _ = before.tracks


def test_a_preview_is_the_stretch_of_the_whole_and_leaves_that_alone(folder):
    trial = Session.open(folder).trial("one")
    whole = trial.run()
    kept = (whole.folder / "one.c3d").read_bytes()
    preview = trial.preview(31, 90).run()
    assert preview.detections.n_frames == 60
    part, all_frames = read_c3d(preview.folder / "one.c3d").trajectories, whole.trajectories
    assert (part.first_frame, part.n_frames) == (31, 60)
    near = np.nanmin(np.linalg.norm(part.xyz[:, None] - all_frames.xyz[None, :, 30:90], axis=-1).max(-1), 1)
    assert near.max() < 0.5  # mm: the same paths, whatever their numbers
    assert (whole.folder / "one.c3d").read_bytes() == kept and whole.run().computed == ()


def test_a_session_can_say_which_frames_are_processed(folder):
    (folder / "session.toml").write_text(OF_FILE + "frames = [11, 50]\n")
    trial = Session.open(folder).run()["one"]
    assert trial.trajectories.first_frame == 11 and trial.trajectories.n_frames == 40
    assert trial.folder == folder / "results/one"
    for wrong, said in (("[50, 11]", "give the first, then the last"), ("[0, 5]", "greater than or equal to 1")):
        (folder / "session.toml").write_text(OF_FILE + f"frames = {wrong}\n")
        with pytest.raises(KinemarkError, match=said):
            Session.open(folder)
    (folder / "session.toml").write_text(OF_FILE + "frames = [100, 121]\n")
    with pytest.raises(KinemarkError, match="has 120 frames"):
        Session.open(folder).run()


@pytest.mark.parametrize("stage", ["detect", "track", "quality", "write"])
def test_a_run_is_cancelled_in_any_stage_and_goes_on_from_there(folder, stage):
    cancel = Event()

    def progress(at, done, total):
        if at == stage:
            cancel.set()

    trial = Session.open(folder).trial("one")
    with pytest.raises(Cancelled, match=stage):
        trial.run(progress=progress, cancel=cancel)
    done = trial.state()
    stages = list(done)
    assert [s for s in stages if done[s]] == stages[: stages.index(stage)]
    assert not list(folder.rglob("*.part*"))
    assert trial.run().computed == tuple(stages[stages.index(stage) :])


def test_a_run_that_another_thread_cancels_ends_soon(folder):
    cancel, said = Event(), []

    def work():
        try:
            Session.open(folder).trial("one").run(cancel=cancel)
        except Cancelled as stopped:
            said.append(stopped)

    cancel.set()
    thread = Thread(target=work)
    thread.start()
    thread.join(30)
    assert not thread.is_alive() and len(said) == 1


def test_a_trial_and_a_job_are_plain_values(folder):
    trial = Session.open(folder).trial("one").run("track")
    again = pickle.loads(pickle.dumps(trial))
    assert again == trial and np.array_equal(again.tracks.id, trial.tracks.id)
    job = Job(folder, "one", to="track", frames=(1, 40))
    assert pickle.loads(pickle.dumps(job)) == job
    assert job.run().detections.n_frames == 40


def test_a_job_runs_in_a_process_of_its_own(folder):
    heard = []
    Job(folder, "one").start().wait(progress=lambda *said: heard.append(said))
    assert {stage for stage, _, _ in heard} >= {"detect", "track", "quality", "write"}
    assert Session.open(folder).trial("one").run().computed == ()
    with pytest.raises(KinemarkError, match="no trial two"):
        Job(folder, "two").start().wait()


def test_a_job_that_is_cancelled_ends_at_once_and_leaves_what_was_finished(folder):
    running = Job(folder, "one").start()
    for stage, _, _ in running.progress():
        if stage == "track":
            break
    began = time.perf_counter()
    running.cancel()
    assert time.perf_counter() - began < 5
    assert Session.open(folder).trial("one").state()["detect"]
    assert Session.open(folder).trial("one").run().computed[0] != "detect"


KILLED = """\
import os, signal, sys
from kinemark.engine.session import Session
n = int(sys.argv[2])
def progress(stage, done, total):
    global n
    n -= 1
    if n == 0:
        os.kill(os.getpid(), signal.SIGKILL)
Session.open(sys.argv[1]).run(progress=progress)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system cannot kill a process without a word")
@pytest.mark.parametrize("n", [3, 60, 200])
def test_a_killed_run_loses_nothing_and_the_next_gives_the_same(folder, n, tmp_path_factory):
    other = tmp_path_factory.mktemp("whole")
    for file in folder.iterdir():
        (other / file.name).write_bytes(file.read_bytes())
    clean = Session.open(other).run()["one"]
    given = {file: file.read_bytes() for file in folder.iterdir() if file.is_file()}
    killed = subprocess.run([sys.executable, "-c", KILLED, str(folder), str(n)], check=False)
    assert killed.returncode in (0, -signal.SIGKILL)
    after = Session.open(folder).run()["one"]
    assert {file: file.read_bytes() for file in given} == given
    assert np.array_equal(after.tracks.cloud.xyz, clean.tracks.cloud.xyz)
    assert not list((folder / "results/one").glob(".*.part*"))


def test_two_processes_on_one_session_do_not_damage_it(folder):
    code = "import sys; from kinemark.engine.session import Session; Session.open(sys.argv[1]).run()"
    both = [subprocess.Popen([sys.executable, "-c", code, str(folder)], stderr=subprocess.PIPE) for _ in range(2)]
    assert [process.communicate()[1] for process in both] == [b"", b""]
    assert [process.returncode for process in both] == [0, 0]
    trial = Session.open(folder).run()["one"]
    assert trial.computed == () and len(trial.tracks) == 5
    assert len(json.loads((trial.folder / "steps.json").read_text())) == 4


def test_results_that_cannot_be_written_are_said_and_can_go_elsewhere(folder, tmp_path_factory):
    (folder / "results").write_text("a file where the folder should be")
    with pytest.raises(KinemarkError, match="cannot be written"):
        Session.open(folder).run()
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    assert Session.open(folder, results=elsewhere).run()["one"].folder == elsewhere / "one"


def test_a_full_disk_is_said_and_what_was_finished_is_kept(folder, monkeypatch):
    def full(path, record):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("kinemark.engine.trial_graph.write_report", lambda path, **_: full_disk(path))
        with pytest.raises(KinemarkError, match="disk is full: make room"):
            Session.open(folder).run()
    trial = Session.open(folder).run()["one"]
    assert trial.computed == ("write",) and (trial.folder / "report.html").is_file()


def full_disk(path: Path) -> None:
    """What `replacing` does when there is no room."""
    from kinemark.io.files import replacing

    with replacing(path):
        raise OSError(28, "No space left on device")


def test_a_session_keeps_no_arrays_of_its_trials(folder):
    trials = Session.open(folder).run()
    assert len(pickle.dumps(trials)) < 40_000  # settings and steps; the detections alone are larger


def test_threads_are_the_callers_to_set(folder):
    with pytest.raises(KinemarkError, match="threads is 0"):
        Session.open(folder).run(threads=0)
    assert Session.open(folder).run(threads=1)["one"].computed == ("detect", "track", "quality", "write")


def test_a_preview_of_ten_frames_is_tracked(folder):
    trial = Session.open(folder).trial("one").preview(6, 15).run("track")
    assert len(trial.tracks) == 5
