"""How good tracks are, where the truth, or another system's trajectories, is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

from .data import Tracks
from .signal import assign

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SLACK = 3  # frames; a path may end or begin this much beside the moment at which a track changes over


@dataclass(frozen=True, slots=True, eq=False)
class Score:
    """Tracks against true paths.

    Attributes:
        owner: (P) the true path of each tracked point, −1 where none is near.
        distance: (P) from it, mm; NaN where none.
        recall: share of the true samples that a tracked point is near.
        extra_per_frame: tracked points near none.
        rmse: root mean square distance of the others in 3D, mm; median, p95: of their distance, mm.
        coverage: share of them whose 95 % ellipsoid of covariance holds the truth.
        swaps: times that a track goes over from a path that goes on, or to one that was there before.
        pieces: (M) tracks that share each true path.
    """

    owner: Ints
    distance: Floats
    recall: float
    extra_per_frame: float
    rmse: float
    median: float
    p95: float
    coverage: float
    swaps: int
    pieces: Ints

    @property
    def found(self) -> int:
        """True paths of which any sample was found."""
        return int((self.pieces > 0).sum())


def score(tracks: Tracks, truth: Floats, *, within: float = 10.0, xyz: Floats | None = None) -> Score:
    """Compare tracks with true paths.

    Args:
        tracks: points without an identity are left out.
        truth: (M, F, 3) mm, NaN where a path is not.
        within: farthest that a point may lie from the truth to count as it, mm.
        xyz: (P, 3) positions to be used instead of the cloud's own, mm.

    Raises:
        ValueError: truth is of another number of frames.
    """
    cloud = tracks.cloud
    if truth.shape[1:] != (cloud.n_frames, 3):
        raise ValueError(f"truth has shape {truth.shape}, wanted (any, {cloud.n_frames}, 3)")
    xyz = cloud.xyz if xyz is None else xyz
    tracked = tracks.id >= 0
    owner, distance = np.full(len(cloud), -1), np.full(len(cloud), np.nan)
    for f in range(cloud.n_frames):
        points = np.arange(len(cloud))[cloud.rows(f)]
        points = points[tracked[points]]
        there = np.flatnonzero(~np.isnan(truth[:, f, 0]))
        cost = np.linalg.norm(xyz[points][:, None] - truth[there, f], axis=-1)
        i, j = assign(cost, np.full(len(points), within))
        owner[points[i]], distance[points[i]] = there[j], cost[i, j]
    near = owner >= 0
    off = xyz[near] - truth[owner[near], cloud.frame[near]]
    squared = (off * np.linalg.solve(cloud.cov[near], off[..., None])[..., 0]).sum(-1)
    return Score(
        owner=owner,
        distance=distance,
        recall=float(near.sum() / max((~np.isnan(truth[..., 0])).sum(), 1)),
        extra_per_frame=float((tracked & ~near).sum() / max(cloud.n_frames, 1)),
        rmse=float(np.sqrt((off**2).sum(1).mean())) if near.any() else float("nan"),
        median=float(np.median(distance[near])) if near.any() else float("nan"),
        p95=float(np.percentile(distance[near], 95)) if near.any() else float("nan"),
        coverage=float((squared <= 2 * gammaincinv(1.5, 0.95)).mean()) if near.any() else float("nan"),
        swaps=len(changes(tracks, owner, truth)),
        pieces=_pieces(tracks, owner, len(truth)),
    )


def changes(tracks: Tracks, owner: Ints, truth: Floats) -> list[tuple[int, int, int, int]]:
    """Swaps: track, the frame after which it changes over, and the paths from and to which it does."""
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


def _pieces(tracks: Tracks, owner: Ints, n_paths: int) -> Ints:
    """(M) how many tracks have a point on each path."""
    near = owner >= 0
    pairs = np.unique(np.column_stack([owner[near], tracks.id[near]]), axis=0)
    return np.bincount(pairs[:, 0], minlength=n_paths)
