"""How good tracks are, where the truth, or another system's trajectories, is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ..data import Tracks
from ..data.array_types import Bools, Floats, Ints
from ..signal import assign

SLACK = 3  # frames; a path may end or begin this much beside the moment at which a track changes over; chosen


@dataclass(frozen=True, slots=True, eq=False)
class Score:
    """Tracks against true paths.

    Attributes:
        owner: (P) the true path of each tracked point, −1 where none is near.
        distance: (P) from it, mm; NaN where none.
        recall: share of the true samples to be found that a tracked point is near.
        precision: share of the tracked points that are near one.
        extra_per_frame: tracked points near none: ghosts.
        rmse: root mean square distance of the others in 3D, mm; median, p95: of their distance, mm.
        coverage: share of them whose 95 % ellipsoid of covariance holds the truth; points without a covariance apart.
        chi2: mean of their squared distance in units of that covariance, a third of it: 1 where it is true.
        swaps: times that a track goes over from a path that goes on, or to one that was there before.
        handovers: times that a path goes over from one track to another.
        fragments: (M) tracks that share each true path.
        best: (M) share of the samples of each path to be found that its best track has; NaN where there are none.
    """

    owner: Ints
    distance: Floats
    recall: float
    precision: float
    extra_per_frame: float
    rmse: float
    median: float
    p95: float
    coverage: float
    chi2: float
    swaps: int
    handovers: int
    fragments: Ints
    best: Floats

    @property
    def found(self) -> int:
        """True paths of which any sample was found."""
        return int((self.fragments > 0).sum())


def score(
    tracks: Tracks, truth: Floats, *, seen: Bools | None = None, within: float = 10.0, xyz: Floats | None = None
) -> Score:
    """Compare tracks with true paths.

    Args:
        tracks: points without an identity are left out.
        truth: (M, F, 3) mm, NaN where a path is not.
        seen: (M, F) which samples are to be found, as those that two cameras see; all that are there where None.
        within: farthest that a point may lie from the truth to count as it, mm.
        xyz: (P, 3) positions to be used instead of the cloud's own, mm.

    Raises:
        ValueError: truth or seen is of another number of frames or paths.
    """
    cloud = tracks.cloud
    if truth.shape[1:] != (cloud.n_frames, 3):
        raise ValueError(f"truth has shape {truth.shape}, wanted (any, {cloud.n_frames}, 3)")
    if seen is not None and seen.shape != truth.shape[:2]:
        raise ValueError(f"seen has shape {seen.shape}, wanted {truth.shape[:2]} as truth")
    there = ~np.isnan(truth[..., 0])
    wanted = there if seen is None else there & seen
    owner, distance = _owners(tracks, truth, cloud.xyz if xyz is None else xyz, within)
    near = owner >= 0
    difference = (cloud.xyz if xyz is None else xyz)[near] - truth[owner[near], cloud.frame[near]]
    squared = (difference * np.linalg.solve(cloud.cov[near], difference[..., None])[..., 0]).sum(-1)
    squared = squared[~np.isnan(squared)]
    tracked = tracks.id >= 0
    found = wanted[owner[near], cloud.frame[near]]
    unknown = float("nan")
    return Score(
        owner=owner,
        distance=distance,
        recall=float(found.sum() / max(wanted.sum(), 1)),
        precision=float(near.sum() / max(tracked.sum(), 1)),
        extra_per_frame=float((tracked & ~near).sum() / max(cloud.n_frames, 1)),
        rmse=float(np.sqrt((difference**2).sum(1).mean())) if near.any() else unknown,
        median=float(np.median(distance[near])) if near.any() else unknown,
        p95=float(np.percentile(distance[near], 95)) if near.any() else unknown,
        coverage=float((squared <= 2 * scipy.special.gammaincinv(1.5, 0.95)).mean()) if len(squared) else unknown,
        chi2=float(squared.mean() / 3) if len(squared) else unknown,
        swaps=len(changes(tracks, owner, truth)),
        handovers=_handovers(tracks, owner),
        fragments=_fragments(tracks, owner, len(truth)),
        best=_best(tracks, owner, wanted),
    )


def _owners(tracks: Tracks, truth: Floats, xyz: Floats, within: float) -> tuple[Ints, Floats]:
    """The path of each point and the distance from it, by the assignment that is nearest in each frame."""
    cloud = tracks.cloud
    owner, distance = np.full(len(cloud), -1), np.full(len(cloud), np.nan)
    for f in range(cloud.n_frames):
        points = np.arange(len(cloud))[cloud.rows(f)]
        points = points[tracks.id[points] >= 0]
        there = np.flatnonzero(~np.isnan(truth[:, f, 0]))
        cost = np.linalg.norm(xyz[points][:, None] - truth[there, f], axis=-1)
        i, j = assign(cost, np.full(len(points), within))
        owner[points[i]], distance[points[i]] = there[j], cost[i, j]
    return owner, distance


def changes(tracks: Tracks, owner: Ints, truth: Floats) -> list[tuple[int, int, int, int]]:
    """Swaps: track, the frame after which it changes over, and the paths from and to which it does.

    Args:
        tracks: of P points. owner: (P) the path that each is of, −1 for none. truth: (M, F, 3) mm of the paths.
    """
    there = ~np.isnan(truth[..., 0])
    first = np.where(there.any(1), there.argmax(1), truth.shape[1])
    last = np.where(there.any(1), truth.shape[1] - 1 - there[:, ::-1].argmax(1), -1)
    rows = np.flatnonzero(owner >= 0)
    rows = rows[np.lexsort([tracks.cloud.frame[rows], tracks.id[rows]])]
    a, b = rows[:-1], rows[1:]
    over = np.flatnonzero((tracks.id[a] == tracks.id[b]) & (owner[a] != owner[b]))
    a, b = a[over], b[over]
    frame = tracks.cloud.frame
    swap = (last[owner[a]] > frame[b] + SLACK) | (first[owner[b]] < frame[a] - SLACK)
    return [
        (int(tracks.id[i]), int(frame[i]), int(owner[i]), int(owner[j])) for i, j in zip(a[swap], b[swap], strict=True)
    ]


def _fragments(tracks: Tracks, owner: Ints, n_paths: int) -> Ints:
    """(M) how many tracks have a point on each path."""
    near = owner >= 0
    pairs = np.unique(np.column_stack([owner[near], tracks.id[near]]), axis=0)
    return np.bincount(pairs[:, 0], minlength=n_paths)


def _handovers(tracks: Tracks, owner: Ints) -> int:
    """How often the next point of a path is another track's."""
    rows = np.flatnonzero(owner >= 0)
    rows = rows[np.lexsort([tracks.cloud.frame[rows], owner[rows]])]
    a, b = rows[:-1], rows[1:]
    return int(((owner[a] == owner[b]) & (tracks.id[a] != tracks.id[b])).sum())


def _best(tracks: Tracks, owner: Ints, wanted: Bools) -> Floats:
    """(M) share of the wanted samples of each path that the track has that has most of them."""
    near = np.flatnonzero(owner >= 0)
    near = near[wanted[owner[near], tracks.cloud.frame[near]]]
    pairs, n = np.unique(np.column_stack([owner[near], tracks.id[near]]), axis=0, return_counts=True)
    most = np.zeros(len(wanted))
    np.maximum.at(most, pairs[:, 0], n)
    total = wanted.sum(1)
    return np.where(total > 0, most / np.maximum(total, 1), np.nan)
