"""Gaps in the studio: judged together, with one measure of what is expected of each way to fill one."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.apps.studio import gap_work as module
from kinemark.data import KinemarkError, MarkerTrajectory, Trial
from kinemark.data.progress import listening, tell
from kinemark.fill import Auto, prepare
from kinemark.io.trial import write_trial
from support.studio import Studio
from support.walked import clean, spiked, without

QUICK = Auto(candidates=("linear", "cubic", "rigid_body"))


@pytest.fixture
def studio(tmp_path, monkeypatch):
    """A file with five gaps, filled by methods that take no time."""
    monkeypatch.setattr(module, "prepare", lambda now: prepare(now, method=QUICK))
    write_trial(Trial("walk", five_gaps()), tmp_path / "walk.c3d")
    return Studio(tmp_path / "walk.c3d")


def five_gaps():
    """Of five markers of a walk."""
    hidden = clean(markers=12).frames(0, 200)
    for k in range(5):
        hidden = without(hidden, k, 60 + 20 * k, 66 + 20 * k)
    return hidden


def judged(studio):
    """The table, when all that is worked out behind is there."""
    for _ in range(200):
        table = studio.page.get(f"{studio.trial}/gaps").json()
        if not table["pending"]:
            return table["gaps"]
        time.sleep(0.05)
    raise AssertionError("still judged")


def test_many_gaps_are_judged_together_and_a_way_is_chosen_by_the_errors_that_are_shown(studio, monkeypatch):
    """One by one a recording with 224 of them took four minutes; and the way said to be best was not the best shown."""
    monkeypatch.setattr(module.PreparedFill, "best", lambda *_: pytest.fail("judged by itself"))
    rows = judged(studio)
    assert len(rows) == 5 and all(row["state"] == "fillable" for row in rows)
    for row in rows:
        ways = studio.page.get(f"{studio.trial}/gaps/{row['marker']}/{row['first']}").json()
        shown = {way["method"]: way["expected_mm"] for way in ways["candidates"]}
        others = {other["method"]: other["expected_mm"] for other in row["others"]}
        assert ways["best"] == row["method"] and shown[row["method"]] == row["expected_mm"]
        assert {name: shown[name] for name in others if name in shown} == {
            n: v for n, v in others.items() if n in shown
        }


def test_no_way_to_fill_is_said_to_be_better_where_a_sample_beside_the_gap_is_in_doubt(tmp_path, monkeypatch):
    """All rest on it: the table said 12 mm of the best, and the way beside it 1 mm."""
    monkeypatch.setattr(module, "prepare", lambda now: prepare(now, method=QUICK))
    trial = without(spiked(clean(markers=12).frames(0, 200), 5, 99, 100, mm=35.0), 5, 100, 106)
    write_trial(Trial("walk", trial), tmp_path / "walk.c3d")
    studio = Studio(tmp_path / "walk.c3d")
    (row,) = judged(studio)
    ways = studio.page.get(f"{studio.trial}/gaps/{row['marker']}/{row['first']}").json()
    shown = [one["expected_mm"] for one in (*ways["candidates"], *row["others"])]
    assert row["expected_mm"] > 3.0 and min(mm for mm in shown if mm is not None) >= row["expected_mm"]
    assert ways["candidates"][0]["method"] == ways["best"] == row["method"]


@pytest.mark.parametrize(
    ("methods", "words"),
    [(("linear", "body"), "does not follow a sample beside it, up to 3"), (("linear",), "a sample beside it in doubt")],
)
def test_samples_beside_a_gap_that_are_in_doubt_are_said_in_the_table(tmp_path, monkeypatch, methods, words):
    monkeypatch.setattr(module, "prepare", lambda now: prepare(now, method=Auto(candidates=methods)))
    trial = without(spiked(clean(markers=12).frames(0, 200), 5, 99, 100, mm=35.0), 5, 100, 106)
    write_trial(Trial("walk", trial), tmp_path / "walk.c3d")
    (row,) = judged(Studio(tmp_path / "walk.c3d"))
    assert row["words"].startswith(words)


def test_a_way_that_was_left_behind_shows_no_error_of_another_measure(studio, monkeypatch):
    """By the few tests of the first answer it stood before the way that is proposed, as if it were better."""
    all_best = module.PreparedFill.all_best

    def of_few(self, away=()):
        return tuple(
            replace(fill, gap=replace(fill.gap, candidates={fill.method: fill.expected_mm}))
            for fill in all_best(self, away)
        )

    monkeypatch.setattr(module.PreparedFill, "all_best", of_few)
    for row in judged(studio):
        ways = studio.page.get(f"{studio.trial}/gaps/{row['marker']}/{row['first']}").json()["candidates"]
        assert [way["expected_mm"] for way in ways] == [row["expected_mm"], *[None] * (len(ways) - 1)] and len(ways) > 2
        assert ways[0]["method"] == row["method"]


def test_a_gap_is_listed_with_the_error_that_is_expected_of_filling_it(studio):
    """Not with its cost by the small probability that the fill is far off, which were metres."""
    rows = {row["marker"]: row["expected_mm"] for row in judged(studio)}
    found = studio.page.get(f"{studio.trial}/problems").json()["problems"]
    assert {one["tracks"][0]: one["cost_mm"] for one in found if one["kind"] == "gap"} == rows


def test_the_way_that_is_best_is_filled_at_once_when_it_is_chosen(studio, monkeypatch):
    rows = judged(studio)
    monkeypatch.setattr(module.POOL, "submit", lambda *_: pytest.fail("worked out again"))
    row = next(row for row in rows if " + " not in row["method"])
    done = studio.act(kind="gap", marker=row["marker"], first=row["first"], last=row["last"], method=row["method"])
    assert done.status == 200 and done.json()["paths"]["names"] == [row["marker"]]
    assert studio.act(kind="undo").json()["changed"] == [row["marker"]]  # and is drawn as it was
    assert studio.act(kind="redo").json()["paths"]["names"] == [row["marker"]]
    answer = studio.page.get(f"{studio.trial}/paths?view=filled&column=xyz&marker={row['marker']}")
    assert np.isfinite(np.frombuffer(answer.body, np.float32)).all()


def test_what_could_not_be_judged_is_not_waited_for(studio, monkeypatch):
    def broken(*_):
        raise KinemarkError("no")

    monkeypatch.setattr(module.PreparedFill, "all_best", broken)
    assert {row["state"] for row in judged(studio)} == {"not judged"}


def test_a_gap_beside_a_sample_that_cannot_be_one_is_judged_and_filled(studio, tmp_path):
    """Filling takes such a sample for missing, so that its gap is longer than the one in the table."""
    hidden = five_gaps()
    path = hidden.paths[0]
    xyz = path.xyz.copy()
    xyz[[59, 66]] = 9e6
    write_trial(Trial("walk", replace(hidden, paths=(replace(path, xyz=xyz), *hidden.paths[1:]))), tmp_path / "far.c3d")
    far = Studio(tmp_path / "far.c3d")
    row = judged(far)[0]
    assert row["marker"] == path.name and row["frames"] == 6 and row["state"] == "fillable"
    done = far.act(kind="gap", marker=row["marker"], first=row["first"], last=row["last"], method="best")
    assert done.status == 200
    answer = far.page.get(f"{far.trial}/paths?view=filled&column=xyz&marker={row['marker']}")
    assert np.isfinite(np.frombuffer(answer.body, np.float32)).all()


def test_points_that_are_no_markers_are_not_judged():
    hidden = without(without(clean(markers=12).frames(0, 120), 0, 60, 64), 1, 60, 64)
    path = MarkerTrajectory.measured("no marker", hidden.paths[1].xyz)
    prepared = prepare(replace(hidden, paths=(*hidden.paths, path)), method=QUICK)
    assert len(prepared.all_best()) == 3
    assert [fill.gap.marker for fill in prepared.all_best({"no marker"})] == list(hidden.names[:2])


@pytest.fixture
def slow(monkeypatch):
    """All gaps are judged together as soon as this is set, and tell how far they are meanwhile."""
    go, all_best = threading.Event(), module.PreparedFill.all_best

    def waits(*asked):
        while not go.wait(0.005):
            tell(0, 1)
        return all_best(*asked)

    monkeypatch.setattr(module.PreparedFill, "all_best", waits)
    yield go
    go.set()


def ways(studio, row, there):
    """The ways to fill a gap, asked for until it is so."""
    for _ in range(100):
        found = studio.page.get(f"{studio.trial}/gaps/{row['marker']}/{row['first']}").json()
        if there(found):
            return found
        time.sleep(0.05)
    raise AssertionError(found["best"])


def test_the_gap_that_is_looked_at_is_judged_before_all_others(studio, slow):
    row = studio.page.get(f"{studio.trial}/gaps").json()["gaps"][3]
    found = ways(studio, row, lambda found: found["best"])
    assert found["pending"] and studio.page.get(f"{studio.trial}/gaps").json()["pending"]
    slow.set()
    rows = {(one["marker"], one["first"]): one for one in judged(studio)}
    final = ways(studio, row, lambda found: not found["pending"])
    assert final["best"] == rows[row["marker"], row["first"]]["method"]


def test_a_gap_that_is_filled_is_drawn_before_all_others_are_judged(studio, slow):
    row = studio.page.get(f"{studio.trial}/gaps").json()["gaps"][0]
    studio.act(kind="gap", marker=row["marker"], first=row["first"], last=row["last"], method="cubic")
    for _ in range(100):
        answer = studio.page.get(f"{studio.trial}/paths?view=filled&column=xyz&marker={row['marker']}")
        if np.isfinite(np.frombuffer(answer.body, np.float32)).all():
            return
        time.sleep(0.05)
    raise AssertionError("not drawn")


def test_a_gap_that_nobody_looks_at_any_more_is_not_judged_before_the_others(studio, slow, monkeypatch):
    monkeypatch.setattr(module, "STILL_S", -1.0)
    begun, best = [], module.PreparedFill.best
    monkeypatch.setattr(module.PreparedFill, "best", lambda *asked: (begun.append(asked[1:]), best(*asked))[1])
    busy = threading.Event()
    module.FIRST.submit(busy.wait)  # until the second is looked at
    rows = studio.page.get(f"{studio.trial}/gaps").json()["gaps"]
    for row in rows[:2]:
        studio.page.get(f"{studio.trial}/gaps/{row['marker']}/{row['first']}")
    busy.set()
    ways(studio, rows[1], lambda found: found["best"])
    assert begun == [(rows[1]["marker"], rows[1]["first"])]
    slow.set()
    assert judged(studio)[0]["state"] == "fillable"


def test_the_gap_that_was_looked_at_last_is_judged_however_seldom_the_page_can_ask(studio, slow, monkeypatch):
    """On a busy machine a page asks less often than every second: the gap was given up each time, and its best fill
    came with that of all others."""
    monkeypatch.setattr(module, "STILL_S", -1.0)
    row = studio.page.get(f"{studio.trial}/gaps").json()["gaps"][2]
    assert ways(studio, row, lambda found: found["best"])["pending"]


def judged_meanwhile(monkeypatch):
    """(ticks, meanwhile, end): ticks of a best fill that lasts until `end` is set, and how many came during each call
    for candidates."""
    ticks, meanwhile, end = list[int](), list[int](), threading.Event()
    best, candidates = module.PreparedFill.best, module.PreparedFill.candidates

    def slowly(*asked):
        while not end.wait(0.002):
            tell(len(ticks), 1)
            ticks.append(0)
        return best(*asked)

    def watched(*asked):
        time.sleep(0.01)
        before = len(ticks)
        time.sleep(0.05)
        meanwhile.append(len(ticks) - before)
        return candidates(*asked)

    monkeypatch.setattr(module.PreparedFill, "best", slowly)
    monkeypatch.setattr(module.PreparedFill, "candidates", watched)
    return ticks, meanwhile, end


def test_the_quick_ways_to_fill_a_gap_do_not_wait_for_what_is_looked_at(studio, slow, monkeypatch):
    """The best fill of the gap that was opened before took half of the processor meanwhile."""
    ticks, meanwhile, end = judged_meanwhile(monkeypatch)
    rows = studio.page.get(f"{studio.trial}/gaps").json()["gaps"]
    studio.page.get(f"{studio.trial}/gaps/{rows[0]['marker']}/{rows[0]['first']}")
    while not ticks:  # a busy machine begins it late
        time.sleep(0.005)
    meanwhile.clear()
    found = studio.page.get(f"{studio.trial}/gaps/{rows[1]['marker']}/{rows[1]['first']}").json()
    end.set()
    assert found["candidates"] and set(meanwhile) == {0} and ticks
    ways(studio, rows[1], lambda found: found["best"])  # nothing of this is left for the next test


def test_a_few_gaps_that_are_judged_one_by_one_stand_still_too(studio, monkeypatch):
    module.POOL.submit(lambda: None).result()  # what other tests left is done
    for name, value in (("FEW", 9), ("STILL_S", -1.0)):
        monkeypatch.setattr(module, name, value)
    _, meanwhile, end = judged_meanwhile(monkeypatch)
    row = studio.page.get(f"{studio.trial}/gaps").json()["gaps"][0]
    studio.page.get(f"{studio.trial}/gaps/{row['marker']}/{row['first']}")
    end.set()
    assert meanwhile == [0] and judged(studio)


def test_the_best_fill_of_a_gap_that_was_left_is_given_up_for_the_next_one(studio, slow, monkeypatch):
    """Who went from gap to gap waited for the best fill of each of them."""
    best, begun = module.PreparedFill.best, []

    def slowly(prepared, marker, frame):
        begun.append(marker)
        for _ in range(2000 if len(begun) == 1 else 0):
            tell(0, 1)
            time.sleep(0.005)
        return best(prepared, marker, frame)

    monkeypatch.setattr(module, "STILL_S", 0.5)
    monkeypatch.setattr(module.PreparedFill, "best", slowly)
    rows = studio.page.get(f"{studio.trial}/gaps").json()["gaps"]
    studio.page.get(f"{studio.trial}/gaps/{rows[0]['marker']}/{rows[0]['first']}")
    assert ways(studio, rows[1], lambda found: found["best"]) and begun == [rows[0]["marker"], rows[1]["marker"]]


def test_judging_all_gaps_tells_how_far_it_is_at_each_of_them():
    """The last of it, most of a second with hundreds of gaps, could be neither cancelled nor told to wait."""
    heard = []
    hidden = five_gaps()
    with listening(lambda done, total: heard.append((done, total))):
        found = prepare(hidden, method=QUICK).all_best()
    assert heard[-len(found) :] == [(k, len(found)) for k in range(len(found))]


def test_the_difference_of_two_versions_names_the_gaps_that_are_filled_otherwise(studio):
    """It said that nothing differs, as fills are no samples of a version."""
    row = studio.page.get(f"{studio.trial}/gaps").json()["gaps"][0]
    gap = {key: row[key] for key in ("marker", "first", "last")}
    for method in ("linear", "cubic", "open"):
        studio.act(kind="gap", method=method, **gap)
    differing = studio.page.get(f"{studio.trial}/diff?of=0&other=2").json()
    assert differing["fills"] == [{**gap, "before": None, "after": "cubic"}] and not differing["samples"]
    assert studio.page.get(f"{studio.trial}/diff?of=2&other=3").json()["fills"] == [
        {**gap, "before": "cubic", "after": "open"}
    ]


def test_a_way_that_somebody_chose_stands_in_the_table_with_its_own_error(studio):
    """It stood there with the error of the best: 0.09 mm, where the button had said 0.6."""
    row = next(row for row in judged(studio) if any(other["expected_mm"] for other in row["others"]))
    other = row["others"][-1]
    studio.act(kind="gap", marker=row["marker"], first=row["first"], last=row["last"], method=other["method"])
    (now,) = (one for one in judged(studio) if (one["marker"], one["first"]) == (row["marker"], row["first"]))
    assert (now["state"], now["choice"]) == ("chosen", other["method"])
    assert now["expected_mm"] == other["expected_mm"] != row["expected_mm"]
