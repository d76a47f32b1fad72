"""Are the probabilities of problems true, and does the list find what is wrong?

Simulated scenes of 15 to 60 markers and 2 to 12 cameras are tracked, and labelled trials of other systems are read;
each is looked at as it is, and with seeded faults (`probable_errors_faults`). What the trackers themselves did wrong
counts as well. The coefficients of `edit/probable_errors/probability.py` are fitted to the scenes of TUNE and every
second file (how the trial of a file tells: to all, by `trial_bulk`, which tells of each laboratory by the others);
everything else is told of the other files and of the scenes of FRESH, which had not been looked at before.

Of these it is told: the area under the ROC curve of `wrong`; how many of the problems of a class of `wrong` were truly
wrong; how many errors were expected and true, among all and among those below the stop rule; how many problems a trial
without faults has; and which seeded faults were found.

Problems of one recording are not independent: intervals of 95 % are those of drawing recordings again (bootstrap), all
that was made of one together.

Run: python studies/probable_errors.py [fit]         fit: print new coefficients too
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from probable_errors_faults import Faulty, owners, seeded
from probable_errors_fits import fitted, levelled, rescaled
from probable_errors_tables import Judged, classes, interval, ratio, table
from recordings import FOLDER as DATA

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from kinemark.data import Detections, KinemarkError, MarkerTrajectory, Origin, Rig, Trajectories
from kinemark.data.array_types import Floats, Ints
from kinemark.data.problems import OF_WHOLE, Problem, Problems
from kinemark.data.track_trajectories import trajectories_of
from kinemark.edit.probable_errors import (
    Evidence,
    Leap,
    Paths,
    Spike,
    changes,
    fillings,
    ghosts,
    leaps,
    pieces,
    places,
    spikes,
)  # fmt: skip
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.problems import problems
from kinemark.engine.put_aside import put_aside
from kinemark.io.trial import read_trial
from kinemark.synth import observe, ring, walking, with_markers
from kinemark.track.simultaneous import AmbiguousDecision, track_with_decisions
from support.scenes import make, scene

TUNE, FRESH = (*range(100, 140), *range(340, 460)), range(460, 520)
FILES = (
    "pig_gait_child*/*.c3d", "pig_gait_3plates_emg/PiG_M*FF.c3d", "fullbody_cmu/*.c3d", "labelling/*.c3d",
    "pig_wholebody/M*.c3d", "gait_emg_ccby/*01.c3d", "opensim_gait/*walk.trc",
)  # fmt: skip
NEAR = 8  # samples of a half that say whose it is
OFF_MM = 5.0  # mm that samples must be off at least to be wrong
SURELY_OFF_MM = 15.0  # mm with which they are, however far motion would lead over a gap
SMEARED = 3  # frames to each side of an exchange over which it is smeared
LONGEST = 1500  # frames of a file that are looked at
EVERY, LEAST_HZ = (1, 2, 4, 8), 20.0  # frames of a file, and the rate that is left at least
RESCALED = ("change", "cut", "ghost", "piece_in_file")  # kinds of `rescaled`
LEVELLED = ("spike_in_file",)  # kinds of `levelled`
KINDS = (
    "change", "cut", "spike", "spike_in_file", "leap", "piece", "piece_in_file", "filling", "ghost",
)  # fmt: skip

NATURAL = (
    ("HC031A23.c3d", "RP5M", 1.90, 2.06),  # 73 mm beside its foot, filtered
    ("PronetoRun01.c3d", "LSHP", 5.1, 5.3),  # a marker of a plate is 36 mm off the others, which end
    ("TYPE-3.c3d", "RANK", 3.1, 3.25),  # one sample 16 mm nearer to all of its foot
    ("HC032A18.c3d", "RHLX", 1.5, 1.65), ("HC032A18.c3d", "RNAV", 1.5, 1.65),  # exchanged, filtered
    ("HC033A22.c3d", "RAJC", 0.25, 0.5),  # a computed point whose plate was fitted to other markers, 10 mm off
)  # fmt: skip
"""File, what markers' names begin with, s: errors of files as they are."""


class Known(NamedTuple):
    """A trial whose truth is known: true paths (M, F, 3) mm, and whose each sample is (P, F)."""

    name: str
    trajectories: Trajectories
    owner: Ints
    truth: Floats
    detections: Detections | None = None
    rig: Rig | None = None
    decisions: tuple[AmbiguousDecision, ...] = ()
    faulty: Faulty | None = None


def simulated(seeds: Sequence[int]) -> Iterator[Known]:
    for seed in seeds:
        made = make(scene(seed))
        try:
            tracks, decisions = track_with_decisions(made.detections, made.rig)
        except KinemarkError:
            continue
        found = trajectories_of(tracks)
        if len(found):
            owner = owners(found, made.xyz)
            yield Known(str(made.scene), found, owner, made.xyz, made.detections, made.rig, tuple(decisions))


def labelled(part: int, patterns: Sequence[str] = FILES) -> Iterator[Known]:
    """The markers of every second file of other systems, at its own rate and at lower ones."""
    files = sorted(file for pattern in patterns for file in (DATA / "mocap3d").glob(pattern)) if DATA.is_dir() else []
    for file in files[part::2]:
        whole = put_aside(read_trial(file)).rest
        found = whole.frames(0, min(whole.n_frames, LONGEST)).select(
            [p.name for p in whole if not p.name.startswith("*")]
        )
        seen = [path for path in found if (path.origin != Origin.MISSING).sum() > 50]
        if len(seen) > 4:
            found = found.select([path.name for path in seen])
            owner = np.where(np.isfinite(found.xyz[..., 0]), np.arange(len(found))[:, None], -1)
            known = Known(file.name, found, owner, found.xyz)
            yield from (thinned(known, k) for k in EVERY if found.rate / k >= LEAST_HZ)


def thinned(known: Known, k: int) -> Known:
    """One frame of so many."""
    paths = tuple(MarkerTrajectory.measured(path.name, path.xyz[::k]) for path in known.trajectories)
    few = Trajectories(paths, known.trajectories.rate / k)
    return known._replace(trajectories=few, owner=known.owner[:, ::k], truth=known.truth[:, ::k])


def with_faults(known: Known, seed: int, *, counts: dict[str, int] | None = None) -> Known:
    faulty = seeded(known.trajectories, known.owner, seed, counts=counts)
    owner = np.array(faulty.owner)
    return known._replace(trajectories=faulty.trajectories, owner=owner, faulty=faulty)


def both(some: Iterator[Known], *, drawn: int = 1) -> Iterator[Known]:
    """Each as it is, and with faults that are drawn so many times."""
    for k, known in enumerate(some):
        yield known
        yield from (with_faults(known, k + 1000 * n) for n in range(drawn))


# Truth


def whose(owner: Ints) -> int:
    own = owner[owner >= 0]
    values, count = np.unique(own, return_counts=True)
    return int(values[count.argmax()]) if len(own) else -1


def halves(known: Known, p: int, f: int, g: int) -> tuple[int, int]:
    """Whose path p is up to frame f, and from g on."""
    own = np.flatnonzero(known.trajectories.paths[p].origin != Origin.MISSING)
    return whose(known.owner[p][own[own <= f][-NEAR:]]), whose(known.owner[p][own[own >= g][:NEAR]])


def changed(known: Known, p: int, f: int, g: int) -> bool | None:
    """Whether path p is another marker's after a place, in files, whose owners are exact, within what filters smear."""
    if known.rig is None:
        own = np.flatnonzero(known.owner[p] >= 0)
        own = own[max(np.searchsorted(own, f - SMEARED, "right") - 1, 0) : np.searchsorted(own, g + SMEARED) + 1]
        return bool(np.diff(known.owner[p][own]).any()) if len(own) > 1 else None
    a, b = halves(known, p, f, g)
    return None if a < 0 or b < 0 else a != b


def stands_off(known: Known, p: int, first: int, last: int, mm: float) -> bool | None:
    a, _ = halves(known, p, first - 1, last + 1)
    if a < 0:
        return None
    xyz, truth = known.trajectories.paths[p].xyz, known.truth[a]
    off = np.linalg.norm(xyz - truth, axis=1)
    own = np.flatnonzero(np.isfinite(off[:first]))[-NEAR:]
    usual = float(np.median(off[own])) if len(own) and known.rig is not None else 0.0
    there = off[first : last + 1]
    there = there[np.isfinite(there)]
    return bool(len(there)) and float(np.median(there)) > max(0.4 * mm, 2 * usual, OFF_MM)


def leapt(known: Known, p: int, f: int, g: int, mm: float) -> bool | None:
    """Whether path p comes off its marker between two frames."""
    a, b = halves(known, p, f, g)
    if a < 0:
        return None
    off = (known.trajectories.paths[p].xyz - known.truth[a])[f : g + 1]
    off[1:-1][known.owner[p][f + 1 : g] < 0] = np.nan  # what nobody measured is a problem of its own
    step = np.linalg.norm(off - off[0], axis=1)
    return a != b if np.isnan(step).all() else bool(np.nanmax(step) > np.clip(0.4 * mm, OFF_MM, SURELY_OFF_MM))


def one_marker(known: Known, p: int, q: int) -> bool | None:
    own, other = (np.flatnonzero(known.trajectories.paths[k].origin != Origin.MISSING) for k in (p, q))
    a, b = whose(known.owner[p][own[-NEAR:]]), whose(known.owner[q][other[:NEAR]])
    return None if a < 0 and b < 0 else a == b


def no_marker(known: Known, p: int) -> bool:
    own = known.trajectories.paths[p].origin != Origin.MISSING
    return bool((known.owner[p][own] >= 0).mean() < 0.5)


def nobodys(known: Known, p: int, first: int, last: int) -> bool:
    """Whether most of these samples were not measured."""
    return bool((known.owner[p][first : last + 1] < 0).mean() > 0.5)


# Fitting


def evidence(known: Known) -> Iterator[tuple[str, tuple[float, ...], bool]]:
    """What tells of everything that is looked at in a trial, of changes of tracks what is listed, and the truth."""
    paths = Paths.of(known.trajectories)
    if known.rig is not None:
        yield from _of_list(known)
    else:
        for change in changes(paths, places(paths)):
            own, i, p = paths.frames[change.place.path], change.place.sample, change.place.path
            yield from _told(change.kind, change.evidence, changed(known, p, int(own[i]), int(own[i + 1])))
    gone = leaps(paths)
    for spike in spikes(paths):
        if not any(said(spike, leap) for leap in gone):
            off = stands_off(known, spike.path, spike.first, spike.last, spike.keep_mm)
            yield from _told(spike.kind, spike.evidence, off)
    for leap in gone:
        yield from _told("leap", leap.evidence, leapt(known, leap.path, leap.before, leap.after, leap.mm))
    for piece in pieces(paths):
        yield from _told(piece.kind, piece.evidence, one_marker(known, piece.before, piece.after))
    for one in fillings(paths):
        yield from _told("filling", one.evidence, nobodys(known, one.path, one.first, one.last))
    for ghost in ghosts(paths, known.trajectories):
        yield from _told("ghost", ghost.evidence, no_marker(known, ghost.path))


def _of_list(known: Known) -> Iterator[tuple[str, tuple[float, ...], bool]]:
    """Of changes of tracks: of those within a moment the list has only the likeliest, and says nothing of spikes'
    edges, so that of all places more are said to be wrong than of those listed."""
    for one in listed(known).items:
        if set(Evidence._fields) <= set(one.values):  # in a long gap there is besides what was assumed
            of = Evidence(*(one.values[name] for name in Evidence._fields))
            yield from _told("cut" if of.alone else "change", of, truth_of(known, one))


def said(spike: Spike, leap: Leap) -> bool:
    """Whether a leap that is as likely shows the same, so that the list has it instead."""
    at_once = leap.before <= spike.last and spike.first <= leap.after
    return leap.path == spike.path and at_once and spike.wrong <= leap.wrong


def _told(kind: str, of: Sequence[float], wrong: bool | None) -> Iterator[tuple[str, tuple[float, ...], bool]]:
    if wrong is not None:
        yield kind, tuple(of), wrong


def fit(some: Iterator[Known]) -> None:
    rows = [(known.name, *row) for known in some for row in evidence(known)]
    for kind in KINDS:
        mine = [row for row in rows if row[1] == kind]
        x, y = np.array([row[2] for row in mine]), np.array([float(row[3]) for row in mine])
        c = rescaled(kind, x, y) if kind in RESCALED else fitted(x, y)
        c = levelled(kind, x, y, [row[0] for row in mine]) if kind in LEVELLED else c
        print(f'    "{kind}": ({", ".join(f"{k:.2f}" for k in c)}),  # {len(y)}, {y.sum():.0f} wrong')


# Checking


def listed(known: Known) -> Problems:
    with tempfile.TemporaryDirectory() as folder:
        journal = Journal.of(Path(folder), "trial")
        return problems(
            Editing("trial", journal, known.trajectories, known.detections, known.rig, decisions=known.decisions),
            one_by_one=True,
        )


def natural(known: Known, one: Problem) -> bool:
    """Whether a problem is an error that its file has as it is."""
    at = (np.array([one.first, one.last]) - known.trajectories.first_frame) / known.trajectories.rate
    return any(
        known.name == file and any(name.startswith(start) for name in one.tracks) and at[0] < high and at[1] > low
        for file, start, low, high in NATURAL
    )


def truth_of(known: Known, one: Problem) -> bool | None:
    """Whether a problem is one; None where the truth does not say."""
    if natural(known, one):
        return None
    if one.kind in OF_WHOLE:
        return False
    names, start = known.trajectories.names, known.trajectories.first_frame
    who = [names.index(name) for name in one.tracks]
    first, last = one.first - start, one.last - start
    if one.kind == "spike":
        return stands_off(known, who[0], first, last, one.alternatives[0].jump_mm)
    if one.kind == "filled":
        return nobodys(known, who[0], first, last)
    if one.kind == "ghost":
        return no_marker(known, who[0])
    if one.kind == "join" and len(who) == 2:
        return one_marker(known, *who)
    if one.kind == "join" and known.rig is None:
        mm = max((way.jump_mm for way in one.alternatives if np.isfinite(way.jump_mm)), default=0.0)
        return leapt(known, who[0], first, last, mm)
    return changed(known, who[0], first, last)


def found(known: Known, asked: Sequence[Problem]) -> dict[str, tuple[int, int]]:
    """Of each kind of seeded fault: how many have a problem worth a look at their frame, and how many there are."""
    out: dict[str, tuple[int, int]] = {}
    assert known.faulty is not None
    near, start = 0.1 * known.trajectories.rate + 2, known.trajectories.first_frame
    for kind, frame in known.faulty.done:
        hit = any(one.first - start - near <= frame <= one.last - start + near for one in asked)
        a, b = out.get(kind, (0, 0))
        out[kind] = a + hit, b + 1
    return out


def check(title: str, some: Iterator[Known]) -> None:
    rows: list[Judged] = []
    hits: dict[str, tuple[int, int]] = {}
    asked: dict[bool, list[int]] = {True: [], False: []}
    for known in some:
        of = listed(known)
        asked[known.faulty is not None].append(len(of.asked))
        judged = [(one, truth_of(known, one)) for one in of.items]
        rows += [Judged(known.name, one.kind, one.wrong, true, one.asked) for one, true in judged if true is not None]
        if known.faulty is not None:
            for kind, (a, b) in found(known, of.asked).items():
                hits[kind] = hits.get(kind, (0, 0))[0] + a, hits.get(kind, (0, 0))[1] + b
    recordings = len({row.recording for row in rows})
    print(f"\n{title}: {len(asked[False])} trials of {recordings} recordings, each as it is and with faults")
    for kind in ("all", "swap", "join", "spike", "filled", "ghost"):
        table(kind, [row for row in rows if kind in ("all", row.kind)])
    classes(rows)
    expected, true = sum(row.wrong for row in rows), sum(row.true for row in rows)
    left = [row for row in rows if not row.asked]
    said, left_true = sum(row.wrong for row in left), sum(row.true for row in left)
    print(f"  errors: expected {expected:.0f}, true {true}; below the stop rule: expected {said:.1f}, true {left_true}"
          f"; expected over true {said / max(left_true, 1):.2f} ({interval(left, ratio)})")  # fmt: skip
    for faults, name in ((False, "as they are"), (True, "with faults")):
        n = asked[faults]
        print(f"  problems worth a look, {name}: median {np.median(n):.0f}, most {max(n)}")
    print("  seeded faults with a problem: " + ", ".join(f"{k} {a} of {b}" for k, (a, b) in sorted(hits.items())))


def clean(n: int = 6) -> None:
    """Trials of 30 s in which nothing went wrong."""
    counts = []
    for seed in range(n):
        subject = walking(duration_s=30.0, rate=100.0, speed_mm_s=80.0, wobble_mm=1.0, seed=seed)
        subject = with_markers(subject, 39, apart_mm=30.0, seed=seed)
        rig = ring(8)
        detections = observe(rig, subject, noise_px=0.2, merge_px=4.0, seed=seed).detections
        tracks, decisions = track_with_decisions(detections, rig)
        known = Known("", trajectories_of(tracks), np.zeros((0, 0), np.int64), subject.xyz, detections, rig)
        counts.append((len(listed(known._replace(decisions=tuple(decisions))).asked), len(decisions)))
    print(f"\nClean trials of 30 s, 39 markers, 8 cameras: worth a look {', '.join(str(a) for a, _ in counts)}; the "
          f"tracker's own ambiguous decisions {', '.join(str(b) for _, b in counts)}")  # fmt: skip


def main(*what: Any) -> None:
    if "fit" in what:
        fit(known for some in (both(simulated(TUNE)), both(labelled(0), drawn=3)) for known in some)
    check(f"Simulated scenes {FRESH.start} to {FRESH.stop - 1}", both(simulated(FRESH)))
    check("Files of other systems, every second", both(labelled(1)))
    clean()


if __name__ == "__main__":
    main(*sys.argv[1:])
