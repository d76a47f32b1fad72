"""Which marker is it that comes back? Walks with occlusions of 0.3 to 2 s, tracked, and named by another walk.

Groups of one, two, three or eight neighbouring markers are hidden from all cameras for a while, and come back together.
After each occlusion it is asked, by the points of the first fifth of a second in which the marker is seen again,

    tracker   whether they go on the marker's track (right), begin one of their own (new), or belong to a track that was
              another marker's, or whose marker's track now is another's (wrong)
    distances whether the tracks are among the likely continuations that the report lists (right), or others are (wrong)
    names     whether they bear the marker's name (right), none, or another's (wrong), where the session has `[label]`
              and a labelled walk of the same person

Walkers of 15, 39 and 53 markers are simulated; children's walks are recorded ones (KINEMARK_DATA), seen by simulated
cameras. Ties of chance: the groups, their times, the noise.

Run: python studies/occlusions.py [first seed, 1] [seeds, 2] [part of a walk's name …]
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinemark.data import Detections, Rig, Trajectories
from kinemark.data.array_types import Bools, Floats, Ints
from kinemark.engine.naming.naming import name_tracks
from kinemark.engine.naming.templates import SessionTemplate
from kinemark.io.trial import read_trial
from kinemark.label import Labelling, learn_template
from kinemark.synth import Subject, from_trajectories, observe, ring, walking, with_markers
from kinemark.track.simultaneous import Simultaneous, track_detections
from kinemark.track.simultaneous.joining.continuations import continuations

ROOT = Path(os.environ.get("KINEMARK_DATA", Path(__file__).parents[2] / "shared" / "data")) / "mocap3d"
LENGTHS = (0.3, 0.5, 1.0, 1.5, 2.0)
"""Of occlusions, s."""
GROUPS = 10
"""Of markers that are hidden, a walk."""
SIZES = (1, 2, 3, 8)
"""Of a group; the greatest is a limb."""
SIDE = 0.2
"""Of a path that tells its identity before and after an occlusion, s."""
NEAR = 15.0
"""mm within which a point is a marker's."""
CHILDREN = {
    "HC030A": ("pig_gait_child", "22", "05"),
    "HC031A": ("pig_gait_children", "23", "06"),
    "HC032A": ("pig_gait_children", "18", "03"),
    "HC002D": ("pig_gait_children", "25", "06"),
}
"""Folder, the walk that is tracked, and the one that names it."""
WALKERS = ((15, 50.0, 0.1), (39, 100.0, 0.2), (53, 100.0, 0.1))
"""Markers, Hz and noise, px."""


KINDS = "right", "none", "wrong"
"""What becomes of an identity."""
MARKERS = """
    LFHD LBHD RFHD RBHD C7 T2 T6 T10 T12 RBAK CLAV STRN LSHO LELB LWRA LWRB LFIN RSHO RELB RWRA RWRB RFIN SACR RASI
    LASI LTHI LKNE LHFB LTUB LTIB LSHN LANK LHEE LCPG LLCA LSTL LNAV LP1M LP5M LD5M LTOE LHLX RTHI RKNE RHFB RTUB RTIB
    RSHN RANK RHEE RCPG RLCA RSTL RNAV RP1M RP5M RD5M RTOE RHLX"""
"""Of the children: their files have computed points beside."""
EXCHANGED = {"HC032A": {"RHLX", "RNAV"}}
"""Markers whose names are exchanged within the reference itself."""


class Walk(NamedTuple):
    """A subject, and what names it."""

    name: str
    subject: Subject
    template: SessionTemplate
    noise_px: float
    cameras: int


class Occlusion(NamedTuple):
    """A marker hidden in frames first … stop − 1."""

    marker: int
    first: int
    stop: int
    seconds: float


class Seen(NamedTuple):
    """What became of an occlusion: its length in s, "right", "new", "wrong" or "absent" by tracks; by likely
    continuations and by names "right", "none", "wrong" or "absent"."""

    seconds: float
    tracker: str
    distances: str
    names: str


def walks(seed: int) -> Iterator[Walk]:
    """All that there are, with noise and simulated bodies of this seed."""
    for n, rate, noise in WALKERS:
        one, later = (
            walking(duration_s=5.0, rate=rate, seed=s, wobble_mm=3.0, marker_radius_mm=7.0, speed_mm_s=v, phase=p)
            for s, v, p in ((seed, 800.0, 0.8), (seed + 50, 700.0, 0.3))
        )
        again = with_markers(later, n, seed=seed).trajectories
        template = SessionTemplate(learn_template(again), ("another walk",))
        yield Walk(f"simulated, {n} markers", with_markers(one, n, seed=seed), template, noise, 6)
    for name, (folder, walk, other) in CHILDREN.items():
        files = [ROOT / folder / f"{name}{number}.c3d" for number in (walk, other)]
        if all(file.is_file() for file in files):
            trial, named = (read_trial(file).trajectories for file in files)
            both = [m for m in markers_of(trial) if m in named.names and m not in EXCHANGED.get(name, ())]
            template = SessionTemplate(learn_template(named.select(both)), ("another walk",))
            subject = from_trajectories(trial.select(both))
            yield Walk(f"recorded, {name}, {len(both)} markers", subject, template, 0.2, 8)


def markers_of(trial: Trajectories) -> list[str]:
    """Those that are seen in all frames."""
    return [name for name in MARKERS.split() if name in trial.names and np.isfinite(trial[name].xyz).all()]


def occlusions(subject: Subject, seed: int) -> list[Occlusion]:
    """Of groups of neighbours, none of a marker twice within a second."""
    rng = np.random.default_rng([seed, len(subject)])
    rate, n_frames = subject.rate, subject.n_frames
    busy, found = np.zeros((len(subject), n_frames), bool), list[Occlusion]()
    apart = np.linalg.norm(subject.xyz[:, None, 0] - subject.xyz[None, :, 0], axis=-1)
    for _ in range(20 * GROUPS):
        seconds = float(rng.choice(LENGTHS))
        n, margin = round(seconds * rate), round(0.5 * rate)
        if n_frames <= n + 2 * margin:
            continue
        first = int(rng.integers(margin, n_frames - n - margin))
        group = np.argsort(apart[rng.integers(len(subject))])[: rng.choice(SIZES)]
        if busy[group, first - margin : first + n + margin].any():
            continue
        busy[group, first - margin : first + n + margin] = True
        found += [Occlusion(int(marker), first, first + n, seconds) for marker in group]
        if len({(one.first, one.stop) for one in found}) == GROUPS:
            break
    return found


def hidden(walk: Walk, rig: Rig, gone: list[Occlusion], seed: int) -> Detections:
    """What the cameras see, without the hidden markers."""
    seen = observe(rig, walk.subject, noise_px=walk.noise_px, false_per_frame=1.0, dropout=0.02, seed=seed)
    mask, frame = np.ones(len(seen.marker), bool), seen.detections.frame
    for one in gone:
        mask &= ~((seen.marker == one.marker) & (frame >= one.first) & (frame < one.stop))
    return seen.detections.keep(mask)


def rig_about(subject: Subject, cameras: int) -> Rig:
    """A ring about the walk, wide enough for it."""
    low, high = subject.xyz.min((0, 1)), subject.xyz.max((0, 1))
    reach = float(np.linalg.norm((high - low)[:2])) / 2
    return ring(cameras, target=(low + high) / 2, radius=3000.0 + 1.2 * reach, focal_px=1100.0, volume=[low, high])


def commonest(values: NDArray[np.generic]) -> int | str | None:
    """None of none."""
    if not len(values):
        return None
    known, count = np.unique(values, return_counts=True)
    return known[np.argmax(count)].item()


def owners(xyz: Floats, frame: Ints, own: Floats) -> Bools:
    """(P) which points (P, 3) mm of frames (P) are a marker's, whose path is (F, 3) mm."""
    return np.asarray(np.linalg.norm(xyz - own[frame], axis=1) < NEAR)


def judged(walk: Walk, seed: int) -> list[Seen]:
    """What became of each occlusion of a walk."""
    rig, gone = rig_about(walk.subject, walk.cameras), occlusions(walk.subject, seed)
    tracks = track_detections(hidden(walk, rig, gone, seed), rig, method=Simultaneous())
    found = name_tracks(tracks, {"": walk.template}, how=Labelling())
    xyz, side = walk.subject.xyz, round(SIDE * walk.subject.rate)
    named = np.array([*found.names, "*"], object).astype(str)[found.tracks.id]
    frame = tracks.cloud.frame

    def about(marker: int, first: int, stop: int, of: NDArray[np.generic], points: Floats) -> int | str | None:
        near = (frame >= first) & (frame < stop) & (tracks.id >= 0)
        near[near] = owners(points[near], frame[near], xyz[marker])
        return commonest(of[near])

    on = {int(a): int(b) for a, b in continuations(tracks)}
    out = []
    for one in gone:
        ends = (one.first - side, one.first), (one.stop, one.stop + side)
        before, after = (about(one.marker, *end, tracks.id, tracks.cloud.xyz) for end in ends)
        others = [m for m in range(len(xyz)) if m != one.marker]
        was = {about(m, *ends[0], tracks.id, tracks.cloud.xyz) for m in others}
        now = {about(m, *ends[1], tracks.id, tracks.cloud.xyz) for m in others}
        if before is None or after is None:
            tracker = distances = "absent"
        else:
            tracker = "right" if before == after else "wrong" if after in was or before in now else "new"
            distances = tracker if tracker != "new" else going_on(on, int(before), int(after))
        name = about(one.marker, *ends[1], named, tracks.cloud.xyz)
        names = "absent" if name is None else "right" if name == walk.subject.names[one.marker] else "wrong"
        out.append(Seen(one.seconds, tracker, distances, "none" if str(name).startswith("*") else names))
    return out


def going_on(on: dict[int, int], before: int, after: int) -> str:
    """Whether the later track goes on the earlier one, by a dictionary of what goes on what."""
    if on.get(before) == after:
        return "right"
    return "wrong" if before in on or after in on.values() else "none"


def line(words: str, seen: list[Seen]) -> str:
    """Shares in %, of those that are not absent."""
    cells = []
    columns = {"tracker": ("right", "new", "wrong")} | dict.fromkeys(("distances", "names"), KINDS)
    for column, kinds in columns.items():
        said = [getattr(one, column) for one in seen]
        known = [one for one in said if one != "absent"]
        cells += [f"{100 * known.count(kind) / max(len(known), 1):9.1f}" for kind in kinds]
    absent = sum(one.tracker == "absent" for one in seen)
    return f"{words:32s}{len(seen):8d}{absent:8d}" + "".join(cells)


def main() -> None:
    first, n = (int(arg) for arg in (sys.argv[1:3] if len(sys.argv) > 2 else ("1", "2")))
    heads = "tracker, %", "likely continuations, %", "names, %"
    print(" " * 48 + "".join(f"{head:>27s}" for head in heads))
    print(
        f"{'walk':32s}{'markers':>8s}{'absent':>8s}"
        + "".join(f"{k:>9s}" for k in ("right", "new", "wrong", *KINDS, *KINDS))
    )
    all_seen = list[Seen]()
    for seed in range(first, first + n):
        for walk in walks(seed):
            if len(sys.argv) > 3 and not any(part in walk.name for part in sys.argv[3:]):
                continue
            seen = judged(walk, seed)
            all_seen += seen
            print(line(f"{walk.name}, {seed}", seen), flush=True)
    for seconds in LENGTHS:
        print(line(f"hidden for {seconds} s", [one for one in all_seen if one.seconds == seconds]))
    print(line("all", all_seen))


if __name__ == "__main__":
    main()
