"""Which path each witness of some stretches is on now.

Images say it where the camera has one within NEAR px of the witness's, and none other within CROWDED px; the path must
have two such images, and more than half of those that are on any path (1). A place says it where a path is within
NEAR_MM of it, and half as far as any other (2); only in the world that the place was measured in. Where both speak and
differ, the witness is silent (3).

So images carry an edit over another calibration, or a world that was moved; places carry it over images that were
measured otherwise.

A witness also denies a path that has a sample in its frame (4): where the witness is on another path; or where two or
more cameras have images of both and most are more than CROWDED px apart, or, without such images, the places are more
than FAR_MM apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ..data import Detections, MarkerTrajectory, Origin, Trajectories, Validity
from ..data.array_types import Bools, Floats, Ints
from ..data.edits import Edit, Stretch
from .crossings import unbroken

NEAR, CROWDED = 1.5, 4.5
"""px; of (1). Chosen: far above the noise of a centroid, and three times that. See studies/edits.py."""
NEAR_MM, TWICE = 10.0, 2.0
"""mm, and times; of (2). Chosen: less than markers are apart. See studies/edits.py."""
FAR_MM = 30.0
"""mm, of (4); chosen: farther than any noise, and near for two markers. See studies/edits.py."""
FEWEST = 2
"""Images that must agree; by definition of a point."""


class Votes(NamedTuple):
    """N witnesses of some stretches, in the order of these and of their frames.

    Attributes:
        stretch: (N) whose it is. frame: (N) index from 0, outside 0 … F − 1 where the trial does not have it.
        xyz: (N, 3) mm, its place, NaN where that is in another world. uv: (N, C, 2) px, its images, NaN for none.
        path: (N) index of the path that it is on; −1 where it is silent.
    """

    stretch: Ints
    frame: Ints
    xyz: Floats
    uv: Floats
    path: Ints

    def of(self, chosen: Bools) -> Votes:
        """Some of them."""
        return Votes(self.stretch[chosen], self.frame[chosen], self.xyz[chosen], self.uv[chosen], self.path[chosen])


def votes(
    stretches: Sequence[Stretch], trajectories: Trajectories, detections: Detections | None, *, world: str = ""
) -> Votes:
    """The path of each witness.

    Args:
        stretches: with their witnesses.
        trajectories: as they are now. detections: behind their samples; None for a file without its images.
        world: key of the cameras in whose world they are now.
    """
    known = known_votes(trajectories, detections, world)
    parts = [known.get(stretch) or known.setdefault(stretch, _votes(stretch, known)) for stretch in stretches]
    if not parts:
        return _votes_of((), known)
    numbers = np.repeat(np.arange(len(parts)), [len(part.frame) for part in parts])
    return Votes(numbers, *(np.concatenate(columns) for columns in list(zip(*parts, strict=True))[1:]))


class KnownVotes(dict[Stretch, Votes]):
    """Votes of one trial that were counted before: edits come one by one, and earlier ones vote as they did.

    Attributes:
        rows: what claims made of a path, by the path and the claims; for `claims`.
        own: edits that are found to be of a marker, by their ids; for `anchors`.
        placed: edits that find their samples, by their ids; moved: others, and what became of them; for `moves`.
    """

    def __init__(self, trajectories: Trajectories, detections: Detections | None, world: str) -> None:
        super().__init__()
        self.trajectories, self.detections, self.world = trajectories, detections, world
        self.rows: dict[object, tuple[Ints, Floats]] = {}
        self.own: WeakKeyDictionary[MarkerTrajectory, dict[int, Edit]] = WeakKeyDictionary()
        self.placed: dict[int, Edit] = {}
        self.moved: dict[tuple[int, ...], tuple[Sequence[Edit], list[Edit]]] = {}
        self._pieces = np.full((len(trajectories), trajectories.n_frames), -1, np.int64)

    def pieces(self, paths: Ints) -> Ints:
        """(P, F) the pieces of each path, as `crossings` has them; −1 for those that were not among `paths` (N) yet.

        All of them would take longer than whoever says the first word of a trial should wait.
        """
        new = np.unique(paths)
        new = new[self._pieces[new, :1].ravel() < 0] if self._pieces.size else new[:0]
        self._pieces[new] = unbroken([self.trajectories.paths[p] for p in new.tolist()], self.trajectories)
        return self._pieces


@lru_cache(maxsize=1)  # the trial that is edited is the same at every edit
def known_votes(trajectories: Trajectories, detections: Detections | None, world: str) -> KnownVotes:
    """Those of a trial in this world."""
    return KnownVotes(trajectories, detections, world)


def _votes(stretch: Stretch, of: KnownVotes) -> Votes:
    return _votes_of((stretch,), of)


def _votes_of(stretches: Sequence[Stretch], of: KnownVotes) -> Votes:
    """The path of each witness, all counted now."""
    trajectories, detections = of.trajectories, of.detections
    cameras = detections.cameras if detections is not None else ()
    said = witnesses_of(stretches, trajectories.first_frame, cameras, of.world)
    inside = (said.frame >= 0) & (said.frame < trajectories.n_frames)
    images = np.full(len(said.frame), -1, np.int64)
    if detections is not None:
        images[inside] = _by_images(said.of(inside), trajectories, detections)
    places = _by_place(said, inside & np.isfinite(said.xyz[:, 0]), trajectories)
    differ = (images >= 0) & (places >= 0) & (images != places)
    return said._replace(path=np.where(differ, -1, np.where(images >= 0, images, places)))  # (3)


def denies(said: Votes, p: int, trajectories: Trajectories, detections: Detections | None) -> Bools:
    """(N) whether each witness denies path p (4)."""
    there, _, far = compared(said, trajectories.paths[p], detections)
    return there & ((said.path >= 0) & (said.path != p) | (said.path < 0) & far)


class Compared(NamedTuple):
    """N witnesses beside the samples of one path: (N) whether it has one in the frame, which can be compared with the
    witness, and is clearly elsewhere (4)."""

    there: Bools
    known: Bools
    far: Bools


def compared(said: Votes, path: MarkerTrajectory, detections: Detections | None) -> Compared:
    """Witnesses of any path beside the samples of this one."""
    inside = (said.frame >= 0) & (said.frame < len(path))
    frame = np.where(inside, said.frame, 0)
    there = inside & (path.origin[frame] != Origin.MISSING)
    apart_mm = np.linalg.norm(path.xyz[frame] - said.xyz, axis=1)
    known, far = np.isfinite(apart_mm), np.nan_to_num(apart_mm) > FAR_MM
    if detections is not None and path.detection.shape[1]:
        rows = path.detection[frame]
        apart = np.linalg.norm(detections.uv[rows] - said.uv, axis=-1)
        both = (rows >= 0) & np.isfinite(apart)
        off, enough = (both & (apart > CROWDED)).sum(1), both.sum(1) >= FEWEST
        known, far = known | enough, np.where(enough, 2 * off > both.sum(1), far)
    return Compared(there, there & known, there & far)


def witnesses_of(stretches: Sequence[Stretch], first_frame: int, cameras: Sequence[str], world: str) -> Votes:
    """The witnesses as arrays, all silent."""
    rows = [(k, w) for k, stretch in enumerate(stretches) for w in stretch.witnesses]
    uv = np.full((len(rows), len(cameras), 2), np.nan)
    index = {name: c for c, name in enumerate(cameras)}
    flat = [(i, index[name], u, v) for i, (_, w) in enumerate(rows) for name, u, v in w.images if name in index]
    if flat:
        i, c, u, v = zip(*flat, strict=True)
        uv[i, c] = np.column_stack([u, v])
    stretch = np.array([k for k, _ in rows], np.int64)
    same = np.array([one.world == world for one in stretches], bool)
    xyz = np.array([w.xyz for _, w in rows], np.float64).reshape(-1, 3)
    frame = np.array([w.frame for _, w in rows], np.int64) - first_frame
    return Votes(stretch, frame, np.where(same[stretch][:, None], xyz, np.nan), uv, np.full(len(rows), -1, np.int64))


@lru_cache(maxsize=1)  # the trial that is edited is the same at every edit
def owners(trajectories: Trajectories, n_detections: int) -> Ints:
    """(D) index of the path that has each image; −1 where none or several have it."""
    owner, several = np.full(n_detections, -1, np.int64), np.zeros(n_detections, bool)
    for p, path in enumerate(trajectories):
        rows = path.detection[path.detection >= 0]
        several[rows[owner[rows] >= 0]] = True
        owner[rows] = p
    owner[several] = -1
    return owner


def nearest_images(camera: Ints, frame: Ints, uv: Floats, detections: Detections) -> Ints:
    """(N) row of the image within NEAR px of each place (N, 2) px; −1 where there is none, or another one near."""
    first = detections.start[camera, frame]
    n = detections.start[camera, frame + 1] - first
    of = np.repeat(np.arange(len(n)), n)
    row = np.arange(len(of)) - np.repeat(np.cumsum(n) - n, n) + first[of]
    kept = detections.validity[row] == Validity.VALID
    of, row = of[kept], row[kept]
    apart = np.hypot(*(detections.uv[row] - uv[of]).T)
    close = apart < CROWDED
    of, row, apart = of[close], row[close], apart[close]
    alone = np.bincount(of, minlength=len(n))[of] == 1
    hit = alone & (apart <= NEAR)
    found = np.full(len(n), -1, np.int64)
    found[of[hit]] = row[hit]
    return found


def _by_images(said: Votes, trajectories: Trajectories, detections: Detections) -> Ints:
    """The path by (1)."""
    of, camera = np.nonzero(np.isfinite(said.uv[..., 0]))
    row = nearest_images(camera, said.frame[of], said.uv[of, camera], detections)
    owner = owners(trajectories, len(detections))
    path = np.where(row >= 0, owner[row], -1) if len(owner) else np.full(len(row), -1)
    return _majority(of[path >= 0], path[path >= 0], len(said.frame))


def _majority(of: Ints, path: Ints, n: int) -> Ints:
    """(n) the path that most votes of each are for; −1 without two votes and a majority."""
    found = np.full(n, -1, np.int64)
    if not len(of):
        return found
    paths = int(path.max()) + 1
    pair, count = np.unique(of * paths + path, return_counts=True)
    whose, total = pair // paths, np.bincount(of, minlength=n)
    clear: Bools = (count >= FEWEST) & (2 * count > total[whose])
    found[whose[clear]] = pair[clear] % paths
    return found


def _by_place(said: Votes, usable: Bools, trajectories: Trajectories) -> Ints:
    """The path by (2)."""
    nearest, path = np.full(len(usable), np.inf), np.full(len(usable), -1, np.int64)
    second, rows = nearest.copy(), np.flatnonzero(usable)
    for p, one in enumerate(trajectories):
        apart = np.linalg.norm(one.xyz[said.frame[rows]] - said.xyz[rows], axis=1)
        apart = np.where(np.isnan(apart), np.inf, apart)
        closer = apart < nearest[rows]
        second[rows] = np.where(closer, nearest[rows], np.minimum(second[rows], apart))
        path[rows[closer]], nearest[rows[closer]] = p, apart[closer]
    return np.where((nearest <= NEAR_MM) & (TWICE * nearest <= second), path, -1)
