"""Tracking again with facts: a correction mends its neighbourhood, holds to the letter, and harms nobody."""

import numpy as np
import pytest

from kinemark import KinemarkError
from kinemark.data import Tracks, same
from kinemark.data.edits import Claim, Entry, Erase, ImagePoint, TrackAgain, Undo, facts_of
from kinemark.edit import anchored, replay, stretch_of
from kinemark.engine.editing.files import open_editing
from kinemark.engine.editing.retracking import facts_of_tracks
from kinemark.engine.session import Session
from kinemark.geometry import project
from kinemark.track import to_trajectories
from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.facts import mended_tracks
from support.edited import FRAMES, entries, scene
from support.sessions import folder_of

AT = 60


@pytest.fixture(scope="module")
def right():
    rig, detections, *_ = scene()
    return track_detections(detections, rig)


def exchanged(tracks, at=AT):
    """The first two tracks go on as each other from a frame on, as after a wrong decision."""
    id, late = tracks.id.copy(), tracks.cloud.frame >= at
    id[late & (tracks.id == 0)], id[late & (tracks.id == 1)] = 1, 0
    return Tracks(tracks.cloud, id)


def claim(tracks, name, called, **where):
    rig, detections, _, world = scene()
    return Claim(stretch_of(to_trajectories(tracks, rig), name, detections=detections, world=world, **where), called)


def again(tracks, said):
    """The tracks with facts, and what replay makes of these and of the tracks as they were."""
    rig, detections, _, world = scene()
    mended = mended_tracks(detections, rig, tracks, facts_of_tracks(tracks, said, detections, rig))
    both = (
        replay(to_trajectories(t, rig), said, detections=detections, rig=rig, world=world, facts=True)
        for t in (mended.tracks, tracks)
    )
    return mended, *both


def right_samples(edited, right):
    """How many samples have the name that is theirs, within 1 mm: A is the first track, B the second."""
    truth = to_trajectories(right, scene()[0])
    pairs = [(edited.trajectories[n].xyz, truth.paths[k].xyz) for k, n in enumerate("AB")]
    return sum(int((np.linalg.norm(a - b, axis=1) < 1.0).sum()) for a, b in pairs)


def test_one_claim_at_the_root_gives_the_other_marker_back_too(right):
    wrong = exchanged(right)
    said = entries(*(claim(wrong, f"*{k + 1}", n) for k, n in enumerate("AB")), claim(wrong, "*2", "A", first=AT + 1))
    mended, edited, alone = again(wrong, said)
    assert right_samples(alone, right) == 2 * FRAMES - (FRAMES - AT), "replay leaves the rest of B without a name"
    assert right_samples(edited, right) == 2 * FRAMES
    assert [one.outcome for one in edited.applied] == ["held"] * 3
    assert len(mended.tracks) == len(right)


def test_tracks_that_no_fact_is_about_are_as_they_were(right):
    wrong = exchanged(right)
    said = entries(claim(wrong, "*1", "A"), claim(wrong, "*2", "A", first=AT + 1))
    rig = scene()[0]
    before, after = to_trajectories(wrong, rig), to_trajectories(again(wrong, said)[0].tracks, rig)
    assert all(same(before[f"*{k}"], after[f"*{k}"]) for k in (3, 4, 5))
    untouched = again(right, entries(Erase("nobody", 1, 2)))[0]
    assert same(untouched.tracks, right)


def test_what_is_no_marker_is_not_tracked_and_a_refused_image_is_not_used(right):
    _rig, detections, *_ = scene()
    ghost = again(right, entries(claim(right, "*3", None)))[0]
    assert len(ghost.tracks) == len(right) - 1 and ghost.became.tolist() == [0, 1, -1, 2, 3]
    row = int(right.cloud.detection[(right.id == 0) & (right.cloud.frame == 40)].max())
    u, v = detections.uv[row].tolist()
    where = detections.cameras[int(detections.camera[row])], 41, u, v
    without = again(right, entries(ImagePoint(*where, None)))[0].tracks.cloud
    assert row in right.cloud.detection and row not in without.detection
    assert len(without) == len(right.cloud), "the other cameras still see the marker"


def test_erased_points_set_their_images_free_for_the_marker_that_is_missing_there(right):
    hole = (right.id == 0) & (right.cloud.frame >= 50) & (right.cloud.frame < 56)
    id = np.where(hole, right.id.max() + 1, right.id)
    wrong = Tracks(right.cloud, id)  # a ghost of its own has the images
    said = entries(claim(wrong, "*1", "A"), claim(wrong, "*6", "B"), Erase("B", 51, 56))
    mended = again(wrong, said)[0].tracks
    assert (mended.id == 0).sum() == FRAMES
    taken = np.sort(mended.cloud.detection[(mended.id == 0) & (mended.cloud.frame >= 50) & (mended.cloud.frame < 56)])
    assert np.array_equal(taken, np.sort(right.cloud.detection[hole]))


def test_what_tracking_found_in_the_place_of_erased_samples_is_not_erased_again(right):
    rig, detections, tracks, world = scene()
    wrong = exchanged(exchanged(right, 50), 56)  # for six frames
    named = entries(claim(wrong, "*1", "A"), claim(wrong, "*2", "B"))
    seen = replay(to_trajectories(wrong, rig), named, detections=detections, rig=rig, world=world).trajectories
    erased = [anchored(Erase(name, 51, 56), seen, detections, world) for name in "AB"]
    said = [*named, *entries((*erased, TrackAgain()), first=3)]
    edited = again(wrong, said)[1]
    assert [one.outcome for one in edited.applied] == ["held", "held", "moot", "moot", "held"]
    for name, number in zip("AB", ("*1", "*2"), strict=True):
        assert np.abs(edited.trajectories[name].xyz - tracks[number].xyz)[50:56].max() < 1e-3


def test_facts_are_of_the_samples_that_they_were_said_of_whatever_these_are_called_since(right):
    rig, detections, _, world = scene()
    named = entries(claim(right, "*1", "A"), claim(right, "*2", "B"))
    seen = replay(to_trajectories(right, rig), named, detections=detections, rig=rig, world=world).trajectories
    u, v = project(rig.cameras[0], seen["A"].xyz[30][None])[0].tolist()
    said = Erase("A", 51, 56), ImagePoint(rig.names[0], 31, u, v, "A")
    values = entries(*(anchored(edit, seen, detections, world) for edit in said), first=3)
    now = entries(claim(right, "*1", "B"), claim(right, "*2", "A"), first=5)
    facts = facts_of_tracks(right, [*named, *values, *now], detections, rig)
    assert np.unique(right.id[facts.wrong]).tolist() == [0] and facts.wrong.sum() == 6
    number = facts.marker[right.id == 0][0]
    assert set(facts.owner[facts.owner >= 0].tolist()) == {number}
    assert (facts.places.frame.tolist(), facts.places.id.tolist()) == ([30], [number])
    gone = facts_of_tracks(right, [*entries(claim(right, "*3", "A")), *values], detections, rig)
    assert not gone.wrong.any() and not (gone.owner >= 0).any(), "of no marker that is called anything"


def test_images_of_a_marker_that_is_missing_are_its_own_though_the_first_alone_is_no_place(right):
    rig, detections, tracks, world = scene()
    hole = (right.id == 0) & (right.cloud.frame >= 50) & (right.cloud.frame < 56)
    wrong = Tracks(right.cloud, np.where(hole, right.id.max() + 1, right.id))
    named = entries(claim(wrong, "*1", "A"))
    seen = replay(to_trajectories(wrong, rig), named, detections=detections, rig=rig, world=world).trajectories
    some = [k for k in range(4) if tracks["*1"].detection[52, k] >= 0][:2]
    uv = [detections.uv[tracks["*1"].detection[52, k]].tolist() for k in some]
    images = [ImagePoint(rig.names[k], 53, u, v, "A") for k, (u, v) in zip(some, uv, strict=True)]
    said = [*named, *entries(*(anchored(one, seen, detections, world) for one in images), first=2)]
    facts = facts_of_tracks(wrong, said, detections, rig)
    assert np.flatnonzero(facts.owner >= 0).tolist() == sorted(tracks["*1"].detection[52, some].tolist())


def test_facts_are_what_counts_up_to_the_last_call(right):
    said = entries(Erase("A", 1, 2), TrackAgain(), Erase("A", 3, 4))
    assert [entry.id for entry in facts_of(said)] == [1, 2]
    undone = [*said, Entry(4, "", "", "", "", "", (Undo(2),))]
    assert facts_of(undone) == () and facts_of(entries(Erase("A", 1, 2))) == ()


def test_a_session_tracks_again_when_asked_and_not_when_that_is_undone(tmp_path):
    folder_of(tmp_path, 4)
    editing = open_editing(tmp_path / "one")
    with pytest.raises(KinemarkError, match="Nothing was said"):
        editing.track_again()
    editing.claim("*2", None)
    said = editing.track_again()
    assert [one.outcome for one in said.applied] == ["held"] and editing.outdated
    trial = Session.open(tmp_path).trial("one")
    assert trial.stages == ("detect", "track", "retrack", "edit", "quality", "write")
    done = trial.run("quality")
    assert len(done.tracks) == 4 and [row["outcome"] for row in done.quality["edits"]] == ["held", "held"]
    assert not open_editing(tmp_path / "one").outdated
    editing.journal.undo()
    assert trial.stages == ("detect", "track", "edit", "quality", "write") and trial.state()["track"]
