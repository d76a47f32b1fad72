"""Do edits survive when a trial is processed again, otherwise than it was when they were made?

Each trial is tracked once, and a person who knows the truth edits the tracks: every stretch of constant true identity
is claimed for its marker; samples are erased, places put by hand, gaps left open. Then the trial is processed again in
other ways, the journal is replayed on what comes out, and every sample that has a name is compared with the truth. An
edit is *declared* where replay itself says that it is thin or an orphan; it is right where at most WRONG of the samples
that it names, or one, are another marker's. The control is what other programs do: names are remembered by the number
of the track and the frames.

Of recordings, what stands for the truth is the other system's tracks (gait9), or the known pattern of the LEDs, laid on
the points of each frame (infrared footage).

Run: python studies/edits.py [trials [seed]]        6 trials where no number is given
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from edits_trials import (
    WAYS,
    Processed,
    by_default,
    trials,
)

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from kinemark.data import Origin, Trajectories
from kinemark.data.array_types import Floats, Ints
from kinemark.data.edits import AddEvent, Claim, Edit, Entry, Erase, GapChoice, Put, is_named
from kinemark.edit import Edited, anchored, replay, stretch_of
from kinemark.edit.values import without
from kinemark.engine.keys import world_key
from kinemark.geometry import project
from kinemark.numerics.runs import equal_runs
from kinemark.signal import assign

FAR = 20.0  # mm; a sample belongs to the nearest true marker within
SHORTEST = 4  # samples of a stretch that is worth a claim
WRONG = 0.01  # share of an edit's samples that may be another marker's
OFF = 5.0  # mm; that a place put by hand may be off after all
EACH = 10  # erases, places and choices a trial


def owners(done: Processed) -> Ints:
    """(P, F) the true marker of each sample; −1 for none."""
    mine = done.trajectories.xyz
    owner = np.full(mine.shape[:2], -1, np.int64)
    for f in range(mine.shape[1]):
        there = np.flatnonzero(np.isfinite(done.xyz[:, f, 0]))
        rows = np.flatnonzero(np.isfinite(mine[:, f, 0]))
        if len(there) and len(rows):
            apart = np.linalg.norm(mine[rows, f, None] - done.xyz[there, f], axis=-1)
            i, j = assign(apart, np.full(len(rows), FAR))
            owner[rows[i], f] = there[j]
    return owner


class Piece(NamedTuple):
    """A stretch of constant true identity: path, marker, first and last sample (from 0), and which ends were cut."""

    path: int
    marker: int
    first: int
    last: int
    cut: tuple[bool, bool]


def pieces(done: Processed, owner: Ints) -> list[Piece]:
    """The stretches of all tracks; changes that last less than SHORTEST samples are passed over."""
    found = []
    for p in range(len(owner)):
        frames = np.flatnonzero(owner[p] >= 0)
        edges = equal_runs(owner[p][frames])
        runs = [(a, b) for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True) if b - a >= SHORTEST]
        joined: list[list[int]] = []
        for a, b in runs:
            if joined and owner[p][frames[joined[-1][0]]] == owner[p][frames[a]]:
                joined[-1][1] = b
            else:
                joined.append([a, b])
        for i, (a, b) in enumerate(joined):
            cut = i > 0, i < len(joined) - 1
            found.append(Piece(p, int(owner[p][frames[a]]), int(frames[a]), int(frames[b - 1]), cut))
    return found


# What a person says


def said_by(base: Processed, found: list[Piece], seed: int) -> tuple[list[Entry], list[Edit]]:
    """The journal: claims of every stretch, then values; and the values alone."""
    world, start = world_key(base.rig), base.trajectories.first_frame
    claims = [
        Claim(
            stretch_of(
                base.trajectories,
                base.trajectories.names[one.path],
                first=one.first + start if one.cut[0] else None,
                last=one.last + start if one.cut[1] else None,
                within=(one.first + start, one.last + start),
                detections=base.detections,
                world=world,
            ),
            f"M{one.marker}",
        )
        for one in found
    ]
    entries = [Entry(k + 1, "", "study", "", "", "", (claim,)) for k, claim in enumerate(claims)]
    named = replay(base.trajectories, entries, detections=base.detections, rig=base.rig, world=world).trajectories
    some = some_values(base, named, world, np.random.default_rng(seed))
    values = [anchored(edit, named, base.detections, world) for edit in some]
    return [
        *entries,
        *(Entry(len(entries) + 1 + k, "", "study", "", "", "", (v,)) for k, v in enumerate(values)),
    ], values


def some_values(base: Processed, named: Trajectories, world: str, rng: np.random.Generator) -> Iterator[Edit]:
    """Samples erased, places put, gaps left open, at random."""
    start, n = named.first_frame, named.n_frames
    markers = [path for path in named if is_named(path.name) and (path.origin != Origin.MISSING).sum() > 30]
    for _ in range(EACH):
        path = markers[rng.integers(len(markers))]
        f = int(rng.choice(np.flatnonzero(path.origin != Origin.MISSING)))
        yield Erase(path.name, f + start, min(f + int(rng.integers(4, 15)), n - 1) + start)
    for _ in range(EACH):
        path = markers[rng.integers(len(markers))]
        true = base.xyz[int(path.name[1:])]
        f = int(rng.choice(np.flatnonzero(np.isfinite(true[:, 0]))))
        xyz = true[f] + rng.normal(0, 0.5, 3)
        uv = [project(camera, xyz[None])[0] for camera in base.rig]
        images = tuple((name, float(u), float(v)) for name, (u, v) in zip(base.rig.names, uv, strict=True))
        yield Put(path.name, f + start, tuple(xyz.tolist()), 1.0, images, world)
    gaps = [(path.name, a, b) for path in markers for a, b in path.gaps]
    for k in rng.permutation(len(gaps))[:EACH].tolist():
        name, a, b = gaps[k]
        yield GapChoice(name, a + start, b - 1 + start, "open")
    yield AddEvent("Foot Strike", "Left", 0.1)


# Judging


class Score(NamedTuple):
    """Samples that should have a name: right, wrong, none; the same by track number; edits: right, declared, wrong."""

    right: int = 0
    wrong: int = 0
    none: int = 0
    number_right: int = 0
    number_wrong: int = 0
    number_none: int = 0
    edits_right: int = 0
    declared: int = 0
    edits_wrong: int = 0
    thin: int = 0
    orphans: int = 0
    seconds: float = 0.0

    def plus(self, other: Score) -> Score:
        """The sum."""
        return Score._make(a + b for a, b in zip(self, other, strict=True))


def judged(base: Processed, found: list[Piece], entries: list[Entry], values: list[Edit], done: Processed) -> Score:
    """One way of processing again."""
    began = time.process_time()
    edited = replay(done.trajectories, entries, detections=done.detections, rig=done.rig, world=world_key(done.rig))
    seconds = time.process_time() - began
    shift = done.trajectories.first_frame - base.trajectories.first_frame
    covered = np.zeros(base.xyz.shape[:2], bool)
    for one in found:
        covered[one.marker, one.first : one.last + 1] = True
    covered = covered[:, shift : shift + done.trajectories.n_frames]
    put = {(v.marker, v.frame) for v in values if isinstance(v, Put)}
    after = owners(done._replace(trajectories=without_puts(edited.trajectories, put)))
    called = np.array([int(name[1:]) if is_named(name) else -1 for name in edited.trajectories.names])
    right, wrong, none = counts(after, called[:, None] * np.ones_like(after), covered)
    by_number = numbered(base, found, done.trajectories, shift)
    controls = counts(owners(done), by_number, covered)
    score = Score(right, wrong, none, *controls, seconds=seconds)
    return score.plus(edits(edited, found, values, after, called, shift, done))


def without_puts(trajectories: Trajectories, put: set[tuple[str, int]]) -> Trajectories:
    """Places that were put are judged by themselves."""
    paths = []
    for path in trajectories:
        mask = np.zeros(len(path), bool)
        for name, frame in put:
            f = frame - trajectories.first_frame
            if name == path.name and 0 <= f < len(path):
                mask[f] = True
        paths.append(without(path, mask) if mask.any() else path)
    return replace(trajectories, paths=tuple(paths))


def counts(owner: Ints, called: Ints, covered: Any) -> tuple[int, int, int]:
    """Samples that have a true marker that was claimed then: called so, otherwise, or nothing."""
    p, f = np.nonzero(owner >= 0)
    m, name = owner[p, f], called[p, f]
    due = covered[m, f]
    right = int((due & (name == m)).sum())
    none = int((due & (name < 0)).sum())
    return right, int(((name >= 0) & (name != m)).sum()), none


def numbered(base: Processed, found: list[Piece], again: Trajectories, shift: int) -> Ints:
    """(P, F) names by the number of the track and the frames."""
    called = np.full((len(again), again.n_frames), -1, np.int64)
    for one in found:
        if one.path < len(again):
            called[one.path, max(one.first - shift, 0) : max(one.last + 1 - shift, 0)] = one.marker
    return called


def edits(
    edited: Edited, found: list[Piece], values: list[Edit], after: Ints, called: Ints, shift: int, done: Processed
) -> Score:
    """Which edits are right, declared or wrong."""
    right = declared = wrong = thin = orphans = 0
    for k, applied in enumerate(edited.applied):
        if applied.outcome in ("thin", "orphan"):
            declared += 1
            thin += applied.outcome == "thin"
            orphans += applied.outcome == "orphan"
            continue
        good = (
            claim_right(found[k], after, called, shift) if k < len(found) else value_right(applied.edit, edited, done)
        )
        right, wrong = right + good, wrong + (not good)
    return Score(edits_right=right, declared=declared, edits_wrong=wrong, thin=thin, orphans=orphans)


def claim_right(one: Piece, after: Ints, called: Ints, shift: int) -> bool:
    """Whether, in its frames, what is called so is that marker."""
    at = slice(max(one.first - shift, 0), max(one.last + 1 - shift, 0))
    mine = after[called == one.marker, at]
    judged = mine[mine >= 0]
    return bool((judged != one.marker).sum() <= max(WRONG * len(judged), 1))


def value_right(edit: Edit, edited: Edited, done: Processed) -> bool:
    """Whether a value is what was said."""
    trajectories = edited.trajectories
    start = trajectories.first_frame
    if isinstance(edit, Erase):
        put = [e.edit.frame - start for e in edited.applied if isinstance(e.edit, Put) and e.edit.marker == edit.marker]
        part = trajectories[edit.marker].origin[max(edit.first - start, 0) : max(edit.last + 1 - start, 0)].copy()
        for f in put:
            if 0 <= f - max(edit.first - start, 0) < len(part):
                part[f - max(edit.first - start, 0)] = Origin.MISSING
        return bool((part == Origin.MISSING).all())
    if isinstance(edit, Put):
        f = edit.frame - start
        if not 0 <= f < trajectories.n_frames:
            return True
        return put_right(edit, trajectories[edit.marker].xyz[f], f, done)
    return True


def put_right(edit: Put, xyz: Floats, f: int, done: Processed) -> bool:
    """Whether a place put by hand is where the marker is, or where this processing sees it, its cameras being off."""
    true = done.xyz[int(edit.marker[1:]), f]
    seen = done.trajectories.xyz[:, f]
    near = seen[np.linalg.norm(seen - true, axis=-1) < FAR]
    return bool((np.linalg.norm(np.vstack([true, near]) - xyz, axis=-1) < OFF).any())


HEAD = (
    f"{'':28}{'witnesses':>23}{'track numbers':>25}{'edits':>33}{'replay':>9}\n"
    f"{'':28}{'right':>9}{'wrong':>7}{'none':>7}{'right':>10}{'wrong':>8}{'none':>7}"
    f"{'right':>10}{'declared':>10}{'wrong':>7}{'good %':>8}{'CPU s':>7}"
)


def row(name: str, s: Score, n: int = 1) -> str:
    """A line of the table; samples in %."""
    all_samples = max(s.right + s.wrong + s.none, 1)
    numbers = max(s.number_right + s.number_wrong + s.number_none, 1)
    every = max(s.edits_right + s.declared + s.edits_wrong, 1)
    of = [(s.right, all_samples, "9.2f"), (s.wrong, all_samples, "7.2f"), (s.none, all_samples, "7.2f")]
    of += [(s.number_right, numbers, "10.2f"), (s.number_wrong, numbers, "8.2f"), (s.number_none, numbers, "7.2f")]
    shares = "".join(f"{100 * part / whole:{width}}" for part, whole, width in of)
    good = 100 * (1 - s.edits_wrong / every)
    return f"{name:28}{shares}{s.edits_right:10d}{s.declared:10d}{s.edits_wrong:7d}{good:8.2f}{s.seconds / n:7.2f}"


def main(n: int = 6, seed: int = 0) -> None:
    totals: dict[str, Score] = {}
    done = 0
    for trial in trials(n):
        base = by_default(trial)
        found = pieces(base, owners(base))
        entries, values = said_by(base, found, seed)
        print(f"\n{trial.name}: {len(base.trajectories)} tracks, {len(entries)} edits\n{HEAD}", flush=True)
        for way, again in WAYS.items():
            score = judged(base, found, entries, values, again(trial))
            totals[way] = totals.get(way, Score()).plus(score)
            print(row(way, score), flush=True)
        done += 1
    print(f"\nAll {done} trials\n{HEAD}")
    whole = Score()
    for way, score in totals.items():
        whole = whole.plus(score)
        print(row(way, score, done))
    print(row("all", whole, done * len(totals)))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
