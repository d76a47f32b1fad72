"""Versions of a trial share what an edit does not touch, and are what a replay from nothing gives."""

from dataclasses import replace

import numpy as np

from kinemark.data import same
from kinemark.data.edits import Claim, Erase, GapChoice, ImagePoint, Put, Smooth, Undo
from kinemark.edit import folds, joined, replay, stretch_of, votes
from support.edited import FRAMES, entries, scene


def forget():
    """As in a process that has just begun."""
    joined._KNOWN.clear()
    folds._KNOWN.clear()
    votes.known_votes.cache_clear()
    votes.owners.cache_clear()


def said_by_chance(rng, trajectories, detections, world):
    """A claim or an edit of a value, of trajectories as they are called now."""
    name = str(rng.choice(trajectories.names))
    first = int(rng.integers(1, FRAMES - 30))
    last = first + int(rng.integers(2, 28))
    span = {"first": first, "last": last} if rng.random() < 0.5 else {}
    if rng.random() < 0.5 or name.startswith("*"):
        called = rng.choice(["A", "B", "C", None])
        try:
            return Claim(stretch_of(trajectories, name, detections=detections, world=world, **span), called)
        except ValueError:
            return Claim(stretch_of(trajectories, name, detections=detections, world=world), called)
    camera = detections.cameras[int(rng.integers(len(detections.cameras)))]
    some = (
        Erase(name, first, last), Put(name, first, (1.0, 2.0, 3.0), 1.0, (), world), Smooth(name, first, last, 6.0),
        GapChoice(name, first, last, "linear"), ImagePoint(camera, first, 10.0, 20.0, name),
        ImagePoint(camera, first, *detections[detections.cameras.index(camera), first - 1][0].tolist(), None),
    )  # fmt: skip
    return some[int(rng.integers(len(some)))]


def test_a_version_is_what_a_replay_from_nothing_gives_whatever_was_looked_at_before():
    rig, detections, given, world = scene()
    of = {"detections": detections, "rig": rig, "world": world}
    for seed in range(4):
        rng, journal = np.random.default_rng(seed), []
        now = replay(given, journal, **of)
        for _ in range(12):
            undo = journal and rng.random() < 0.2
            edit = (
                Undo(int(rng.integers(1, len(journal) + 1)))
                if undo
                else said_by_chance(rng, now.trajectories, detections, world)
            )
            journal += entries(edit, first=len(journal) + 1)
            now = replay(given, journal, **of)
        kept = now
        forget()
        fresh = replay(given, journal, **of)
        assert same(fresh.trajectories, kept.trajectories)
        assert fresh.applied == kept.applied and fresh.reviewed == kept.reviewed


def test_an_edit_leaves_all_other_markers_the_same_records_and_its_undo_gives_the_old_one_back():
    rig, detections, given, world = scene()
    of = {"detections": detections, "rig": rig, "world": world}
    named = [
        Claim(stretch_of(given, path, detections=detections, world=world), name)
        for path, name in zip(given.names[:3], "ABC", strict=True)
    ]
    journal = [*entries(*named, Erase("A", 5, 9), Put("B", 7, (0.0, 0.0, 0.0), 1.0, (), world))]
    before = replay(given, journal, **of)
    journal += entries(Smooth("C", 20, 80, 6.0), first=len(journal) + 1)
    after = replay(given, journal, **of)
    changed = [path.name for path in after.trajectories if not any(path is old for old in before.trajectories)]
    assert changed == ["C"]
    journal += entries(Undo(len(journal)), first=len(journal) + 1)
    again = replay(given, journal, **of)
    assert all(a is b for a, b in zip(again.trajectories, before.trajectories, strict=True))


def test_what_was_kept_of_one_trial_is_not_taken_for_another():
    rig, detections, given, world = scene()
    claim = Claim(stretch_of(given, given.names[0], detections=detections, world=world), "A")
    moved = replace(given, paths=(*given.paths[1:], given.paths[0]))
    for trial in (given, moved, given):
        found = replay(trial, entries(claim), detections=detections, rig=rig, world=world).trajectories
        assert same(found["A"], replace(given.paths[0], name="A"))
