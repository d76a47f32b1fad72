"""Further rows of `labelling.py`: files whose nameless tracks stay beside the markers, and parts of the body.

    python benchmarks/labelling_parts.py 42000-42012    markers that nobody named, in the static trial and in the walk

A line a seed: samples sure and right, and sure and wrong, ghosts that have a sure name, right and wrong if all were
taken, in %, by the set alone and with what is nameless in the static trial.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from labelling_cases import (
    CHILD,
    CHILDREN,
    GAIT,
    PLATES,
    ROOT,
    TUNED_CHILDREN,
    Row,
    child,
    only,
    read,
    whole_body,
)
from labelling_scores import score_labels
from labelling_shredded import GHOSTS, Shredded, shredded

from kinemark.data import MarkerSet, MarkerTrajectory, Trajectories
from kinemark.data.array_types import Floats
from kinemark.io.marker_sets import read_marker_set
from kinemark.label import label, learn_template, static_template
from kinemark.label.bystanders import among_bystanders
from kinemark.label.from_set import static_bystanders

MARKERS_OF_LEGS = "LASI RASI SACR LPSI RPSI LTHI LKNE LTIB LANK LHEE LTOE RTHI RKNE RTIB RANK RHEE RTOE"
"""Of plug-in-gait-lower, and the sacrum."""
STEADIEST, NEAR_MM = 3, 10.0
"""Markers by whose mean distances a nameless sample is told to be an absent marker, and mm to which all hold; chosen:
of markers 20 mm apart none is the other."""
LEGS = tuple(MARKERS_OF_LEGS.split())


def rows_of_parts() -> Iterator[Row]:
    """All of them whose files are here."""
    if ROOT.is_dir():
        yield from with_nameless()
        yield from part_of_body()


def with_nameless() -> Iterator[Row]:
    """Files whose tracks without names stay beside the markers, as `kinemark label` sees them.

    Of the whole body 37 of 42 are markers that its set does not have, on head, thighs, shanks and feet, seen all
    through; two are twins of the heels, three what was left of single frames all over the body, in one channel each.
    """
    body, move = whole_body(), "pig_wholebody/Movement_trial.c3d"
    full = read_marker_set("plug-in-gait-full")
    trial = _with_nameless(move, full.moving)
    yield Row("whole body static, 42 nameless", static_template(body, full), trial, nameless=True)
    still = read("pig_wholebody/Static_trial.c3d")
    own, wider = static_template(still, full), static_bystanders(still, full)
    yield Row("whole body static with 37 of the 42 nameless", own, trial, nameless=True, wider=wider)
    half = trial.n_frames // 2
    learnt = learn_template(only(trial, full.moving).frames(0, half))
    yield Row("whole body by first half, 42 nameless", learnt, trial.frames(half, trial.n_frames), nameless=True)
    plates = read_marker_set("plug-in-gait-lower")
    static = static_template(read(f"{PLATES}Calibration3_FF.c3d"), plates)
    file = f"{PLATES}Motion3_FF.c3d"
    yield Row("three plates static, 7 nameless", static, _with_nameless(file, static.names), nameless=True)
    for name, of, n in (("HC030A", 1, 5), ("HC031A", 1, 1), ("HC033A", 0, 1), ("HC033A", 1, 2)):
        folder, *trials, _ = CHILDREN[name]
        template = learn_template(child(name, 1 - of))
        trial = _with_nameless(f"{folder}/{name}{trials[of]}.c3d", CHILD)
        yield Row(f"{name}{trials[1 - of]} labels {trials[of]}, {n} nameless", template, trial, nameless=True)
    hand = read("ulema_hand_to_head/GHr.c3d")
    half = hand.n_frames // 2
    learnt = learn_template(hand.frames(0, half))
    yield Row(
        "hand to head by first half, 32 nameless",
        learnt,
        _with_nameless("ulema_hand_to_head/GHr.c3d", learnt.names).frames(half, hand.n_frames),
        nameless=True,
    )


def part_of_body() -> Iterator[Row]:
    """Legs or upper body alone, by the template of a whole body; the sacrum is none of its set."""
    full = read_marker_set("plug-in-gait-full")
    trials = [
        ("qualisys", read("qualisys_gait/Static - CGM2 1.c3d"), read(GAIT)),
        ("whole body", whole_body(), read("pig_wholebody/Movement_trial.c3d")),
        *((name, child(name, 2), child(name, 0)) for name in CHILDREN),
    ]
    for name, static, trial in trials:
        template = static_template(static, full)
        upper = [one for one in template.names if one not in LEGS]
        yield Row(f"{name} static, legs alone", template, only(trial, LEGS), tuned=name in TUNED_CHILDREN)
        yield Row(f"{name} static, upper body alone", template, only(trial, upper), tuned=name in TUNED_CHILDREN)


def _with_nameless(file: str, names: Sequence[str]) -> Trajectories:
    """Those of the markers that the file has, and its tracks without names that have samples.

    But for samples that are a marker's which is absent meanwhile: who named the file left single ones aside.
    """
    trial = read(file)
    marked = only(trial, names)
    rest = {path.name: _without_absent(path.xyz, marked.xyz) for path in trial if path.name.startswith("*")}
    whole = _with(marked, {name: xyz for name, xyz in rest.items() if np.isfinite(xyz).any()})
    return whole.select([name for name in trial.names if name in whole.names])


def _without_absent(xyz: Floats, marked: Floats) -> Floats:
    """The nameless samples (F, 3) mm that lie at the place of none of the markers (M, F, 3) that is absent then.

    A place is told by the marker's mean distances to those that keep theirs to it best over the trial.
    """
    apart = np.linalg.norm(marked[:, None] - marked[None], axis=3)
    apart[np.eye(len(marked), dtype=bool)] = np.nan
    out = xyz.copy()
    for f in np.flatnonzero(np.isfinite(xyz[:, 0])):
        there = np.flatnonzero(np.isfinite(marked[:, f, 0]))
        own = np.linalg.norm(marked[there, f] - xyz[f], axis=1)
        for m in np.flatnonzero(~np.isfinite(marked[:, f, 0]) & np.isfinite(marked[..., 0]).any(1)):
            near = np.argsort(np.nanstd(apart[m, there], axis=1))[:STEADIEST]
            if (np.abs(np.nanmean(apart[m, there[near]], axis=1) - own[near]) < NEAR_MM).all():
                out[f] = np.nan
    return out


def worn_in_both(seed: int) -> tuple[Trajectories, Shredded]:
    """A static trial with 2 to 40 nameless markers, and a walk as tracks that lacks some of them and of the set's."""
    rng, full = np.random.default_rng([seed, 77]), read_marker_set("plug-in-gait-full")
    named = [
        *((child(name, 2), child(name, 0)) for name in CHILDREN),
        (read("qualisys_gait/Static - CGM2 1.c3d"), read(GAIT)),
        (whole_body(), read("pig_wholebody/Movement_trial.c3d")),
    ]
    still, walk = named[seed % len(named)]
    names = [name for name in full.moving if name in still.names]
    still, walk = only(still, names), only(walk, names)
    n, kept = int(rng.choice([2, 5, 10, 20, 40])), float(rng.choice([1, 1, 0.7, 0.4]))
    pieces, absent = int(rng.choice([1, 1, 1, 4])), int(rng.choice([0, 0, 1, 2]))
    made = [_fixed(still, walk, full, rng) for _ in range(n)]
    there = [rng.random() <= kept for _ in made]
    standing = _with(still, {f"*{k}": a for k, (a, _) in enumerate(made, 100)})
    walking = _with(walk, {f"*{k}": b for k, ((_, b), yes) in enumerate(zip(made, there, strict=True), 900) if yes})
    gone = set(rng.choice(names, absent, replace=False).tolist())
    walking = walking.select([name for name in walking.names if name not in gone])
    return standing, shredded(walking, pieces, float(rng.choice([0, 1, 3])), seed, kinds=GHOSTS)


def _fixed(still: Trajectories, walk: Trajectories, full: MarkerSet, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Places in both trials of a marker that is fixed to two of one segment and the next one, up to 50 mm beside."""
    on = [[name for name in own if name in still.names and name in walk.names] for own in full.segments.values()]
    on = [own for own in on if len(own) > 1]
    a, b = rng.choice(on[int(rng.integers(len(on)))], 2, replace=False).tolist()
    others = [name for name in still.names if name in walk.names and name not in (a, b)]
    c = min(others, key=lambda name: sum(_apart(trial, name, a) for trial in (still, walk)))
    s, t, beside = rng.uniform(-0.2, 1.2), rng.uniform(-0.7, 0.7), rng.uniform(-50, 50)

    def place(trial: Trajectories) -> Floats:
        x, u, v = trial[a].xyz, trial[b].xyz - trial[a].xyz, trial[c].xyz - trial[a].xyz
        up = np.cross(u, v)
        return np.asarray(x + s * u + t * v + beside * up / np.linalg.norm(up, axis=1, keepdims=True))

    return place(still), place(walk)


def _apart(trial: Trajectories, a: str, b: str) -> float:
    return float(np.nanmean(np.linalg.norm(trial[a].xyz - trial[b].xyz, axis=1)))


def _with(trial: Trajectories, more: dict[str, Floats]) -> Trajectories:
    return replace(trial, paths=(*trial.paths, *(MarkerTrajectory.measured(name, xyz) for name, xyz in more.items())))


def main() -> None:
    """The seeds from the one to below the other."""
    first, stop = map(int, sys.argv[1].split("-"))
    full, sums = read_marker_set("plug-in-gait-full"), np.zeros((2, 5))
    for seed in range(first, stop):
        still, parts = worn_in_both(seed)
        template, wider = static_template(still, full), static_bystanders(still, full)
        alone = label(parts.tracks, template)
        both = alone if wider is None else among_bystanders(parts.tracks, alone, template, wider)
        scores = [score_labels(found, parts, template.names) for found in (alone, both)]
        shares = 100 * np.array([(s.right, s.wrong, s.ghosts, s.best_right, s.best_wrong) for s in scores])
        sums += shares
        print(f"{seed:6d}  " + "   →".join("".join(f"{x:8.2f}" for x in row) for row in shares), flush=True)
    print("mean    " + "   →".join("".join(f"{x:8.2f}" for x in row) for row in sums / (stop - first)))


if __name__ == "__main__":
    main()
