"""Problems of an open trial are looked for beside what is said of it, which goes first."""

import threading
import time

import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.apps.studio import acts
from kinemark.apps.studio import problems as module
from kinemark.apps.studio.acts_messages import EraseAct
from kinemark.apps.studio.desk import opened
from kinemark.apps.studio.edit_messages import ActBody
from kinemark.apps.studio.gap_work import work_of
from kinemark.apps.studio.problems import listed, problems_of
from kinemark.apps.studio.shelf import Place
from kinemark.apps.studio.turns import Rank
from kinemark.data.edits import Erase
from kinemark.data.progress import tell
from support.studio import Studio, file_in

LONG_S = 10.0


@pytest.fixture
def document(tmp_path):
    return opened(Place(file_in(tmp_path)), "op")


@pytest.fixture
def looking(monkeypatch):
    """Looking for problems as it takes its time, until somebody lets it end: the heads that were looked at, and the
    steps of it that were done."""
    heads, steps, end, real = [], [], threading.Event(), module.problems

    def slowly(editing, **given):
        heads.append(editing.journal.head)
        while not end.is_set():
            tell(0, 1)
            steps.append(1)
            time.sleep(0.001)
        return real(editing, **given)

    monkeypatch.setattr(module, "problems", slowly)
    yield heads, steps, end
    end.set()


def behind(work):
    """A thread that does it, and what comes of it."""
    found = []
    thread = threading.Thread(target=lambda: found.append(work()), daemon=True)
    thread.start()
    return thread, found


def seen(what):
    until = time.monotonic() + LONG_S
    while not what() and time.monotonic() < until:
        time.sleep(0.001)
    assert what()


def test_those_of_a_version_that_is_no_more_are_not_looked_for_any_longer(document, looking):
    heads, _, end = looking
    thread, found = behind(lambda: problems_of(document))
    seen(lambda: heads)
    document.editing.say(Erase("LKNE", 20, 29))
    document.refresh()
    seen(lambda: len(heads) == 2)  # the first was left, though nobody let it end
    end.set()
    thread.join(LONG_S)
    assert found[0].head == document.head == heads[1] != heads[0]


def test_requests_do_not_pile_up_while_somebody_edits_faster_than_problems_are_found(document, looking):
    """A browser has six at a time, which acts would wait for; whoever shows the trial asks again after each edit."""
    heads, _, end = looking
    asked = []
    for frame in (20, 22, 24):
        asked.append(behind(lambda: listed(document)))
        seen(lambda: heads[-1:] == [document.head])
        document.editing.say(Erase("LKNE", frame, frame + 1))
        document.refresh()
    for thread, found in asked:
        thread.join(LONG_S)
        assert found == [None]  # though nobody let any look end
    end.set()
    assert listed(document).head == document.head


def test_looking_stands_still_while_somebody_waits_for_an_answer(document, looking):
    heads, steps, end = looking
    with work_of(document).turns.taken(Rank.ASKED):
        thread, found = behind(lambda: listed(document))
        seen(lambda: heads)
        time.sleep(0.1)
        assert not steps
    end.set()
    thread.join(LONG_S)
    assert found[0].head == document.head


def test_looking_goes_on_where_an_act_waits_for_it_though_somebody_looks_at_gaps(document, looking):
    """The act holds the document meanwhile: with gaps looked at one after the other it waited for all of these."""
    heads, steps, end = looking
    with work_of(document).turns.taken(Rank.LOOKED_AT):
        shown, _ = behind(lambda: listed(document))
        seen(lambda: heads)
        time.sleep(0.05)
        assert not steps
        waiting, found = behind(lambda: problems_of(document))
        seen(lambda: steps)
        end.set()
        waiting.join(LONG_S)
        assert found[0].head == document.head
    shown.join(LONG_S)


def test_an_act_that_waits_for_problems_does_not_keep_them_from_being_looked_for(document):
    """It holds the document meanwhile; whoever looked for them then waited for it, and both for ever."""
    with document.lock:
        thread, found = behind(lambda: problems_of(document))
        thread.join(LONG_S)
        assert found


def test_looking_stands_still_while_something_is_said(document, monkeypatch):
    turns, still, real = work_of(document).turns, [], acts.done

    def done(*given):
        thread, went_on = behind(lambda: turns.give_way(Rank.BEHIND))
        thread.join(0.1)
        still.append(not went_on)
        return real(*given)

    monkeypatch.setattr(acts, "done", done)
    acts.act(
        document, ActBody(head=document.head, act=EraseAct(kind="erase", marker="LKNE", first=20, last=29), why="")
    )
    assert still == [True]


def test_home_says_how_many_are_worth_a_look_as_tracks_does(tmp_path):
    """The tracker's close decisions, which it said before, were 0 where two were to look at, and 19 where none was."""
    studio = Studio(file_in(tmp_path, seed=3))

    def said():
        return studio.page.get("/api/home").json()["files"][0]["problems"]

    assert said() is None  # nobody looked for them
    studio.act(kind="exchange", a="LKNE", b="RKNE", first=80)
    listed = studio.page.get(f"{studio.trial}/problems").json()
    assert said() == listed["worth_looking"] >= 1
    studio.act(kind="exchange", a="LKNE", b="RKNE", first=80)
    assert said() is None  # those were of another version
    studio.page.get(f"{studio.trial}/problems")
    assert said() == 0
