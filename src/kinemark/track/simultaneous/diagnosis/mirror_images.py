"""Tracks that are mirror images of markers: in a wet floor, a window, a polished wall.

A plane that mirrors shows each marker x once more, at

    x′ = x − 2 (n·x − d) n                                                                     (1)

with n its normal and d its distance from the origin. Cameras see x′ as well as any marker, and agree on it. All who see
it stand before the plane, on the side of x, and nothing that they see behind it is a marker.

Two tracks tell a plane where their difference keeps its direction, which is n, and their mean stays in the plane. What
stands still does so as well, and so do the left and right of who moves alike with both. So a pair counts where it goes
to and from the plane by many times what (1) leaves, and (1) leaves no more than the points are unsure by (2). A plane
counts that as many as `PAIRS` images tell (3), that no camera which sees them stands behind (4), as some do behind the
plane between left and right, and behind which what lies near the image of something seen before it mostly is that
image (5): a wall shows as well what is hidden from the cameras, of which nothing is near. All tracks behind such a
plane are images, also where the marker itself is hidden.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data import Rig, Tracks
from ....data.array_types import Bools, Floats, Ints

PAIRS = 3
"""Images, and markers, by which a plane is told (3); chosen: a stick has two ends, and the fit of one pair is free."""
FRAMES, FEWEST = 100, 10
"""Frames that are looked at, evenly spread, and of these the fewest that two tracks share; chosen."""
LONGEST = 150
"""Tracks of most frames, among which pairs are looked for; chosen, for speed."""
MOVES = 5.0
"""Times as far as (1) leaves that a pair goes to and from the plane, both RMS; chosen: hands of who moves both alike
keep (1) to a tenth of their way, by less than two in three of their markers."""
UNSURE = 2.5
"""Standard deviations that (1) leaves, RMS; chosen: a calibration that is off leaves 1.5. Of 20 simulated people who
move both sides alike, with markers 10 mm from alike and cameras to one side, 4.0 takes five for mirrored, 2.5 none."""
TRIED = 12
"""Pairs whose plane is tried, the surest first; chosen."""
SHARE = 0.5
"""Of (5); chosen: left and right of a body are near each other's images, and hardly ever exact ones."""
BEHIND = 0.9
"""Of a track's points that lie behind the plane; chosen."""


class Plane(NamedTuple):
    """(1): its normal n (3), which points to the cameras, and d, mm; off: mm that (1) leaves of its pairs."""

    n: Floats
    d: float
    off: float

    def height(self, xyz: Floats) -> Floats:
        """(…) mm before it."""
        return np.asarray(xyz @ self.n - self.d)

    def image(self, xyz: Floats) -> Floats:
        """(…, 3) mm (1)."""
        return np.asarray(xyz - 2 * self.height(xyz)[..., None] * self.n)


class _Sampled(NamedTuple):
    """Tracks at some frames: id (M); xyz (M, K, 3) mm and variance (M, K) mm² of all axes together, NaN where there is
    no point; cameras (M, C) that see each at any time."""

    id: Ints
    xyz: Floats
    variance: Floats
    cameras: Bools

    def take(self, which: Bools | Ints) -> _Sampled:
        """Only these."""
        return _Sampled(self.id[which], self.xyz[which], self.variance[which], self.cameras[which])


def mirror_images(tracks: Tracks, rig: Rig) -> Ints:
    """The numbers of the tracks that are images of others in a mirror, or in several; mostly none.

    Args:
        tracks: of a recording. rig: the cameras that its points were seen by.
    """
    some, found = _sampled(tracks), np.zeros(0, np.int64)
    while (plane := _mirror(some, rig.centres)) is not None:
        images = np.union1d(some.id[_behind(some, plane)], _all_behind(tracks, plane))
        found = np.union1d(found, images)
        some = some.take(~np.isin(some.id, images))
    return found


def _sampled(tracks: Tracks) -> _Sampled:
    """Tracks at `FRAMES` frames, those of most of them first, and none that is in none of them."""
    cloud, n = tracks.cloud, len(tracks)
    looked_at = np.unique(np.linspace(0, max(cloud.n_frames - 1, 0), FRAMES).astype(int))
    xyz, variance = np.full((n, len(looked_at), 3), np.nan), np.full((n, len(looked_at)), np.nan)
    rows = np.flatnonzero((tracks.id >= 0) & np.isin(cloud.frame, looked_at))
    at = tracks.id[rows], np.searchsorted(looked_at, cloud.frame[rows])
    xyz[at], variance[at] = cloud.xyz[rows], np.trace(cloud.cov[rows], axis1=1, axis2=2)
    cameras = np.zeros((n, cloud.detection.shape[1]), bool)
    np.logical_or.at(cameras, tracks.id[rows], cloud.detection[rows] >= 0)
    seen = np.isfinite(variance).sum(1)
    order = np.argsort(-seen, kind="stable")[: int((seen > 0).sum())]
    return _Sampled(order, xyz[order], variance[order], cameras[order])


def _mirror(some: _Sampled, centres: Floats) -> Plane | None:
    """The mirror of most pairs among tracks that cameras at `centres` (C, 3) see; None where there is none."""
    long = some.take(np.arange(min(len(some.id), LONGEST)))
    best, most = None, 0
    for i, j in _likely_pairs(long)[:TRIED]:
        plane, images = _fitted(long, i, j)
        if len(images) <= most:
            continue
        heights = centres[long.cameras[images].any(0)] @ plane.n - plane.d
        if (heights <= 0).all():  # the others are the images
            plane = plane._replace(n=-plane.n, d=-plane.d)
        elif (heights <= 0).any():  # (4)
            continue
        if _explained(some, plane) >= SHARE:  # (5)
            best, most = plane, len(images)
    return best


def _likely_pairs(some: _Sampled) -> list[tuple[int, int]]:
    """Pairs of tracks that tell a plane (2), those first that go farthest to and from it for what (1) leaves."""
    pairs = []
    for i in range(len(some.id) - 1):
        apart = some.xyz[i] - some.xyz[i + 1 :]
        n = _unit(np.nansum(apart, axis=1))
        d = _mean(((some.xyz[i] + some.xyz[i + 1 :]) / 2 * n[:, None]).sum(-1))
        ratio = _ratio(some, some.xyz[i], i, np.arange(i + 1, len(some.id)), n, d)
        pairs += [(ratio[k], i, i + 1 + k) for k in np.flatnonzero(ratio > MOVES).tolist()]
    return [(i, j) for _, i, j in sorted(pairs, reverse=True)]


def _ratio(some: _Sampled, x: Floats, i: int, others: Ints, n: Floats, d: Floats) -> Floats:
    """(N) times as far as (1) leaves that track i, at x (K, 3), and others (N) go to and from planes n (N, 3), d (N); 0
    where they share too few frames or (1) leaves too much (2)."""
    height = x @ n.T - d  # (K, N)
    image = x[:, None] - 2 * height[..., None] * n
    off = ((some.xyz[others].swapaxes(0, 1) - image) ** 2).sum(-1).T  # (N, K)
    known = np.isfinite(off)
    left, unsure = _mean(off), _mean(np.where(known, some.variance[i] + some.variance[others], np.nan))
    way = _mean(np.where(known, height.T**2, np.nan)) - _mean(np.where(known, height.T, np.nan)) ** 2
    good = (known.sum(1) >= FEWEST) & (left < UNSURE**2 * unsure)
    ratio = np.sqrt(np.maximum(way, 0.0) / np.maximum(left, 1e-12))
    return np.where(good, ratio, 0.0)


def _fitted(some: _Sampled, i: int, j: int) -> tuple[Plane, Ints]:
    """The plane of tracks i and j, fitted to all pairs that it fits; and their tracks on the side of j, fewer than
    `PAIRS` being none (3)."""
    n = _unit(np.nansum(some.xyz[i] - some.xyz[j], axis=0))
    d = float(_mean(((some.xyz[i] + some.xyz[j]) / 2 @ n)[None])[0])
    for _ in range(2):
        pairs = _pairs_of(some, n, d)
        apart = np.concatenate([some.xyz[a] - some.xyz[b] for a, b in pairs] or [np.zeros((0, 3))])
        middle = np.concatenate([some.xyz[a] + some.xyz[b] for a, b in pairs] or [np.zeros((0, 3))]) / 2
        known = np.isfinite(apart).all(1)
        if not known.any():
            return Plane(n, d, 0.0), np.zeros(0, np.int64)
        n, d = _plane_of(apart[known], middle[known])
    off = np.concatenate([some.xyz[b] - Plane(n, d, 0.0).image(some.xyz[a]) for a, b in pairs])
    plane = Plane(n, d, float(np.sqrt(np.nanmean((off**2).sum(1)))))
    markers, images = (np.unique(side) for side in np.array(pairs).T)
    return plane, images if min(len(markers), len(images)) >= PAIRS else images[:0]


def _plane_of(apart: Floats, middle: Floats) -> tuple[Floats, float]:
    """n and d of pairs of points that are `apart` (N, 3) and have their `middle` (N, 3) in the plane."""
    n = np.linalg.eigh(apart.T @ apart)[1][:, -1]
    n = n * np.sign(apart.sum(0) @ n)
    return n, float(np.mean(middle @ n))


def _pairs_of(some: _Sampled, n: Floats, d: float) -> list[tuple[int, int]]:
    """Pairs of tracks that this plane mirrors (2), the one on the side of n first."""
    before = np.nanmean(some.xyz @ n - d, axis=1) > 0
    behind, pairs = np.flatnonzero(~before), []
    for i in np.flatnonzero(before).tolist():
        N = len(behind)
        ratio = _ratio(some, some.xyz[i], i, behind, np.tile(n, (N, 1)), np.full(N, d))
        pairs += [(i, int(behind[k])) for k in np.flatnonzero(ratio > MOVES)]
    return pairs


def _explained(some: _Sampled, plane: Plane) -> float:
    """Of points of tracks behind a plane with a point before it near their image, those that it is exactly (5)."""
    images = _behind(some, plane)
    markers, near, met = some.xyz[~images], 0, 0
    for one in plane.image(some.xyz[images]):
        off = np.linalg.norm(markers - one, axis=-1)
        nearest = np.where(np.isfinite(off), off, np.inf).min(0, initial=np.inf)
        near += int((nearest < 2 * UNSURE * plane.off).sum())
        met += int((nearest < UNSURE * plane.off).sum())
    return met / max(near, 1)


def _behind(some: _Sampled, plane: Plane) -> Bools:
    """(M) which tracks lie behind a plane."""
    height = plane.height(some.xyz)
    return np.asarray((height < -plane.off).sum(1) >= BEHIND * np.isfinite(height).sum(1))


def _all_behind(tracks: Tracks, plane: Plane) -> Ints:
    """The numbers of the tracks that lie behind a plane, by all their points."""
    own = tracks.id >= 0
    id, behind = tracks.id[own], plane.height(tracks.cloud.xyz[own]) < -plane.off
    count = np.bincount(id, minlength=len(tracks))
    return np.flatnonzero((count > 0) & (np.bincount(id, behind, len(tracks)) >= BEHIND * count))


def _unit(v: Floats) -> Floats:
    """Vectors (…, 3) of length 1."""
    return np.asarray(v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12))


def _mean(values: Floats) -> Floats:
    """(N) means of what is known of values (N, K); NaN where nothing is."""
    known = np.isfinite(values)
    total = np.where(known, values, 0.0).sum(1)
    return np.asarray(np.where(known.any(1), total / np.maximum(known.sum(1), 1), np.nan))
