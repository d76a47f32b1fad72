"""A stretch of one path with many steps is one problem, which one act settles; each step is judged by itself."""

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory
from kinemark.data.edits import Claim, Verdict
from kinemark.engine.audit import audit_file
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.problems import problems
from kinemark.io.trc import write_trc
from support.walked import clean, spiked, trajectories, walk

P = 6
SLOTS = (2, 60, 150), (9, 152, 240), (15, 242, 330)
"""Marker, first frame and last-plus-one."""


def editing_of(trial, folder):
    return Editing("walk", Journal.of(folder, "walk"), trial, by="EG")


def slotted():
    """The walk without three of its markers, and a track without a name that holds them one after the other."""
    names, xyz = walk()
    slot, rest = np.full(xyz.shape[1:], np.nan), [k for k in range(len(names)) if k not in [m for m, _, _ in SLOTS]]
    for marker, start, stop in SLOTS:
        slot[start:stop] = xyz[marker, start:stop]
    return trajectories(np.concatenate([xyz[rest], slot[None]]), (*(names[k] for k in rest), "*7"))


def test_what_is_many_points_in_one_track_is_one_problem_that_cuts_it_into_them(tmp_path):
    editing = editing_of(slotted(), tmp_path)
    single = [one for one in problems(editing, one_by_one=True).asked if one.tracks == ("*7",)]
    (one,) = (one for one in problems(editing).asked if one.tracks == ("*7",))
    assert len(single) == 2 and one.words == "*7 jumps at 2 places, frames 150–243" and one.values["places"] == 2
    assert problems(editing).errors == pytest.approx(problems(editing, one_by_one=True).errors)
    assert one.wrong == max(each.wrong for each in single) and one.cost == sum(each.cost for each in single)
    best = one.alternatives[0]
    assert (best.action, best.words) == ("mend", "cut *7 at frames 153, 243")
    editing.say(*best.edits)
    now, names = editing.edited().trajectories, ("*7", "track7_153", "track7_243")
    for name, (marker, start, stop) in zip(names, SLOTS, strict=True):
        path = now[name].xyz
        assert np.isfinite(path[:, 0]).sum() == stop - start
        assert np.array_equal(path[start:stop], walk()[1][marker, start:stop])
    assert not [one for one in problems(editing).asked if "7" in one.tracks[0] and one.wrong > 0.5]


def test_steps_of_a_marker_are_together_within_a_second_and_right_as_they_are_settles_all(tmp_path):
    trial = spiked(spiked(spiked(clean(), P, 100, 103), P, 160, 162), P, 300, 303)
    editing, name = editing_of(trial, tmp_path), clean().names[P]
    both, alone = sorted(problems(editing).asked, key=lambda one: one.first)
    assert (both.first, both.last, both.at_stake) == (101, 162, 5) and alone.kind == "spike" and alone.first == 301
    mend, keep = both.alternatives
    assert (mend.words, keep.words) == ("erase 5 samples", "right as it is")
    assert all(isinstance(edit, Verdict) and edit.right for edit in keep.edits)
    editing.say(*keep.edits)
    assert [one.id for one in problems(editing).asked] == [alone.id]
    editing.journal.undo()
    editing.say(*mend.edits)
    assert np.flatnonzero(np.isnan(editing.edited().trajectories[name].xyz[:, 0])).tolist() == [100, 101, 102, 160, 161]


def test_what_is_erased_after_a_cut_is_of_the_piece_that_begins_there(tmp_path):
    xyz = clean().xyz.copy()
    away = np.zeros(xyz.shape[1])
    away[149:] = 0.3, 0.8, *np.ones(xyz.shape[1] - 151)
    xyz[P] += away[:, None] * [0.0, 90.0, 30.0]
    xyz[P, 230:233] += [60.0, 0.0, 0.0]
    editing, name = editing_of(trajectories(xyz, clean().names), tmp_path), clean().names[P]
    (one,) = (one for one in problems(editing).asked if one.tracks == (name,))
    assert one.alternatives[0].words == f"erase 3 samples and cut {name} at frame 152"
    said = editing.say(*one.alternatives[0].edits)
    assert {each.outcome for each in said.applied} == {"held"}
    rest = editing.edited().trajectories[
        next(edit.name for edit in one.alternatives[0].edits if isinstance(edit, Claim))
    ]
    assert np.flatnonzero(np.isfinite(rest.xyz[:, 0])).tolist() == [*range(151, 230), *range(233, 400)]


def test_what_is_not_sure_is_not_mended_with_what_is(tmp_path):
    """An audit mends each step by its own probability, though the list has them as one."""
    source = tmp_path / "walk.trc"
    write_trc(source, spiked(spiked(clean(), P, 100, 103), P, 140, 141, mm=15.0))
    unsure = [one for one in audit_file(source).found.asked if one.tracks == (clean().names[P],)]
    assert len(unsure) == 1 and unsure[0].values["places"] == 2
    done = audit_file(source, mend=True)
    assert [(one.first, one.last) for one in done.mended] == [(101, 103)]


def test_what_is_rather_right_is_asked_for_itself_and_counts_among_the_errors(tmp_path):
    """Who erases the spike says nothing of the step 0.4 s later, which is hardly one, and is asked about it."""
    editing = editing_of(spiked(spiked(clean(), P, 100, 103), P, 140, 141, mm=9.0), tmp_path)
    sure, unsure = (one for one in problems(editing).asked if one.tracks == (clean().names[P],))
    assert (sure.kind, sure.first, sure.last) == ("spike", 101, 103) and sure.wrong > 0.9
    assert unsure.first >= 140 and 0.05 < unsure.wrong < 0.5
    editing.say(*sure.alternatives[0].edits)
    assert [one.first for one in problems(editing).asked if one.tracks == (clean().names[P],)] == [unsure.first]


@pytest.mark.parametrize("marker", [0, 3])
def test_one_step_stays_what_it_is(tmp_path, marker):
    (one,) = problems(editing_of(spiked(clean(), marker, 100, 103), tmp_path)).asked
    assert one.kind == "spike" and "places" not in one.values


def test_a_path_without_samples_beside_one_with_steps_changes_nothing(tmp_path):
    trial = spiked(clean(), P, 100, 103)
    empty = MarkerTrajectory.measured("extra", np.full((trial.n_frames, 3), np.nan))
    more = trajectories(np.concatenate([trial.xyz, empty.xyz[None]]), (*trial.names, "extra"))
    assert [one.words for one in problems(editing_of(more, tmp_path)).asked] == [
        one.words for one in problems(editing_of(trial, tmp_path / "other")).asked
    ]


def loose(pieces=6, frames=4, apart=30):
    """The walk, and short pieces without a name that come one after another a hand's breadth apart."""
    names, xyz = walk()
    more = np.full((pieces, *xyz.shape[1:]), np.nan)
    for k in range(pieces):
        at = slice(40 + k * apart, 40 + k * apart + frames)
        more[k, at] = [2000.0, 500.0 + 60.0 * k, 900.0]
    return trajectories(np.concatenate([xyz, more]), (*names, *(f"*{40 + k}" for k in range(pieces))))


def test_loose_pieces_one_after_another_are_one_problem_that_is_settled_at_once(tmp_path):
    editing = editing_of(loose(), tmp_path)
    single = [one for one in problems(editing, one_by_one=True).asked if one.tracks[0].startswith("*")]
    assert len(single) >= 3 and all(len(one.tracks) == 2 and one.wrong < 0.5 for one in single)
    (one,) = (one for one in problems(editing).asked if one.tracks[0].startswith("*"))
    assert set(one.tracks) == {name for each in single for name in each.tracks}
    assert problems(editing).errors == pytest.approx(problems(editing, one_by_one=True).errors)
    keep, join = one.alternatives
    assert (keep.action, join.action) == ("keep", "join") and one.cost == sum(each.cost for each in single)
    editing.say(*keep.edits)
    assert not [one for one in problems(editing).asked if one.tracks[0].startswith("*")]
    editing.journal.undo()
    editing.say(*join.edits)
    joined = [
        path for path in editing.edited().trajectories if np.isfinite(path.xyz[:, 0]).sum() == 4 * len(one.tracks)
    ]
    assert len(joined) == 1


def test_that_a_piece_is_not_the_one_before_says_nothing_of_the_one_after(tmp_path):
    editing = editing_of(loose(pieces=3), tmp_path)
    before, after = (one for one in problems(editing).asked if one.tracks[0].startswith("*"))
    editing.say(*next(way for way in before.alternatives if way.action == "keep").edits)
    assert [one.id for one in problems(editing).asked if one.tracks[0].startswith("*")] == [after.id]


def test_that_two_pieces_are_one_marker_says_nothing_of_the_piece_after_them(tmp_path):
    editing = editing_of(loose(pieces=3), tmp_path)
    before, after = (one for one in problems(editing).asked if one.tracks[0].startswith("*"))
    editing.say(*next(way for way in before.alternatives if way.action == "join").edits)
    (left,) = (one for one in problems(editing).asked if after.tracks[1] in one.tracks)
    assert len(left.tracks) == 2 and (left.first, left.last) == (after.first, after.last)
