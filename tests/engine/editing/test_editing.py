"""Editing a session's trial and a file: what is said holds through the pipeline, and nothing else changes."""

import json
from dataclasses import replace

import numpy as np
import pytest

from kinemark import KinemarkError
from kinemark.data import MarkerTrajectory, Origin, Trial, same
from kinemark.data.edits import Erase
from kinemark.edit import Edited, Reviewed
from kinemark.engine.editing import makers as make
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.files import journal_at, open_editing, write_edited
from kinemark.engine.editing.stage import EditRecord, unreviewed
from kinemark.engine.session import Session
from kinemark.io.c3d import read_c3d, write_c3d
from kinemark.track.simultaneous import AmbiguousDecision
from support.edited import paths_without_images
from support.sessions import folder_of


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return folder_of(tmp_path_factory.mktemp("session"), 4)[0]


@pytest.fixture
def session(folder, tmp_path):
    """A copy, which a test may say things of."""
    for name in ("one.h5", "rig.toml", "session.toml"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    return tmp_path


def run(session):
    trial = Session.open(session).run(["one"])["one"]
    return trial, read_c3d(session / "results" / "one" / "one.c3d")


def test_a_session_without_edits_has_no_such_stage_and_undone_ones_leave_it_as_it_was(session):
    trial = Session.open(session).trial("one").run("quality")
    assert trial.stages == ("detect", "track", "quality", "write") and "edits" not in trial.quality
    editing = open_editing(session / "one")
    editing.claim("*1", "A")
    assert trial.stages == ("detect", "track", "edit", "quality", "write") and not trial.state()["quality"]
    editing.journal.undo()
    assert trial.stages == ("detect", "track", "quality", "write") and trial.state()["quality"]


def test_what_is_said_reaches_the_file_and_the_report_and_undo_takes_it_back(session):
    editing = open_editing(session)
    before = Session.open(session).trial("one").run("track").trajectories
    editing.claim("*2", "LKNE")
    editing.erase("LKNE", 5, 8)
    editing.event("Foot Strike", "Left", 0.05)
    said = editing.finish(first=3, last=18)
    assert [one.outcome for one in said.applied] == ["held", "held"]
    trial, file = run(session)
    assert trial.computed == ("edit", "quality", "write"), "what comes before is unchanged"
    assert file.trajectories.names == ("LKNE",) == trial.trajectories.names
    assert (file.trajectories.first_frame, file.trajectories.n_frames) == (3, 16)
    assert np.flatnonzero(np.isnan(file.trajectories["LKNE"].xyz[:, 0])).tolist() == [2, 3, 4, 5]
    assert file.events.label == ("Foot Strike",)
    assert [row["outcome"] for row in trial.quality["edits"]] == ["held"] * 5
    for _ in range(4):
        editing.journal.undo()
    assert same(Session.open(session).trial("one").run("track").trajectories, before)
    assert "The journal has 4 entries" in (session / "results" / "one" / "report.html").read_text("utf-8")


def test_orphans_and_damaged_lines_are_findings(session):
    editing = open_editing(session)
    editing.claim("*1", "A")
    editing.gap("A", 1, 20, "best")
    editing.journal.undo(1)
    with editing.journal.path.open("ab") as file:
        file.write(b'{"id":9,"at"')
    quality = Session.open(session).trial("one").run("quality").quality
    found = {one["kind"]: one for one in quality["findings"]}
    assert found["edits_orphaned"]["markers"] == ["A"] and "no marker A" in found["edits_orphaned"]["text"]
    assert found["edits_unreadable"]["values"]["lines"] == 1 and "cut off" in found["edits_unreadable"]["text"]


def test_a_preview_takes_the_edits_of_its_frames(session):
    open_editing(session).claim("*2", "LKNE")
    trial = Session.open(session).trial("one").preview(3, 20).run("edit")
    assert "LKNE" in trial.trajectories.names and trial.trajectories.first_frame == 3


def test_a_file_is_edited_beside_itself_and_never_changed(tmp_path):
    source = tmp_path / "walk.c3d"
    write_c3d(source, Trial("walk", paths_without_images(frames=60)))
    before = source.read_bytes()
    editing = Editing.of_file(source, by="EG")
    editing.claim("*1", "A", why="the knee")
    editing.claim("*2", None)
    editing.erase("A", 20, 22)
    editing.put("A", 30, (1.0, 2.0, 3.0))
    assert journal_at(source).path == tmp_path / "edits" / "walk.jsonl" and source.read_bytes() == before
    write_edited(open_editing(source), tmp_path / "done.c3d")
    done, was = read_c3d(tmp_path / "done.c3d").trajectories, read_c3d(source).trajectories
    assert done.names == ("A", "*3", "*4") and np.allclose(done["A"].xyz[29], [1, 2, 3])
    assert np.isnan(done["A"].xyz[19:22]).all() and not np.isnan(done["A"].xyz[22]).any()
    assert np.array_equal(done["*3"].xyz, was["*3"].xyz)
    with pytest.raises(KinemarkError, match="nothing is overwritten"):
        write_edited(open_editing(source), tmp_path / "done.c3d")


def test_what_was_said_of_samples_is_an_orphan_where_the_file_is_another_by_now(tmp_path):
    source, made = tmp_path / "walk.c3d", paths_without_images(frames=60)
    named = replace(made, paths=tuple(replace(path, name=n) for path, n in zip(made, "ABCD", strict=True)))
    write_c3d(source, Trial("walk", named))
    editing = Editing.of_file(source)
    editing.erase("A", 20, 22)
    editing.put("B", 30, named["B"].xyz[28].tolist())
    editing.say(*make.claim(editing, "C", "E"), Erase("E", 10, 12))  # named and erased in one act
    edits = [edit for entry in editing.journal.entries for edit in entry.edits]
    assert all(edit.where is not None for edit in edits) and not editing.journal.faults
    assert [one.outcome for one in open_editing(source).edited().applied] == ["held"] * 4
    source.unlink()
    write_c3d(source, Trial("walk", replace(named, paths=tuple(replace(p, xyz=p.xyz + 500.0) for p in named))))
    moved = open_editing(source).edited()
    assert [one.outcome for one in moved.applied] == ["held"] * 4, "all places were moved, and edits go with them"
    assert np.abs(moved.trajectories["B"].xyz[29] - named["B"].xyz[28] - 500.0).max() < 0.1
    source.unlink()
    others = zip(named, paths_without_images(frames=60, seed=9), strict=True)
    write_c3d(source, Trial("walk", replace(named, paths=tuple(replace(p, xyz=q.xyz) for p, q in others))))
    again = open_editing(source).edited()
    assert [one.outcome for one in again.applied] == ["orphan"] * 4 and "edits_orphaned" in {
        finding.kind for finding in EditRecord(again).findings
    }
    assert np.array_equal(again.trajectories["A"].xyz, open_editing(source).trajectories["A"].xyz)


def test_an_edit_is_not_lost_when_the_one_before_it_on_the_same_frames_is_taken_back(tmp_path):
    made = paths_without_images(frames=60)
    paths = [path.xyz.copy() for path in made]
    paths[0][29:32] += 100.0
    named = (MarkerTrajectory.measured(name, xyz) for name, xyz in zip("ABCD", paths, strict=True))
    write_c3d(tmp_path / "walk.c3d", Trial("walk", replace(made, paths=tuple(named))))
    editing = Editing.of_file(tmp_path / "walk.c3d")
    editing.smooth("A", 20, 40, 5.0)  # which moves the spike by more than 30 mm
    editing.erase("A", 30, 32)
    editing.journal.undo(1)
    assert [one.outcome for one in editing.edited().applied] == ["held"]
    editing.journal.redo()
    assert [one.outcome for one in editing.edited().applied] == ["held", "held"]


def test_a_trim_holds_though_all_samples_at_its_ends_were_put_by_hand(tmp_path):
    given = paths_without_images(n=1, frames=60)
    path = replace(given.paths[0], name="A")
    write_c3d(tmp_path / "walk.c3d", Trial("walk", replace(given, paths=(path,))))
    editing = Editing.of_file(tmp_path / "walk.c3d")
    for frame in (1, 2, 59, 60):
        editing.put("A", frame, path.xyz[frame - 1] + 100.0)
    editing.trim(1, 60)
    assert {one.outcome for one in editing.edited().applied} == {"held"}


def test_a_marker_that_was_given_another_name_leaves_no_empty_one(tmp_path):
    source, made = tmp_path / "walk.c3d", paths_without_images(frames=60)
    names = ("LKNE", "RKNE", "LANK", "RANK")
    paths = [replace(path, name=name) for path, name in zip(made, names, strict=False)]
    empty = MarkerTrajectory.measured("LHEE", np.full((60, 3), np.nan))
    write_c3d(source, Trial("walk", replace(made, paths=(*paths, empty))))
    Editing.of_file(source).claim("LKNE", "LKNX")
    write_edited(open_editing(source), tmp_path / "done.c3d")
    done = read_c3d(tmp_path / "done.c3d").trajectories
    assert {"LKNX", "LHEE"} <= set(done.names) and "LKNE" not in done.names  # one empty in the file itself stays
    assert np.array_equal(done["LKNX"].xyz, read_c3d(source).trajectories["LKNE"].xyz)


def test_two_clicked_images_are_a_place(session):
    editing = open_editing(session)
    editing.claim("*2", "A")
    path = editing.edited().trajectories["A"]
    row = path.detection[9]
    images = {name: tuple(editing.detections.uv[row[c]]) for c, name in enumerate(editing.rig.names) if row[c] >= 0}
    editing.put_in_images("A", 10, dict(list(images.items())[:2]))
    assert np.linalg.norm(editing.edited().trajectories["A"].xyz[9] - path.xyz[9]) < 2.0
    with pytest.raises(KinemarkError, match="two of the cameras"):
        editing.put_in_images("A", 10, {"cam1": (1.0, 2.0)})


def test_mistakes_are_said_in_words_and_leave_nothing_behind(session, tmp_path):
    editing = open_editing(session)
    wrong = {
        "no marker": lambda: editing.claim("*77", "A"),
        "no name of a marker": lambda: editing.claim("*1", "*2"),
        "no sample": lambda: editing.claim("*1", "A", first=500, last=600),
        "number of a track": lambda: editing.erase("*1", 1, 2),
        "There is no marker B": lambda: editing.erase("B", 1, 2),
        "nothing would be left": lambda: editing.finish(),
        "neither a file": lambda: open_editing(tmp_path / "no" / "where"),
        "no trial two": lambda: open_editing(session / "two"),
        "There is no entry": lambda: editing.journal.undo(3),
    }
    for words, act in wrong.items():
        with pytest.raises(KinemarkError, match=words):
            act()
    editing.claim("*1", "A")
    with pytest.raises(KinemarkError, match="no method of filling"):
        editing.gap("A", 1, 2, "magic")
    with pytest.raises(KinemarkError, match="no stretch"):
        editing.erase("A", 3, 2)
    assert len(editing.journal.entries) == 1


def test_a_stray_sample_with_a_name_does_not_cut_the_trial_to_nothing(session):
    editing = open_editing(session)
    editing.claim("*1", "A")
    path = editing.edited().trajectories["A"]
    seen = np.flatnonzero(path.origin != Origin.MISSING) + 1
    editing.claim("*2", "B", first=int(seen[5]), last=int(seen[5]))
    with pytest.raises(KinemarkError, match="B is seen in few"):
        editing.finish()
    assert editing.finish(first=int(seen[5]), last=int(seen[5])), "said, it is done"


def test_signing_changes_no_result_and_holds_the_head(session):
    editing = open_editing(session)
    editing.claim("*1", "A")
    trial = Session.open(session).trial("one").run("edit")
    head = editing.journal.head
    assert editing.sign().edits[0].head == head and trial.state()["edit"]


def test_reviewed_decisions_are_not_asked_again():
    asked = [
        AmbiguousDecision("swap", 10, 12, (0, 1), "came_near"),
        AmbiguousDecision("swap", 50, 52, (0, 1), "came_near"),
        AmbiguousDecision("ghost", 10, 12, (0,), "little_evidence"),
    ]
    edited = Edited(paths_without_images(), reviewed=(Reviewed("swap", 8, 14, (0, 1), True),))
    assert unreviewed(asked, edited) == tuple(asked[1:])


def test_a_verdict_and_a_corrected_image_are_said_of_what_is_there(session):
    editing = open_editing(session)
    asked = AmbiguousDecision("swap", 8, 10, (0, 2), "came_near")
    editing = replace(editing, decisions=(asked,))
    said = editing.review(1, right=True)
    assert [one.outcome for one in said.applied] == ["held"] and unreviewed([asked], editing.edited()) == ()
    with pytest.raises(KinemarkError, match="no decision 2"):
        editing.review(2, right=False)
    editing.claim("*1", "A")
    before = editing.edited().trajectories["A"]
    u, v = editing.detections.uv[before.detection[9].max()].tolist()
    name = editing.rig.names[int(before.detection[9].argmax())]
    assert editing.image(name, 10, u + 20, v, "A").applied[0].outcome == "held"
    assert np.linalg.norm(editing.edited().trajectories["A"].xyz[9] - before.xyz[9]) > 1.0


def test_the_command_line_says_lists_checks_and_undoes(session, capsys):
    from kinemark.apps.cli import app

    def call(*words):
        with pytest.raises(SystemExit) as done:
            app(["edits", *words])
        return done.value.code, capsys.readouterr().out

    trial = str(session / "one")
    assert call("claim", trial, "--track", "*1", "--name", "LKNE", "--frames", "2-15", "--json")[0] == 0
    assert call("erase", trial, "LKNE", "--frames", "4-6")[0] == 0
    said = json.loads(call("list", trial, "--json")[1])
    assert [row["counts"] for row in said] == [True, True] and "LKNE" in said[0]["text"][0]
    assert [row["outcome"] for row in json.loads(call("check", trial, "--json")[1])["applied"]] == ["held", "held"]
    assert "witness" in call("show", trial, "1")[1] and "undone" in call("undo", trial)[1]
    assert "(undone)" in call("list", trial)[1]
    call("redo", trial)
    assert [row["counts"] for row in json.loads(call("list", trial, "--json")[1])] == [True, True, False, True]
    with pytest.raises(KinemarkError, match="standard deviations"):
        app(["edits", "claim", trial, "--track", "*2", "--name", "LKNE"])


def test_a_cut_off_that_the_rate_does_not_hold_is_refused(tmp_path):
    write_c3d(tmp_path / "walk.c3d", Trial("walk", paths_without_images(frames=60)))
    editing = Editing.of_file(tmp_path / "walk.c3d")
    editing.claim("*1", "A")
    with pytest.raises(KinemarkError, match=r"cut-off is 600 Hz, and .* frames a second show nothing above .* below"):
        editing.smooth("A", 10, 40, 600.0)
    assert len(editing.journal.entries) == 1
