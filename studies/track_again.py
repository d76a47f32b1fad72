"""Does tracking again with what was said mend the neighbourhood of a correction, and does it ever harm?

Markers of known paths are observed by 3 to 12 cameras and tracked (seeds of SCENES and more: scenes of all kinds, with
images that are lost, merged and false); then the tracks of two that are near to each other
are exchanged from a frame on, as after a wrong decision. A person names both tracks and says of one of them from where
it is the other marker: at the frame itself, some frames LATE, or as many early. What the journal then makes of the
tracks is compared with what it makes of the tracks that were made again with the same entries as facts: samples of the
two markers that are right and wrong, and samples of all other tracks, which must stay as they are.

Run: python studies/track_again.py [first seed [last seed]]        seeds 0 to 17 where nothing is given
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from kinemark.data import Detections, Rig, Tracks, Trajectories
from kinemark.data.array_types import Floats, Ints
from kinemark.data.edits import Claim, Entry
from kinemark.edit import replay, stretch_of
from kinemark.engine.editing.retracking import facts_of_tracks
from kinemark.engine.keys import world_key
from kinemark.track import to_trajectories
from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.facts import mended_tracks
from support.laboratory import observe, ring
from support.motions import swarm
from support.scenes import make, scene

FRAMES = 150
SCENES = 100
LATE = 4  # frames by which a person points too late or too early
FAR = 10.0  # mm; a sample is of the nearest true marker within


class Seen(NamedTuple):
    """A recording with its truth (M, F, 3) mm, and its tracks."""

    truth: Floats
    rig: Rig
    detections: Detections
    tracks: Tracks


class Score(NamedTuple):
    """Samples of the two markers that are right, and wrong; and samples of other tracks."""

    right: int
    wrong: int
    others: int


def recorded(seed: int) -> Seen:
    """A recording whose cameras, markers, noise and rate go by its seed."""
    if seed >= SCENES:
        made = make(scene(seed - SCENES))
        return Seen(made.xyz, made.rig, made.detections, track_detections(made.detections, made.rig))
    rng = np.random.default_rng([seed, 17])
    cameras, markers = 3 + seed % 10, int(rng.integers(8, 25))
    rate, noise = float(rng.choice([50.0, 100.0, 200.0])), float(rng.choice([0.1, 0.2, 0.4]))
    truth, rig = swarm(n=markers, frames=FRAMES, rate=rate, seed=seed), ring(cameras)
    detections, _ = observe(rig, truth, noise=noise, rate=rate, seed=seed)
    return Seen(truth, rig, detections, track_detections(detections, rig))


def owner_of(seen: Seen, xyz: Floats) -> Ints:
    """(F) the true marker of each sample of a path (F, 3), −1 for none."""
    apart = np.linalg.norm(seen.truth - xyz, axis=-1)
    apart = np.where(np.isfinite(apart), apart, np.inf)
    return np.where(apart.min(0) < FAR, apart.argmin(0), -1)


def exchanged(seen: Seen, rng: np.random.Generator) -> tuple[Tracks, int, tuple[int, int]]:
    """The tracks with the nearest two of a frame exchanged from there on."""
    cloud, id = seen.tracks.cloud, seen.tracks.id.copy()
    at = int(rng.integers(cloud.n_frames // 4, 3 * cloud.n_frames // 4))
    rows = np.flatnonzero((cloud.frame == at) & (id >= 0) & (seen.tracks.lengths[id] > cloud.n_frames // 2))
    apart = np.linalg.norm(cloud.xyz[rows, None] - cloud.xyz[rows], axis=-1) + np.diag(np.full(len(rows), np.inf))
    i, j = (int(id[rows[k]]) for k in np.unravel_index(int(apart.argmin()), apart.shape))
    late = cloud.frame >= at
    id[late & (seen.tracks.id == i)], id[late & (seen.tracks.id == j)] = j, i
    return Tracks(cloud, id), at, (i, j)


def said_of(seen: Seen, tracks: Tracks, two: tuple[int, int], frame: int) -> list[Entry]:
    """Both tracks are named, and the second is the first from a frame of the recording on."""
    world, trajectories = world_key(seen.rig), to_trajectories(tracks, seen.rig)

    def claim(k: int, name: str, first: int | None = None) -> Claim:
        path = trajectories.names[k]
        return Claim(stretch_of(trajectories, path, first=first, detections=seen.detections, world=world), name)

    said = [claim(two[0], "A"), claim(two[1], "B"), claim(two[1], "A", frame)]
    return [Entry(k + 1, "", "study", "", "", "", (one,)) for k, one in enumerate(said)]


def judged(seen: Seen, tracks: Tracks, said: list[Entry], markers: tuple[int, int]) -> Score:
    """The journal replayed on tracks."""
    paths: Trajectories = replay(
        to_trajectories(tracks, seen.rig),
        said,
        detections=seen.detections,
        rig=seen.rig,
        world=world_key(seen.rig),
        facts=True,
    ).trajectories
    right = wrong = others = 0
    for path in paths:
        own = owner_of(seen, path.xyz)
        if path.name in "AB":
            true = markers["AB".index(path.name)]
            right, wrong = right + int((own == true).sum()), wrong + int(((own >= 0) & (own != true)).sum())
        else:
            others += int(((own >= 0) & ~np.isin(own, markers)).sum())
    return Score(right, wrong, others)


def main(first: int = 0, last: int = 17) -> None:
    """Print a line for each seed and way of pointing, and the sums."""
    print(f"{'seed':>4}{'cameras':>8}{'pointed':>9}   right, wrong, others: by the journal alone, and tracked again")
    worse, sums = 0, np.zeros((2, 3), int)
    for seed in range(first, last + 1):
        seen = recorded(seed)
        wrong, at, two = exchanged(seen, np.random.default_rng(seed))
        before = [np.flatnonzero((seen.tracks.id == k) & (seen.tracks.cloud.frame < at)) for k in two]
        markers = tuple(int(np.bincount(owner_at(seen, rows)).argmax()) for rows in before)
        for off in (0, LATE, -LATE):
            said = said_of(seen, wrong, two, at + 1 + off)
            facts = facts_of_tracks(wrong, said, seen.detections, seen.rig)
            again = mended_tracks(seen.detections, seen.rig, wrong, facts).tracks
            scores = np.array([judged(seen, t, said, markers) for t in (wrong, again)])  # type: ignore[arg-type]
            worse += bool(scores[1, 0] < scores[0, 0] or scores[1, 1] > scores[0, 1] or scores[1, 2] < scores[0, 2])
            sums += scores
            print(f"{seed:4}{len(seen.rig):8}{off:+9}{'':18}{scores[0]}{'':18}{scores[1]}", flush=True)
    print(f"all {'':35}{sums[0]}{'':18}{sums[1]}   worse in {worse}")


def owner_at(seen: Seen, rows: Ints) -> Ints:
    """The true markers nearest to points of the tracks."""
    cloud = seen.tracks.cloud
    return np.linalg.norm(seen.truth[:, cloud.frame[rows]] - cloud.xyz[rows], axis=-1).argmin(0)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
