"""What is shown while a command works."""

import re
import time
from contextlib import contextmanager, suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinemark.apps.commands import analysis
from kinemark.apps.commands import audit as audit_command
from kinemark.apps.progress import ProgressLines, at_work, progress
from kinemark.data import KinemarkError
from kinemark.engine.progress import Watch
from kinemark.io.trial import write_trial
from support.trials import made_trial


def lines(steps, every=10.0):
    """What is written of steps, each (s, stage, done, total)."""
    now, written = [0.0], []
    tell = ProgressLines(written.append, clock=lambda: now[0], every=every)
    for at, *step in steps:
        now[0] = at
        tell(*step)
    return written


def test_a_long_stage_tells_how_long_it_will_take():
    assert lines([(0, "detect", 0, 100), (5, "detect", 20, 100), (10, "detect", 40, 100), (15, "detect", 60, 100)]) == [
        "detect: 40 of 100, about 15 s left"
    ]


def test_short_commands_write_nothing():
    assert lines([(k, "fill", k, 9) for k in range(9)]) == []


def test_each_stage_has_a_pace_of_its_own():
    steps = [(0, "detect", 0, 10), (60, "detect", 10, 10), (60, "track", 0, 10), (71, "track", 5, 10)]
    assert lines(steps) == ["detect: 10 of 10", "track: 5 of 10, about 11 s left"]


def test_a_long_step_is_said_to_go_on():
    """A pass of filling, or one camera's calibration, may take half a minute within a step."""
    now, written = [0.0], []
    tell = ProgressLines(written.append, clock=lambda: now[0], every=10.0)
    tell("fill", 3, 9)
    for now[0] in (4.0, 11.0, 12.0, 22.0):
        tell.beat()
    assert written == ["fill: 3 of 9, 11 s so far", "fill: 3 of 9, 22 s so far"]


def test_where_no_step_comes_a_line_comes_by_itself(capsys):
    written, last = "", time.monotonic() + 60
    with progress(every=0.02):
        while not written and time.monotonic() < last:
            time.sleep(0.02)
            written = capsys.readouterr().err
    assert re.match(r"at work: \d+ s so far\n", written)


@pytest.mark.parametrize("command", ["audit", "gait", "angles"])
def test_commands_that_take_long_on_one_file_tell_what_they_look_at(command, tmp_path, monkeypatch):
    """On a terminal beside the spinner; else in the lines of `at_work`."""
    said = []

    @contextmanager
    def heard(**_):
        yield said.append

    write_trial(made_trial(), tmp_path / "walk.c3d")
    module = {"audit": audit_command}.get(command, analysis)
    monkeypatch.setattr(module, "at_work", heard)
    with suppress(KinemarkError, SystemExit):  # what becomes of it is no matter here
        getattr(module, command)(tmp_path / "walk.c3d", **({"model": "um2as"} if command == "angles" else {}))
    assert len(said) == 1 and str(tmp_path / "walk.c3d") in said[0]


@given(st.lists(st.tuples(st.floats(0, 5), st.sampled_from("ab"), st.integers(0, 9), st.integers(0, 9)), max_size=40))
def test_lines_are_as_rare_as_they_should_be_whatever_is_told(steps):
    at, timed = 0.0, []
    for pause, stage, done, total in steps:
        at += pause
        timed.append((at, stage, done, total))
    assert len(lines(timed)) <= at / 10.0


def test_what_has_no_steps_to_count_is_said_to_go_on(capsys):
    with at_work(every=0.02) as tell:
        tell("naming the markers of walk.c3d")
        time.sleep(0.15)
    said = capsys.readouterr().err.splitlines()
    assert said and set(said) == {"naming the markers of walk.c3d: 0 s so far"}
    time.sleep(0.05)
    assert not capsys.readouterr().err  # nothing goes on when it is done


def test_what_is_done_never_falls_within_a_pass():
    heard = []
    listen = Watch(lambda *step: heard.append(step)).of("track")
    for step in [(0, 1), (0, 4), (2, 4), (0, 6), (6, 6), (1, 1)]:
        listen(*step)
    assert heard == [
        ("track", 0, 1), ("track", 0, 4), ("track", 2, 4),
        ("track, pass 2", 0, 6), ("track, pass 2", 6, 6), ("track, pass 2", 6, 6),
    ]  # fmt: skip
