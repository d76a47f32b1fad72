"""What is said on the page stands in the journal, changes what it is about and nothing else, and can be taken back."""

import base64
import json
import time
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.engine.editing.files import journal_at, open_editing
from kinemark.io.trial import read_trial
from support.studio import Studio, file_in


@pytest.fixture
def file(tmp_path):
    return file_in(tmp_path)


@pytest.fixture
def studio(file):
    return Studio(file)


def paths(studio, view="edited", marker=()):
    """xyz (m, n, 3) by name, as the page reads it."""
    query = "".join(f"&marker={name}" for name in marker)
    answer = studio.page.get(f"{studio.trial}/paths?view={view}{query}")
    about = json.loads(answer.headers["x-kinemark-paths"])
    m, n = len(about["names"]), about["n_frames"]
    assert len(answer.body) == m * n * (12 + 4 + 1)
    xyz = np.frombuffer(answer.body[: m * n * 12], "<f4").reshape(m, n, 3)
    return dict(zip(about["names"], xyz, strict=True))


def test_the_page_sees_the_samples_of_the_file(studio, file):
    found, given = paths(studio), read_trial(file).trajectories
    assert tuple(found) == given.names
    for path in given:
        assert np.array_equal(found[path.name], path.xyz.astype(np.float32), equal_nan=True)
    assert list(paths(studio, marker=["RKNE"])) == ["RKNE"]


def test_an_act_changes_what_it_is_about_and_says_so_and_undo_and_redo_come_back(studio, file):
    before = paths(studio)
    done = studio.act(kind="erase", marker="LKNE", first=10, last=19).json()
    assert done["changed"] == ["LKNE"] and done["removed"] == []
    assert [one["outcome"] for one in done["outcomes"]] == ["held"]
    after = paths(studio)
    assert np.isnan(after["LKNE"][9:19]).all() and not np.isnan(after["LKNE"][19]).any()
    assert np.array_equal(after["RKNE"], before["RKNE"])
    assert done["header"]["undo"] == 1 and done["header"]["redo"] is None
    undone = studio.act(kind="undo").json()
    assert undone["changed"] == ["LKNE"] and undone["header"]["redo"] == 2
    assert np.array_equal(paths(studio)["LKNE"], before["LKNE"])
    studio.act(kind="redo")
    assert np.array_equal(paths(studio)["LKNE"], after["LKNE"], equal_nan=True)
    assert np.array_equal(paths(studio, "before")["LKNE"], before["LKNE"])
    assert [entry.id for entry in journal_at(file).entries] == [1, 2, 3]


def as_brought(part):
    """The three columns of a message's paths, as the page reads them, by name."""
    m, n = len(part["names"]), part["n_frames"]
    kinds = {"xyz": ("<f4", (m, n, 3)), "sd": ("<f4", (m, n)), "origin": ("u1", (m, n))}
    columns = [np.frombuffer(base64.b64decode(part[k]), kind).reshape(shape) for k, (kind, shape) in kinds.items()]
    return {name: [column[i] for column in columns] for i, name in enumerate(part["names"])}


def laid_over(held, part):
    """The paths of an act on those that the page has, as it lays them: (paths, samples that were sent)."""
    n, at = len(next(iter(held.values()))[2]), part["first_frame"] - 1
    blank = [np.full((n, 3), np.nan, "<f4"), np.full(n, np.nan, "<f4"), np.zeros(n, "u1")]
    found = {}
    for base, (name, own) in zip(part["bases"], as_brought(part).items(), strict=True):
        found[name] = [column.copy() for column in (held[base] if base else blank)]
        for column, values in zip(found[name], own, strict=True):
            column[at : at + len(values)] = values
    return found, len(part["names"]) * part["n_frames"]


def as_asked(studio):
    answer = studio.page.get(f"{studio.trial}/paths?view=filled")
    about = json.loads(answer.headers["x-kinemark-paths"])
    m, n = len(about["names"]), about["n_frames"]
    ends = np.cumsum([0, 12 * m * n, 4 * m * n, m * n])
    xyz, sd, origin = (answer.body[a:b] for a, b in pairwise(ends))
    part = {"xyz": xyz, "sd": sd, "origin": origin}
    return as_brought(about | {k: base64.b64encode(body) for k, body in part.items()})


def test_what_acts_bring_kept_by_the_page_is_what_it_would_be_given_anew(studio, monkeypatch):
    held = as_asked(studio)
    acts = [
        {"kind": "claim", "track": "*4", "name": "T10", "at": 50},
        {"kind": "exchange", "a": "LKNE", "b": "RKNE", "first": 100},
        {"kind": "erase", "marker": "LKNE", "first": 10, "last": 19},
        {"kind": "gap", "marker": "LKNE", "first": 10, "last": 19, "method": "open"},
        {"kind": "put", "marker": "T10", "frame": 7, "xyz": [1.0, 2.0, 3.0], "sd": 0.5},
        {"kind": "claim", "track": "RKNE", "name": None, "at": 50},
        *[{"kind": "undo"}] * 3,
        {"kind": "redo"},
    ]
    sent = []
    for act in acts:
        done = studio.act(**act).json()
        brought, n = laid_over(held, done["paths"])
        sent.append(n)
        held = {name: path for name, path in held.items() if name not in done["removed"]} | brought
        now = as_asked(studio)
        assert held.keys() == now.keys()
        for name, path in now.items():
            assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(held[name], path, strict=True)), (act, name)
    assert (sent[0], sent[2], sent[4]) == (0, 10, 1), "no samples but those that are others"
    monkeypatch.setattr("kinemark.apps.studio.acts.MOST_SAMPLES", 0)
    assert studio.act(kind="undo").json()["paths"] is None  # then it asks


def test_paths_with_fills_that_are_still_computed_are_not_brought(studio, monkeypatch):
    studio.act(kind="erase", marker="LKNE", first=10, last=19)
    monkeypatch.setattr("kinemark.apps.studio.gap_work.GapWork.known", lambda *_: None)
    done = studio.act(kind="gap", marker="LKNE", first=10, last=19, method="linear").json()
    assert done["paths"] is None and done["changed"] == ["LKNE"]


def test_every_kind_of_act_stands_in_the_journal_as_the_library_says_it(studio, file):
    acts = [
        {"kind": "claim", "track": "*4", "name": "T10", "first": None, "last": None, "at": 50},
        {"kind": "exchange", "a": "LKNE", "b": "RKNE", "first": 100},
        {"kind": "put", "marker": "T10", "frame": 7, "xyz": [1.0, 2.0, 3.0], "sd": 0.5},
        {"kind": "smooth", "marker": "RKNE", "first": 20, "last": 60, "cutoff_hz": 10},
        {"kind": "smooth", "marker": "LKNE", "first": 20, "last": 60, "cutoff_hz": 8, "function": "woltring"},
        {"kind": "erase", "marker": "RKNE", "first": 150, "last": 152},
        {"kind": "gap", "marker": "RKNE", "first": 150, "last": 152, "method": "linear"},
        {"kind": "event", "label": "Foot Strike", "side": "Left", "time_s": 0.5},
        {"kind": "several", "acts": [{"kind": "erase", "marker": n, "first": 1, "last": 2} for n in ("LKNE", "T10")]},
        {"kind": "trim", "first": 5, "last": 190},
        {"kind": "finish", "first": 6, "last": 180},
        {"kind": "sign"},
    ]
    for act in acts:
        answer = studio.act(**act)
        assert answer.status == 200, answer.body
        moot = {"moot"} if act["kind"] == "finish" else set()  # as all have names by then
        assert {one["outcome"] for one in answer.json()["outcomes"]} <= {"held"} | moot
    header = studio.page.get(studio.trial).json()
    assert header["trim"] == [6, 180] and header["events"][-1]["label"] == "Foot Strike"
    assert open_editing(file).journal.head == header["head"]
    history = studio.page.get(f"{studio.trial}/history").json()["entries"]
    assert len(history) == len(acts) and history[-1]["signed"] and not any(row["undone"] for row in history)
    assert len(history[8]["outcomes"]) == 2 and all(row["by"] == "op" for row in history)
    said = [edit.function for entry in journal_at(file).entries for edit in entry.edits if edit.kind == "smooth"]
    assert said == ["butterworth", "woltring"]
    filled = _until(lambda: studio.page.get(f"{studio.trial}/paths?view=filled&marker=RKNE"))
    assert np.isfinite(np.frombuffer(filled.body[: 200 * 12], "<f4").reshape(200, 3)[149:152]).all()


def _until(ask, tries=100):
    """What is computed behind, when it is there."""
    for _ in range(tries):
        answer = ask()
        if not json.loads(answer.headers["x-kinemark-paths"])["pending"]:
            return answer
        time.sleep(0.05)
    raise AssertionError("it never comes")


@pytest.mark.parametrize(
    "act",
    [
        {"kind": "claim", "track": "nobody", "name": "A"},
        {"kind": "claim", "track": "LKNE", "name": "*7"},
        {"kind": "claim", "track": "LKNE", "name": "A", "first": 900},
        {"kind": "exchange", "a": "*4", "b": "*4"},
        {"kind": "erase", "marker": "*4", "first": 1, "last": 2},
        {"kind": "erase", "marker": "LKNE", "first": 9, "last": 2},
        {"kind": "gap", "marker": "LKNE", "first": 1, "last": 2, "method": "magic"},
        {"kind": "put", "marker": "LKNE", "frame": 1, "clicks": [{"camera": "c0", "u": 1, "v": 2}]},
        {"kind": "undo"},
        {"kind": "undo", "of": 99},
        {"kind": "redo"},
        {"kind": "review", "problem": "swap-1", "right": True},
        {"kind": "alternative", "problem": "swap-1", "key": "keep"},
        {"kind": "several", "acts": []},
    ],
    ids=lambda act: "-".join(map(str, act.values()))[:40],
)
def test_what_cannot_be_is_refused_in_words_and_stands_nowhere(studio, file, act):
    answer = studio.act(**act)
    assert answer.status == 422 and len(answer.json()["words"]) > 20
    assert not journal_at(file).path.exists()


def test_a_page_that_has_not_seen_what_another_said_is_told_and_harms_nothing(studio, file):
    seen, other = studio.head(), studio.another_page()
    body = {"head": seen, "act": {"kind": "erase", "marker": "LKNE", "first": 1, "last": 3}, "why": ""}
    assert other.post(f"{studio.trial}/acts", body).status == 200
    late = studio.act(head=seen, kind="erase", marker="RKNE", first=1, last=3)
    assert late.status == 409 and late.json()["head"] == studio.head() != seen
    assert len(journal_at(file).entries) == 1
    open_editing(file).erase("RKNE", 5, 6)  # another process, as from the command line
    assert studio.act(head=late.json()["head"], kind="undo").status == 409
    assert studio.page.get(f"{studio.trial}/history").json()["entries"][-1]["words"].startswith("RKNE")


def test_a_preview_gives_what_the_act_would_and_is_written_nowhere(studio, file):
    act = {"kind": "erase", "marker": "LKNE", "first": 10, "last": 19}
    found = studio.page.post(f"{studio.trial}/preview", {"act": act}).json()
    assert not journal_at(file).path.exists() and studio.page.get(studio.trial).json()["edits"] == 0
    assert found["changed"] == ["LKNE"] and (found["paths"]["first_frame"], found["paths"]["n_frames"]) == (10, 10)
    assert np.isnan(np.frombuffer(base64.b64decode(found["paths"]["xyz"]), "<f4")).all()
    claim = {"kind": "claim", "track": "*4", "name": "LKNE"}
    join = studio.page.post(f"{studio.trial}/preview", {"act": claim}).json()["join"]
    assert join["overlap"] == 200 and not join["connectable"]


def test_a_question_about_what_is_there_no_more_has_no_answer_and_is_no_error(studio, file):
    """The page asks ahead, and what it asks about may be gone when the question arrives."""
    gone = [
        {"kind": "alternative", "problem": "swap:A:B:1", "key": "exchange"},
        {"kind": "claim", "track": "*99", "name": "LKNE"},
    ]
    for act in gone:
        answer = studio.page.post(f"{studio.trial}/preview", {"act": act})
        assert (answer.status, answer.json()) == (200, None)
        assert studio.act(**act).status == 422  # said, it is refused
    answer = studio.page.get(f"{studio.trial}/gaps/LKNE/50")
    assert (answer.status, answer.json()) == (200, None)


def test_problems_lead_to_edits_that_mend_them(tmp_path):
    file = file_in(tmp_path, seed=3)
    studio = Studio(file)
    before = paths(studio)
    assert studio.act(kind="exchange", a="LKNE", b="RKNE", first=80).status == 200  # a fault, made on purpose
    listed = studio.page.get(f"{studio.trial}/problems").json()
    worst = listed["problems"][0]
    assert worst["kind"] == "swap" and set(worst["tracks"]) == {"LKNE", "RKNE"} and worst["frame"] in (79, 80)
    assert worst["wrong"] > 0.9 and listed["worth_looking"] >= 1 and listed["errors"] > listed["errors_left"]
    mend = next(one for one in worst["alternatives"] if one["action"] == "exchange")
    assert studio.act(**mend["act"]).status == 200
    assert np.array_equal(paths(studio)["LKNE"], before["LKNE"])
    left = studio.page.get(f"{studio.trial}/problems").json()["problems"]
    assert worst["id"] not in [one["id"] for one in left] and not any(one["kind"] == "swap" for one in left)


def test_gaps_are_listed_with_every_way_to_fill_them_and_versions_differ_by_what_was_said(studio):
    truth = paths(studio)["LKNE"][49:60]
    studio.act(kind="erase", marker="LKNE", first=50, last=60)
    row = studio.page.get(f"{studio.trial}/gaps").json()["gaps"][0]
    assert (row["marker"], row["first"], row["last"], row["frames"]) == ("LKNE", 50, 60, 11)
    ways = studio.page.get(f"{studio.trial}/gaps/LKNE/50").json()["candidates"]
    assert len(ways) >= 2 and len(ways[0]["xyz"]) == 11
    off = np.linalg.norm(np.array(ways[0]["xyz"]) - truth, axis=1)
    assert off.mean() < 3 * max(ways[0]["expected_mm"], 0.5)
    found = studio.page.get(f"{studio.trial}/diff?of=0&other=1").json()
    assert found["identities"] == [] and found["samples"] == [
        {"marker": "LKNE", "what": "erased", "first": 50, "last": 60, "samples": 11, "max_mm": None}
    ]


def test_the_edited_file_is_written_beside_and_nothing_over_what_was_given(studio, file):
    given = file.read_bytes()
    studio.act(kind="erase", marker="LKNE", first=1, last=20)
    names = [studio.page.post(f"{studio.trial}/export", {}).json()["name"] for _ in range(2)]
    assert names == ["walk-edited.c3d", "walk-edited-2.c3d"] and file.read_bytes() == given
    assert np.isnan(read_trial(file.with_name(names[0])).trajectories["LKNE"].xyz[:20]).all()


def test_no_act_waits_for_problems_that_are_looked_for(tmp_path, monkeypatch):
    """A problem whose tracks nobody touched since is settled by what was known; of a touched one it is looked anew."""
    from kinemark.apps.studio import problems as looked

    file, calls = file_in(tmp_path, seed=3), []
    studio, real = Studio(file), looked.problems
    studio.act(kind="exchange", a="LKNE", b="RKNE", first=80)
    studio.act(kind="erase", marker="<img src=x onerror=alert(1)>", first=150, last=150)
    swap = studio.page.get(f"{studio.trial}/problems").json()["problems"][0]
    mend = next(one for one in swap["alternatives"] if one["action"] == "exchange")
    monkeypatch.setattr(looked, "problems", lambda *a, **k: (calls.append(1), real(*a, **k))[1])
    studio.act(kind="erase", marker="<img src=x onerror=alert(1)>", first=20, last=29)  # of another track
    assert studio.act(**mend["act"]).status == 200 and not calls
    again = studio.act(**mend["act"])
    assert (again.status, len(calls)) == (422, 1) and "no more" in again.json()["words"]
