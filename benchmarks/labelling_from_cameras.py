"""From 2D points to names: tracks of simulated cameras, and of a real recording, named by another trial.

    python benchmarks/labelling_from_cameras.py [part of a row's name …] [--seeds 1 2 3] [--scenes 0 2 4 …]

Synthetic walkers with 15, 39 and 53 markers are tracked as `benchmarks/tracking.py` does it, from noisy points of which
some run together, some come from nowhere and limbs hide many, and named by a template of another walk, of another
speed, of the same person. `gait9` (KINEMARK_DATA) is tracked from its 2D points and named by its own first second, and
each half by the other; its 24 named reference tracks are the judge. Each tracked point belongs to the marker within
10 mm, one point a marker. Of the reference's stretches only those count in which no marker leaps, and samples that lie
at another marker's place are that one's (`mended`). In % of the points that have a marker: named rightly, wrongly, not
at all; named points that have none, in % of all named (for `gait9` also markers whose reference is left out); swaps,
pieces a marker and tracked points without marker a frame,
before → after naming.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np
import scipy
from metrics import Metric
from numpy.typing import NDArray

from kinemark.data import Detections, MarkerTrajectory, Rig, Tracks, Trajectories
from kinemark.engine.naming.naming import name_tracks
from kinemark.engine.naming.templates import SessionTemplate
from kinemark.io.tdf import read_tdf
from kinemark.label import Labelling, learn_template
from kinemark.synth import Subject, observe, ring, walking, with_markers
from kinemark.track.simultaneous import Simultaneous, track_detections
from support.scenes import Made, make, scene
from support.scenes.bodies import walker

ROOT = Path(os.environ.get("KINEMARK_DATA", Path(__file__).parents[2] / "shared" / "data"))
NEAR = 10.0
"""mm within which a point is a marker's; as in benchmarks/tracking.py; chosen."""

SAME_MM = 120.0
"""By which mean distances of one person's markers differ at most from walk to walk; those of others by more; chosen."""

LEAP = 25.0
"""mm off its way that a marker of the reference never is from one sample to the next; chosen: markers accelerate by
less than 20 mm in a gap of 0.04 s."""

STEADY = 8.0
"""mm by which a distance varies at most that tells where a marker is, as 1.48 times the median deviation; chosen: a
third of `LEAP`."""

WITNESSES = 2
"""Other markers at least that say whose a sample is; by definition: one is as likely wrong itself."""

LATER_S = 1.37
"""How much later the motion is that names a scene; chosen, no whole number of strides."""


class Row(NamedTuple):
    """Tracks, a template, and the truth (M, F, 3) with its names."""

    name: str
    tracks: Tracks
    template: SessionTemplate
    xyz: NDArray[np.float64]
    names: tuple[str, ...]


class Result(NamedTuple):
    """In %, and counts before and after naming."""

    right: float
    wrong: float
    unnamed: float
    strangers: float
    swaps: tuple[int, int]
    pieces: tuple[float, float]
    ghosts: tuple[float, float]


def walkers(seeds: list[int]) -> Iterator[Row]:
    """One walk names another of the same person."""
    for n, cameras, rate, noise in ((15, 6, 50.0, 0.1), (39, 6, 100.0, 0.2), (53, 8, 100.0, 0.1)):
        for seed in seeds:
            one, two = one_person(n, rate, seed)
            rig = ring(cameras, focal_px=1100.0)
            seen = observe(
                rig, one, noise_px=noise, false_per_frame=2.0, merge_px=8.0, least_visible=0.3, seed=seed
            ).detections
            template = SessionTemplate(learn_template(two.trajectories), ("another walk",))
            yield Row(f"walk {n}, {cameras} cameras, seed {seed}", tracked(seen, rig), template, one.xyz, one.names)


def scenes(seeds: list[int]) -> Iterator[Row]:
    """Scenes of the second generator, `tests/support/scenes`, named by the same person a little later.

    Scenes in which the other motion does not allow the same places of markers are left out.
    """
    for seed in seeds:
        named = named_scene(seed)
        if named is not None:
            one, (seen, template, names) = scene(seed), named
            name = f"scene {seed}, {one.motion}, {one.markers} markers, {one.cameras} cameras"
            yield Row(name, tracked(seen.detections, seen.rig), template, seen.xyz, names)


def named_scene(seed: int) -> tuple[Made, SessionTemplate, tuple[str, ...]] | None:
    """A scene, the template of the same person a little later, and the names; None where that is left out."""
    one = scene(seed)
    if one.motion == "swarm":
        return None
    t = np.arange(round(one.seconds * one.rate)) / one.rate + LATER_S
    other = walker(one.motion, one.markers, t, np.random.default_rng([one.seed, 16]), one.treadmill).xyz
    seen = make(one)
    apart = [np.linalg.norm(xyz[:, None] - xyz[None], axis=-1).mean(-1) for xyz in (seen.xyz, other)]
    if np.abs(apart[0] - apart[1]).max() > SAME_MM:
        return None
    names = tuple(f"m{k}" for k in range(one.markers))
    paths = tuple(MarkerTrajectory.measured(name, xyz) for name, xyz in zip(names, other, strict=True))
    return seen, SessionTemplate(learn_template(Trajectories(paths, one.rate)), ("later",)), names


def one_person(n: int, rate: float, seed: int) -> tuple[Subject, Subject]:
    """Two walks with markers in the same places.

    Places that come too near others in one of the walks are drawn anew there, and then all later ones differ; so places
    are drawn until both walks have the same.
    """
    walks = [
        walking(duration_s=2.0, rate=rate, seed=s, wobble_mm=3.0, marker_radius_mm=7.0, speed_mm_s=speed, phase=phase)
        for s, speed, phase in ((seed, 1100.0, 0.8), (seed + 50, 850.0, 0.3))
    ]
    for k in range(100):
        one, two = (with_markers(walk, n, seed=seed + 1000 * k) for walk in walks)
        apart = [learn_template(walk.trajectories).distance for walk in (one, two)]
        if np.nanmax(np.abs(apart[0] - apart[1])) < SAME_MM:
            return one, two
    raise RuntimeError(f"{n} markers find no places that both walks allow")


def tracked(detections: Detections, rig: Rig) -> Tracks:
    """By the default tracker."""
    return track_detections(detections, rig, method=Simultaneous())


def real() -> Iterator[Row]:
    """`gait9`, where it is."""
    file = ROOT / "cameras/gait9_bts/gait9.tdf"
    if not file.is_file():
        return
    tdf = read_tdf(file)
    assert tdf.rig and tdf.detections and tdf.trajectories
    named = [name for name in tdf.trajectories.names if is_name(name)]
    reference = mended(tdf.trajectories.select(named))
    tracks = tracked(tdf.detections, tdf.rig)
    F, second = reference.n_frames, round(reference.rate)
    first = max(int(np.isfinite(path.xyz[:, 0]).argmax()) for path in reference)  # all have begun
    parts = (
        ("its first second", first, first + second, 0, F),
        ("the second half names the first", F // 2, F, 0, F // 2),
        ("the first half names the second", 0, F // 2, F // 2, F),
    )
    for title, a, b, c, d in parts:
        template = SessionTemplate(learn_template(reference.frames(a, b)), (title,))
        judge = reference.xyz[:, c:d].copy()
        if (c, d) == (0, F):
            judge[:, a:b] = np.nan  # of these the template has the names
        yield Row(f"gait9, {title}", between(tracks, c, d), template, judge, tuple(named))


def mended(reference: Trajectories) -> Trajectories:
    """Of each marker the longest stretch in which it never leaps to another's place: `LEAP` off the way that it goes.

    The system that stored the tracks lets them do so, most of all where the subject enters and leaves the volume. It
    also lets them glide over, so that samples that lie at an absent marker's place are that one's (`whose`). None is
    left out for that: what a labelling leaves without a name there counts against it.
    """
    paths = []
    for path in reference:
        seen = np.flatnonzero(np.isfinite(path.xyz[:, 0]))
        cuts = [k + 1 for k in range(2, len(seen) - 3) if leaps(path.xyz, seen[k - 2 : k + 4])]
        parts = np.split(seen, cuts)
        longest = max(parts, key=len)
        xyz = np.full_like(path.xyz, np.nan)
        xyz[longest] = path.xyz[longest]
        paths.append(MarkerTrajectory.measured(path.name, xyz))
    xyz = np.stack([path.xyz for path in paths])
    own, new = whose(xyz), np.full_like(xyz, np.nan)
    for a, f in np.argwhere(np.isfinite(xyz[..., 0])):
        new[own[a, f], f] = xyz[a, f]
    return replace(
        reference,
        paths=tuple(MarkerTrajectory.measured(path.name, one) for path, one in zip(paths, new, strict=True)),
    )


def whose(xyz: NDArray[np.float64]) -> NDArray[np.int64]:
    """(M, F) which marker the samples (M, F, 3) mm of each are: itself, or an absent one whose distances they have.

    No name is asked for that, nor a template: the recording itself shows how far its markers are from each other. A
    sample is another's only where it is `LEAP` off its own steadiest distance, and within `NEAR` of the other's in the
    median.
    """
    apart = np.linalg.norm(xyz[:, None] - xyz[None], axis=3)
    apart[np.eye(len(xyz), dtype=bool)] = np.nan
    some = np.isfinite(apart).any(2)
    mean, varies = np.full(some.shape, np.nan), np.full(some.shape, np.inf)
    mean[some] = np.nanmedian(apart[some], axis=1)
    varies[some] = 1.48 * np.nanmedian(np.abs(apart[some] - mean[some][:, None]), axis=1)
    steady = np.where(varies <= STEADY, mean, np.nan)
    out = np.tile(np.arange(len(xyz))[:, None], xyz.shape[1])
    for a, f in np.argwhere(np.isfinite(xyz[..., 0])):
        off = np.abs(apart[a, :, f] - steady)  # as each marker, by each other
        tells = np.isfinite(off[a])
        if not tells.any() or off[a, np.where(tells, varies[a], np.inf).argmin()] <= LEAP:
            continue
        could = np.flatnonzero(np.isnan(xyz[:, f, 0]) & (np.isfinite(off).sum(1) >= WITNESSES))
        middle = np.nanmedian(off[could], axis=1)
        if middle.min(initial=np.inf) < NEAR:
            out[a, f] = could[middle.argmin()]
    return out


def leaps(xyz: NDArray[np.float64], frame: NDArray[np.int64]) -> bool:
    """Whether a marker leaps between the third and the fourth of six frames, by the speeds before and after."""
    a, b, c, d = xyz[frame[[0, 2, 3, 5]]]
    speed = (b - a) / (frame[2] - frame[0]) + (d - c) / (frame[5] - frame[3])
    return bool(np.linalg.norm(c - b - speed / 2 * (frame[3] - frame[2])) > LEAP)


def is_name(name: str) -> bool:
    """Whether somebody gave it: tracks of the system itself are numbered."""
    return bool(name.strip()) and not name.startswith("*") and not re.fullmatch(r"Mk\d+", name.strip())


def between(tracks: Tracks, first: int, stop: int) -> Tracks:
    """The tracks of frames first … stop − 1."""
    own = (tracks.cloud.frame >= first) & (tracks.cloud.frame < stop)
    cloud = tracks.cloud.keep(own)
    start = cloud.start[first : stop + 1] - cloud.start[first]
    _, number = np.unique(tracks.id[own], return_inverse=True)
    number = np.asarray(number) - int((tracks.id[own] < 0).any())
    return Tracks(type(cloud)(cloud.rate, start, cloud.xyz, cloud.cov, cloud.residual, cloud.detection), number)


def owners(tracks: Tracks, xyz: NDArray[np.float64]) -> NDArray[np.int64]:
    """(P) the marker of each tracked point, −1 for none."""
    cloud, owner = tracks.cloud, np.full(len(tracks.cloud), -1)
    for f in range(cloud.n_frames):
        rows = np.arange(len(cloud))[cloud.rows(f)]
        rows = rows[tracks.id[rows] >= 0]
        apart = np.linalg.norm(cloud.xyz[rows][:, None] - xyz[:, f], axis=-1)
        cost = np.where(apart < NEAR, apart, 1e3)
        i, j = scipy.optimize.linear_sum_assignment(cost)
        good = cost[i, j] < NEAR
        owner[rows[i[good]]] = j[good]
    return owner


def changes(identity: NDArray[np.int64], owner: NDArray[np.int64], frame: NDArray[np.int64]) -> tuple[int, float]:
    """How often a track goes over to another marker, and how many tracks a marker has."""
    rows = np.flatnonzero((owner >= 0) & (identity >= 0))
    rows = rows[np.lexsort([frame[rows], identity[rows]])]
    a, b = rows[:-1], rows[1:]
    pairs = np.unique(np.column_stack([owner[rows], identity[rows]]), axis=0)
    swaps = int(((identity[a] == identity[b]) & (owner[a] != owner[b])).sum())
    return swaps, len(pairs) / max(len(np.unique(pairs[:, 0])), 1)


def result(row: Row) -> Result:
    """One row."""
    found = name_tracks(row.tracks, {"": row.template}, how=Labelling())
    owner, frame, F = owners(row.tracks, row.xyz), row.tracks.cloud.frame, row.tracks.cloud.n_frames
    after = found.tracks.id
    name = np.array([*found.names, ""], object)[after]
    is_named = np.array([bool(n) and not n.startswith("*") for n in name])
    truth = np.array([*row.names, ""], object)[owner]
    has = owner >= 0
    good = has & is_named & (name == truth)
    total = max(int(has.sum()), 1)
    before, now = (changes(identity, owner, frame) for identity in (row.tracks.id, after))
    ghosts = [float(((identity >= 0) & ~has).sum() / F) for identity in (row.tracks.id, after)]
    return Result(
        100 * good.sum() / total,
        100 * (has & is_named & ~good).sum() / total,
        100 * (has & ~is_named).sum() / total,
        100 * (is_named & ~has).sum() / max(is_named.sum(), 1),
        (before[0], now[0]), (before[1], now[1]), (ghosts[0], ghosts[1]),
    )  # fmt: skip


def metrics() -> list[Metric]:
    """For `compare.py`: the walkers."""
    out = []
    for row in walkers([2]):
        one = result(row)
        out.append(Metric(f"right, {row.name}", one.right, "%", "more", absolute=0.5))
        out.append(Metric(f"wrong, {row.name}", one.wrong, "%", "less", absolute=0.05))
    return out


def main() -> None:
    """Do what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--seeds", type=int, nargs="*", default=[1, 2, 3])
    parser.add_argument("--scenes", type=int, nargs="*", default=[])
    asked = parser.parse_args()
    head = ("right", "wrong", "unnamed", "strangers", "swaps", "pieces a marker", "ghosts a frame")
    print(f"{'':40s}" + "".join(f"{one:>10s}" for one in head[:4]) + "".join(f"{one:>18s}" for one in head[4:]))
    for rows in (walkers(asked.seeds), real(), scenes(asked.scenes)):
        for row in rows:
            if asked.names and not any(name in row.name for name in asked.names):
                continue
            one = result(row)
            figures = "".join(f"{value:10.2f}" for value in one[:4])
            pairs = f"{one.swaps[0]:d} → {one.swaps[1]:d}".rjust(18) + "".join(
                f"{a:.2f} → {b:.2f}".rjust(18) for a, b in (one.pieces, one.ghosts)
            )
            print(f"{row.name:40s}{figures}{pairs}", flush=True)


if __name__ == "__main__":
    main()
