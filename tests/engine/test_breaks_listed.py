"""What happened to all markers at once is one problem, with what mends it or that nothing does, and hides no other."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data.problems import OF_WHOLE
from kinemark.engine.audit import audit_file
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.problems import problems
from kinemark.io.trc import write_trc
from support.walked import clean, exchanged, nearest, spiked, trajectories, walk

F, P, AT = 150, 9, 260


def lost(xyz):
    return np.delete(xyz, slice(F + 1, F + 4), axis=1)


def held(xyz):
    out = xyz.copy()
    out[:, F + 1 : F + 4] = out[:, F : F + 1]
    return out


def doubled(xyz):
    return np.concatenate([xyz[:, : F + 1], np.repeat(xyz[:, F : F + 1], 3, axis=1), xyz[:, F + 1 :]], axis=1)


def moved(xyz, stop=None):
    out = xyz.copy()
    turn = Rotation.from_rotvec(np.radians([0.6, 0.0, 0.8])).as_matrix()
    out[:, F + 1 : stop] = out[:, F + 1 : stop] @ turn.T + np.array([30.0, -15.0, 8.0])
    return out


def shaken(xyz):
    return moved(xyz, F + 4)


CAUSES = {
    lost: ("lost", "note", "skip 3 frames between frames 151 and 152"),
    held: ("repeated", "erase", "repeat frame 151 in frames 152–154"),
    doubled: ("repeated", "erase", "what follows is 3 frames late"),
    moved: ("moved", "note", "jump as one body between frames 151 and 152"),
    shaken: ("shaken", "erase", "stand off as one body in frames 152–154"),
}


def editing_of(xyz, folder):
    return Editing("walk", Journal.of(folder, "walk"), trajectories(xyz, clean().names), by="EG")


def asked(editing):
    return problems(editing).asked


@pytest.mark.parametrize("make", CAUSES)
def test_a_cause_is_one_problem_in_words_and_is_settled_by_its_best_alternative(tmp_path, make):
    editing, (kind, action, words) = editing_of(make(clean().xyz), tmp_path), CAUSES[make]
    (one,) = asked(editing)
    assert one.kind == kind and one.wrong > 0.9 and words in one.words and len(one.tracks) == len(clean())
    assert one.frame == F + 2  # the first that is wrong, or that is elsewhere
    best = one.alternatives[0]
    assert best.action == action and sum(way.probability for way in one.alternatives) == pytest.approx(1)
    editing.say(*best.edits)
    assert not asked(editing)
    gone = np.isnan(editing.edited().trajectories.xyz).any(2)
    assert gone.sum() == (3 * len(clean()) if action == "erase" else 0)


@pytest.mark.parametrize("make", CAUSES)
def test_what_single_markers_do_is_listed_besides_in_the_frames_that_the_file_has(tmp_path, make):
    trial = spiked(exchanged(clean(), P, nearest(walk()[1], P, AT), AT), 6, 120, 123)
    shift = {lost: -3, doubled: 3}.get(make, 0)
    own = [one for one in asked(editing_of(make(trial.xyz), tmp_path)) if one.kind not in OF_WHOLE and one.wrong > 0.5]
    assert {(one.kind, one.first, one.last) for one in own} == {
        ("spike", 121, 123),
        ("swap", AT + shift, AT + shift + 1),
    }


def test_a_cause_that_somebody_denied_is_not_asked_again_and_undo_brings_it_back(tmp_path):
    editing = editing_of(moved(clean().xyz), tmp_path)
    (one,) = asked(editing)
    editing.say(*next(way for way in one.alternatives if way.action == "keep").edits)
    assert not asked(editing)
    editing.journal.undo()
    assert [again.id for again in asked(editing)] == [one.id]


def test_an_audit_mends_repeated_frames_and_notes_nothing_by_itself(tmp_path):
    both = lost(clean().xyz)
    both[:, 301:303] = both[:, 300:301]
    write_trc(tmp_path / "walk.trc", trajectories(both, clean().names))
    done = audit_file(tmp_path / "walk.trc", mend=True)
    assert [one.kind for one in done.mended] == ["repeated"] and [one.kind for one in done.found.asked] == ["lost"]


def test_what_a_system_does_all_the_time_is_one_problem(tmp_path):
    xyz = clean().xyz
    for f in range(40, 360, 40):
        xyz[:, f + 1] = xyz[:, f]
    editing = editing_of(xyz, tmp_path)
    (one,) = asked(editing)
    assert "repeat the frame before at 8 places, 8 frames in all, first in frame 42" in one.words
    editing.say(*one.alternatives[0].edits)
    assert np.isnan(editing.edited().trajectories.xyz).any(2).sum() == 8 * len(clean()) and not asked(editing)
    (one,) = asked(editing_of(np.delete(clean().xyz, [60, 120, 121, 200, 300], axis=1), tmp_path / "lost"))
    assert "skip frames at 4 places, 5 frames in all, first between frames 60 and 61" in one.words


def test_where_nothing_moves_in_the_whole_trial_nobody_tells_that_frames_repeat(tmp_path):
    assert not asked(editing_of(np.repeat(clean().xyz[:, 100:101], 200, axis=1), tmp_path))


@pytest.mark.parametrize("make", [lost, held, shaken])
def test_what_is_not_worth_a_look_beside_a_cause_is_looked_at_with_it(tmp_path, make):
    """Else the list has it once for every marker, below the line, and expects errors of it."""
    found = problems(editing_of(make(clean().xyz), tmp_path))
    beside = [one for one in found.items if one.kind not in OF_WHOLE and one.first <= F + 20 and one.last >= F - 20]
    assert not beside and found.errors_left < 0.1
