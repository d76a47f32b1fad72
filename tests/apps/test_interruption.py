"""Ctrl-C at any moment ends a command with one line and status 130, and leaves nothing half-written."""

import os
import random
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from kinemark.data.progress import Cancelled, listening, tell
from kinemark.detect import detect
from kinemark.detect.frame_source import BATCH
from kinemark.engine.simulate import Scene, simulate
from kinemark.io.trial import write_trial
from support.trials import made_trial

READY = """
import signal
import sys

signal.signal(signal.SIGINT, signal.default_int_handler)  # tests that run in the background inherit that it is ignored

from kinemark.__main__ import main

class Ready:  # says so at the first import that main itself does: before it, Ctrl-C would meet this script
    def find_spec(self, name, *_):
        if name == "kinemark.apps.cli":
            print("ready", flush=True)

sys.meta_path.insert(0, Ready())
main()
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A session and a trial to work on."""
    folder = tmp_path_factory.mktemp("interrupted")
    simulate(folder / "session", scene=Scene(seconds=0.5, size_px=(376, 292), focal_px=385.0, cameras=3))
    write_trial(made_trial(), folder / "trial.c3d")
    return folder


COMMANDS = {
    "help": (["--help"], 0.3),
    "info": (["info", "trial.c3d"], 0.5),
    "init": (["init", "session/walk01", "--yes", "--dry-run"], 1.5),
    "simulate": (["simulate", "new", "--seconds", "20"], 2.5),
    "run": (["run", "session", "--results", "made"], 3.0),
}


def interrupted(arguments, folder, after):
    """Status and error stream of a command that gets Ctrl-C so many seconds after it began."""
    process = subprocess.Popen(
        [sys.executable, "-c", READY, *arguments], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "ready\n"
    time.sleep(after)
    process.send_signal(signal.SIGINT)
    return process.communicate(timeout=60)[1], process.returncode


ELSEWHERE = """
import signal, time, types, sys

signal.signal(signal.SIGINT, signal.default_int_handler)  # as above

class Gone:
    def __del__(self):
        raise KeyboardInterrupt

class Named:
    def __set_name__(self, owner, name):
        raise KeyboardInterrupt

def let_go():
    Gone()
    time.sleep(30)

def class_made():
    type("Made", (), {"named": Named()})

sys.modules["kinemark.apps.cli"] = types.SimpleNamespace(main=locals()[sys.argv[1]])
from kinemark.__main__ import main
main()
"""


@pytest.mark.parametrize("moment", ["let_go", "class_made"])
def test_ctrl_c_counts_too_where_python_drops_it_or_makes_another_error_of_it(moment):
    """It is dropped while an object is let go; Python 3.11 makes a RuntimeError of it while a class is made."""
    script = [sys.executable, "-c", ELSEWHERE, moment]
    done = subprocess.run(script, capture_output=True, text=True, check=False, timeout=20)  # it waits for 30 s
    assert (done.returncode, done.stderr.count("\n"), "Traceback" in done.stderr) == (130, 2, False)


@pytest.mark.skipif(os.name == "nt", reason="signals are sent otherwise")
@pytest.mark.parametrize("name", COMMANDS)
def test_ctrl_c_ends_a_command_with_one_line(name, folder):
    arguments, longest = COMMANDS[name]
    for after in (0.0, random.Random(name).uniform(0.05, longest)):
        said, status = interrupted(arguments, folder, after)
        assert "Traceback" not in said and "Exception" not in said, said
        assert status in (0, 130, -signal.SIGINT)  # the last: at the interpreter's own end
        if status == 130:
            assert [line for line in said.splitlines() if "stopped" in line] == [said.strip().splitlines()[-1]]
        else:
            assert after > 0  # it had ended before
    left = [path.name for path in folder.rglob("*.part*")]
    assert not left
    assert not (folder / "new").exists()


class Endless:
    """Images that never end, of a camera beside one that fails."""

    size, n_frames, rate = (16, 16), 10**6, 50.0

    def __init__(self, fails):
        self.fails = fails

    def v_offset(self, f):
        return 0.0

    def batches(self, n):
        while True:
            if self.fails:
                raise KeyboardInterrupt
            yield np.zeros((n, 16, 16), np.uint8)


def test_the_other_cameras_are_not_waited_for():
    with pytest.raises(KeyboardInterrupt):
        detect([Endless(True), Endless(False)], cameras=("a", "b"), rate=50.0, threads=2)


class Dark:
    """Black images of a camera."""

    size, n_frames, rate = (16, 16), 4 * BATCH, 50.0

    def v_offset(self, f):
        return 0.0

    def batches(self, n):
        for _ in range(self.n_frames // n):
            yield np.zeros((n, 16, 16), np.uint8)


def test_whoever_listens_hears_how_far_all_cameras_are_and_stops_them():
    """They are looked at in threads of their own, in which nobody listens by himself."""
    heard, total = [], 2 * Dark.n_frames

    def run(listener):
        with listening(listener):
            detect([Dark(), Dark()], cameras=("a", "b"), rate=50.0, threads=2, progress=lambda done: tell(done, total))

    run(lambda *said: heard.append(said))
    assert heard[-1] == (total, total) and len(heard) == 8 and [done for done, _ in heard] == sorted(dict(heard))

    def stop(done, total):
        heard.append(done)
        raise Cancelled

    heard.clear()
    with pytest.raises(Cancelled):
        run(stop)
    assert len(heard) <= 2
