"""Problems of a trial: what is seeded is listed, alternatives mend it, and what was decided is not asked again."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from kinemark import KinemarkError
from kinemark.apps.cli import app
from kinemark.data import MarkerTrajectory, Origin, Trajectories, Trial
from kinemark.data.edits import Claim, Erase, Verdict
from kinemark.data.problems import ASK_ABOVE, OF_IDENTITY
from kinemark.edit import Renamed, difference
from kinemark.engine.audit import audit_file, audit_files
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.files import open_editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.problems import filled_gaps, problems
from kinemark.fill import Linear, fill
from kinemark.io.c3d import read_c3d, write_c3d
from kinemark.io.trial import read_trial
from kinemark.label import computed_points
from support.computed import computed, walker, with_computed
from support.edited import scene
from support.shared import shared_data
from support.walked import clean, every, exchanged, nearest, spiked, walk, with_xyz, without

P, AT = 9, 200


def faulty():
    """An exchange of neighbours from frame AT on, and a spike."""
    return spiked(exchanged(clean(), P, nearest(walk()[1], P, AT), AT), 6, 100, 103)


def editing_of(trajectories, folder, **more):
    return Editing("walk", Journal.of(folder, "walk"), trajectories, by="EG", **more)


def asked(editing, above=0.5):
    return [one for one in problems(editing).asked if one.wrong > above]


def test_what_is_seeded_is_listed_in_the_order_of_its_cost_and_nothing_else_is_likely(tmp_path):
    assert not asked(editing_of(clean(), tmp_path))
    whole = faulty()
    pair = {whole.names[P], whole.names[nearest(walk()[1], P, AT)]}
    found = asked(editing_of(whole, tmp_path))
    assert [one.kind for one in found] == ["swap", "spike"] and found[0].cost > found[1].cost
    assert set(found[0].tracks) == pair and found[0].frame == AT + 1
    assert (found[1].first, found[1].last, found[1].at_stake) == (101, 103, 3)
    assert all(sum(way.probability for way in one.alternatives) == pytest.approx(1) for one in found)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_an_exchange_there_and_back_is_settled_in_either_order(order, tmp_path):
    """The later one first, the earlier claimed two joined markers as one, and some samples beside the joint stayed."""
    trial, q = clean(), nearest(walk()[1], P, AT)
    editing = editing_of(exchanged(exchanged(trial, P, q, AT), P, q, AT + 40), tmp_path)
    for k in order:
        one = next(one for one in asked(editing) if one.kind == "swap" and one.frame == AT + 1 + 40 * k)
        editing.say(*one.alternatives[0].edits)
    assert not asked(editing)
    now = editing.edited().trajectories
    assert all(np.array_equal(now[path.name].xyz, path.xyz) for path in trial)


def test_what_was_mended_hides_no_other_fault_shortly_before_it(tmp_path):
    """Two markers are exchanged for 0.18 s: once their way back was settled, the way there was not asked about."""
    trial = replace(clean(), rate=200.0)
    q = nearest(walk()[1], P, AT)
    editing = editing_of(exchanged(exchanged(trial, P, q, AT), P, q, AT + 36), tmp_path)
    for _ in range(2):
        editing.say(*asked(editing)[0].alternatives[0].edits)
    assert not asked(editing)
    now = editing.edited().trajectories
    assert all(np.array_equal(now[path.name].xyz, path.xyz) for path in trial)


def test_what_is_not_worth_a_look_is_listed_once(tmp_path):
    """A step, a spike and a gap's edge of one stretch counted as three among the errors that are expected."""
    trial, rng = every(clean(), 4), np.random.default_rng(1)
    for p in range(8):
        for f in rng.integers(8, trial.n_frames - 14, 3).tolist():
            stop = f + int(rng.integers(1, 6))
            trial = spiked(trial, p, f, stop, mm=float(rng.uniform(3, 12)))
            if rng.random() < 0.6:
                trial = without(trial, p, stop, stop + int(rng.integers(2, 9)))
    found = problems(editing_of(trial, tmp_path), one_by_one=True).items
    few = [one for one in found if not one.asked and one.kind in ("spike", "join") and len(one.tracks) == 1]
    near, pairs = 0.2 * trial.rate, [(a, b) for k, a in enumerate(few) for b in few[:k] if a.tracks == b.tracks]
    assert len(few) > 10 and not [1 for a, b in pairs if a.first - near <= b.last and b.first <= a.last + near]


def test_taking_the_best_alternatives_gives_the_trial_back(tmp_path):
    editing = editing_of(faulty(), tmp_path)
    for _ in range(2):
        editing.say(*asked(editing)[0].alternatives[0].edits)
    found = difference(clean(), editing.edited().trajectories)
    assert not found.renamed and [(one.marker, one.what, one.samples) for one in found.changed] == [
        (faulty().names[6], "erased", 3)
    ]
    assert not asked(editing)


@pytest.mark.parametrize(("stop", "action"), [(None, "cut"), (215, "erase")])
def test_a_leap_is_one_problem_and_its_best_alternative_leaves_only_right_samples(tmp_path, stop, action):
    xyz = clean().paths[6].xyz.copy()
    away = np.zeros(len(xyz))
    away[200:stop] = 1.0
    away[199:201] = 0.3, 0.8
    xyz += away[:, None] * [0.0, 90.0, 30.0]
    editing = editing_of(with_xyz(clean(), {6: xyz}), tmp_path)
    (one,) = problems(editing).asked
    assert (one.kind, one.tracks) == ("join", (clean().names[6],)) and one.first <= 200 < one.last
    best = one.alternatives[0]
    assert best.action == action
    editing.say(*best.edits)
    left = editing.edited().trajectories[clean().names[6]].xyz
    off = np.linalg.norm(left - clean().paths[6].xyz, axis=1)
    assert np.nanmax(off) < 1e-9 and np.isfinite(off).sum() >= (199 if stop is None else len(xyz) - 20)
    assert not asked(editing, 0.05)


@pytest.mark.parametrize("held", [True, False])
def test_samples_that_nobody_measured_are_one_problem_and_are_erased(tmp_path, held):
    """Not the leap with which a path that stood still comes back: it is the same marker."""
    xyz = clean().paths[6].xyz.copy()
    share = np.zeros(50) if held else np.linspace(0, 1, 52)[1:-1]
    xyz[150:200] = xyz[149] + share[:, None] * (xyz[200] - xyz[149])
    editing = editing_of(with_xyz(clean(), {6: xyz}), tmp_path)
    (one,) = problems(editing).asked
    assert (one.kind, one.tracks, one.first, one.last) == ("filled", (clean().names[6],), 151, 200)
    assert one.wrong > 0.9 and one.alternatives[0].action == "erase" and one.kind in OF_IDENTITY
    editing.say(*one.alternatives[0].edits)
    left = editing.edited().trajectories[clean().names[6]].xyz
    assert np.isnan(left[150:200]).all() and np.isfinite(left).all(1).sum() == len(left) - 50
    assert not asked(editing, 0.05)


def test_what_was_filled_is_not_asked_again_where_somebody_kept_it(tmp_path):
    xyz = clean().paths[6].xyz.copy()
    xyz[150:200] = xyz[149]
    editing = editing_of(with_xyz(clean(), {6: xyz}), tmp_path)
    (one,) = problems(editing).asked
    editing.say(*next(way for way in one.alternatives if way.action == "keep").edits)
    assert "filled" not in {other.kind for other in problems(editing).items}


def test_a_verdict_takes_a_problem_away_and_undo_brings_it_back_with_its_id(tmp_path):
    editing = editing_of(faulty(), tmp_path)
    one = asked(editing)[0]
    keep = next(way for way in one.alternatives if way.action == "keep")
    assert isinstance(keep.edits[0], Verdict) and keep.edits[0].right
    editing.say(*keep.edits)
    assert one.id not in {other.id for other in problems(editing).items}
    editing.journal.undo()
    assert one.id in {other.id for other in problems(editing).items}


def test_verdicts_and_ids_hold_when_samples_are_a_little_elsewhere(tmp_path):
    whole = faulty()
    one = asked(editing_of(whole, tmp_path))[0]
    noise = np.random.default_rng(5).normal(0, 0.3, (whole.n_frames, 3))
    moved = replace(whole, paths=tuple(replace(path, xyz=path.xyz + noise) for path in whole))
    again = editing_of(moved, tmp_path)
    assert one.id in {other.id for other in problems(again).items}
    again.say(*next(way for way in one.alternatives if way.action == "keep").edits)
    assert one.id not in {other.id for other in problems(again).items}


def test_errors_left_are_those_below_the_stop_rule(tmp_path):
    found = problems(editing_of(faulty(), tmp_path))
    below = [one.wrong for one in found.items if one.kind in OF_IDENTITY and one.wrong < ASK_ABOVE]
    assert found.errors_left == pytest.approx(sum(below)) and 1.5 < found.errors < 3.5 and found.errors_left < 0.5


def test_tracks_without_names_are_exchanged_under_names_of_their_own(tmp_path):
    whole = faulty()
    bare = replace(whole, paths=tuple(replace(path, name=f"*{k + 1}") for k, path in enumerate(whole)))
    editing = editing_of(bare, tmp_path)
    one = asked(editing)[0]
    editing.say(*next(way for way in one.alternatives if way.action == "exchange").edits)
    q = nearest(walk()[1], P, AT)
    now = editing.edited().trajectories
    for k in (P, q):
        assert np.array_equal(now[f"track{k + 1}"].xyz, clean().paths[k].xyz)


def test_gaps_are_problems_with_ways_to_fill_until_somebody_chose(tmp_path):
    editing = editing_of(without(clean(), 5, 150, 171), tmp_path)
    one = next(p for p in problems(editing, gaps=filled_gaps(editing)).items if p.kind == "gap")
    assert (one.first, one.last, one.at_stake) == (151, 171, 21) and one.alternatives[0].action == "fill"
    editing.say(*one.alternatives[0].edits)
    assert not [p for p in problems(editing, gaps=filled_gaps(editing)).items if p.kind == "gap"]


def test_no_way_to_fill_promises_less_than_samples_in_doubt_beside_the_gap_leave(tmp_path):
    """Hold-out gaps have good samples beside them: by these the worst way was proposed, a tenth as far off as it is."""
    walk = clean(markers=12).frames(0, 200)
    three = replace(walk, paths=walk.paths[3:6])  # nothing but its own motion tells of the sample
    editing = editing_of(without(without(spiked(three, 2, 99, 100, mm=35.0), 2, 100, 106), 0, 60, 80), tmp_path)
    gaps = filled_gaps(editing)
    (gap,) = (gap for gap in gaps if gap.suspicious)
    (one,) = (p for p in problems(editing, gaps=gaps).items if p.kind == "gap" and p.first == gap.start + 1)
    assert gap.suspicious == (99,) and min(gap.candidates.values()) < 0.7 * gap.expected_mm
    fills = [way for way in one.alternatives if way.action == "fill"]
    assert len(fills) > 1 and all(way.jump_mm >= gap.expected_mm for way in fills)
    assert fills[0].edits[0].method == "best"


def test_gaps_of_most_markers_in_the_same_frames_are_one_problem(tmp_path):
    """As after samples of all were erased; those of a few markers stay problems of their own."""
    whole = clean().frames(0, 250)
    few, all_of_them = whole, whole
    for k in range(len(whole)):
        all_of_them = without(all_of_them, k, 150, 155)
        few = without(few, k, 150, 155) if k < 3 else few
    editing = editing_of(without(all_of_them, 5, 60, 70), tmp_path)
    gaps = fill(editing.trajectories, method=Linear()).gaps
    found = [p for p in problems(editing, gaps=gaps).items if p.kind == "gap"]
    assert sorted((p.first, p.last, len(p.tracks)) for p in found) == [(61, 70, 1), (151, 155, len(whole))]
    one = next(p for p in found if len(p.tracks) > 1)
    assert one.words.startswith(f"{len(whole)} markers have a gap, frames 151–155") and one.at_stake == 5 * len(whole)
    assert [way.action for way in one.alternatives] == ["fill", "leave_open"]
    editing.say(*one.alternatives[0].edits)
    assert [p.first for p in problems(editing, gaps=gaps).items if p.kind == "gap"] == [61]
    (tmp_path / "few").mkdir()
    editing = editing_of(few, tmp_path / "few")
    assert sum(p.kind == "gap" for p in problems(editing, gaps=fill(few, method=Linear()).gaps).items) == 3


def test_what_lies_in_a_gap_that_is_too_long_for_motion_to_tell_has_no_distance(tmp_path):
    """A motion that is carried on for seconds leads anywhere: 6923 mm in a recording of a wheelchair."""
    editing = editing_of(without(clean(), 5, 60, 350), tmp_path)
    (one,) = (p for p in problems(editing).items if p.first == 60 and p.last == 351)
    assert one.words.endswith("frames 60–351; the gap is too long for motion to tell"), one.words
    assert [way.words for way in one.alternatives if way.action == "keep"] == ["right as it is"]
    (tmp_path / "short").mkdir()
    editing = editing_of(without(clean(), 5, 120, 130), tmp_path / "short")
    assert not any("too long" in p.words for p in problems(editing).items)


def test_edits_that_find_no_place_come_first(tmp_path):
    editing = editing_of(clean(), tmp_path)
    editing.journal.append([Erase("NOBODY", 5, 9)])
    one = problems(editing).items[0]
    assert one.kind == "edit" and "NOBODY" in one.words
    editing.say(*one.alternatives[0].edits)
    assert not [p for p in problems(editing).items if p.kind == "edit"]


def test_a_preview_is_what_saying_it_gives_and_writes_nothing(tmp_path):
    editing = editing_of(clean(), tmp_path)
    edit = Erase(editing.trajectories.names[0], 10, 20)
    seen = editing.preview([edit])
    assert not editing.journal.path.exists() and seen.applied[0].outcome == "held"
    editing.say(edit)
    assert not difference(seen.trajectories, editing.edited().trajectories)


def test_earlier_versions_are_there_by_the_head_of_the_journal(tmp_path):
    editing = editing_of(clean(), tmp_path)
    name = editing.trajectories.names[0]
    heads = [editing.journal.head]
    for claimed in ("A", "B"):
        editing.claim(name if claimed == "A" else "A", claimed)
        heads.append(editing.journal.head)
    editing.journal.undo()
    assert [editing.at(head).trajectories.names[0] for head in heads] == [name, "A", "B"]
    assert editing.edited().trajectories.names[0] == "A"
    frames = (1, editing.trajectories.n_frames, editing.trajectories.n_frames)
    between = difference(editing.at(heads[1]).trajectories, editing.at(heads[2]).trajectories)
    assert between.renamed == (Renamed("A", "B", *frames),)
    with pytest.raises(KinemarkError, match="no line with the hash"):
        editing.at("0" * 64)


def test_the_trackers_own_decisions_are_judged_with_their_images(tmp_path):
    rig, detections, tracked, _ = scene()
    found = problems(editing_of(tracked, tmp_path, detections=detections, rig=rig))
    assert not found.asked


def test_an_audited_file_is_mended_in_its_journal_and_not_itself(tmp_path):
    source = tmp_path / "walk.c3d"
    write_c3d(source, Trial("walk", faulty()))
    before = source.read_bytes()
    assert {one.kind for one in audit_file(source).found.asked} >= {"swap", "spike"}
    assert not (tmp_path / "edits").exists()
    done = audit_file(source, mend=True)
    assert {one.kind for one in done.mended} == {"swap", "spike"} and source.read_bytes() == before
    entries = Journal.of(tmp_path, "walk").entries
    assert all(entry.why.startswith("kinemark audit: ") for entry in entries)
    assert {type(edit) for entry in entries for edit in entry.edits} == {Claim, Erase, Verdict}
    app(["edits", "apply", str(source), "-o", str(tmp_path / "done.c3d")], result_action="return_value")
    written = read_c3d(tmp_path / "done.c3d").trajectories.select(clean().names)
    assert (written.paths[6].origin == Origin.MISSING).sum() == 3
    off = np.linalg.norm(written.xyz - clean().xyz, axis=-1)
    assert np.nanmax(off) < 0.1


def test_what_a_program_computed_of_markers_is_not_looked_at_and_this_is_said(tmp_path, capsys):
    """The spike is in a frame that the search for computed points does not look at."""
    whole = with_computed(walker(duration_s=4.0))
    numbers = [whole.names.index(name) for name in ("RTIA", "LFEO", "LTHI")]
    for p in numbers:
        whole = spiked(whole, p, 105, 108)
    source = tmp_path / "walk.c3d"
    write_c3d(source, Trial("walk", whole))
    done = audit_file(source)
    assert set(done.aside) == set(computed(walker(duration_s=4.0)))
    assert {name for one in done.found.asked for name in one.tracks} == {whole.names[numbers[-1]]}
    with pytest.raises(SystemExit):
        app(["audit", str(source)], result_action="return_value")
    assert f"not looked at: {len(done.aside)} points that were computed" in capsys.readouterr().out


def test_leaps_of_rough_tracks_of_another_system_lie_in_problems_worth_a_look(tmp_path):
    source = tmp_path / "gait9.tdf"
    shutil.copy(shared_data("cameras/gait9_bts/gait9.tdf"), source)
    tracks, editing = read_trial(source).trajectories, open_editing(source)
    asked = problems(editing, one_by_one=True).asked
    leaps = [
        (path.name, int(k) + tracks.first_frame)
        for path in tracks
        for k in np.flatnonzero(np.linalg.norm(np.diff(path.xyz, axis=0), axis=1) > 40)
    ]
    found = [any(name in one.tracks and one.first - 2 <= k <= one.last + 2 for one in asked) for name, k in leaps]
    assert len(leaps) == 93 and sum(found) >= 90 and len(asked) < 100
    assert len(problems(editing).asked) < 55  # steps of one path within a second are one


@pytest.mark.parametrize(
    ("markers", "says"), [(0, "has no trajectories"), (2, "2 markers, of which none is ever seen")]
)
def test_a_file_without_samples_of_markers_is_no_clean_file(tmp_path, markers, says):
    source, unseen = tmp_path / "empty.c3d", np.full((9, 3), np.nan)
    paths = tuple(MarkerTrajectory.measured(name, unseen) for name in ("A", "B")[:markers])
    write_c3d(source, Trial("empty", Trajectories(paths, 100.0)))
    with pytest.raises(KinemarkError, match=rf"{says}\. Give a file of markers in space"):
        audit_file(source)


def test_an_audit_looks_for_computed_points_once(tmp_path, monkeypatch):
    source, calls = tmp_path / "walk.c3d", []
    write_c3d(source, Trial("walk", with_computed(walker(duration_s=4.0))))
    monkeypatch.setattr(
        "kinemark.engine.put_aside.computed_points",
        lambda tracks: calls.append(tracks) or computed_points(tracks),
    )
    assert audit_file(source, mend=True).aside and len(calls) == 1


def test_the_command_lists_with_a_status_and_a_bad_file_does_not_stop_the_others(tmp_path, capsys):
    good, bad, broken = (tmp_path / name for name in ("good.c3d", "bad.c3d", "broken.c3d"))
    write_c3d(good, Trial("walk", clean()))
    write_c3d(bad, Trial("walk", faulty()))
    broken.write_bytes(b"nothing")
    app(["audit", str(good)], result_action="return_value")
    said = capsys.readouterr().out
    assert "Nothing to look at" in said and "errors are expected to be left." in said
    with pytest.raises(SystemExit) as end:
        app(["audit", str(bad), "--json"], result_action="return_value")
    assert end.value.code == 3
    said = json.loads(capsys.readouterr().out)
    assert {one["kind"] for one in said[str(bad)]["problems"] if one["asked"]} >= {"swap", "spike"}
    assert isinstance(audit_files([broken, good])[broken], KinemarkError)
    with pytest.raises(KinemarkError):
        audit_files([broken])


def test_the_commands_list_problems_and_take_an_alternative(tmp_path, capsys):
    source = tmp_path / "walk.c3d"
    write_c3d(source, Trial("walk", faulty()))
    one = problems(Editing.of_file(source)).asked[0]
    app(["edits", "problems", str(source)], result_action="return_value")
    assert one.id in capsys.readouterr().out
    app(["edits", "accept", str(source), one.id, "1", "--why", "seen"], result_action="return_value")
    assert one.id not in {other.id for other in problems(Editing.of_file(source)).items}
    with pytest.raises(KinemarkError, match="There is no problem x"):
        app(["edits", "accept", str(source), "x"], result_action="return_value")
