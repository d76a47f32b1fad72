"""A marker set learnt from a labelled trial: which markers move as one body, what links them, which are left and right.

Over the frames of a trial, the distance of markers a and b has mean D and standard deviation S. On one segment skin and
camera noise alone move them against each other, so that S stays below

    r_ab = √( (0.012 D)² + (0.004 R)² )                                                                           (1)

with R the greatest mean distance; a third of it where D is more than 0.45 R, as no segment of a body is that long and
only what is rigid, as a tool, may be. Segments are the groups that complete linkage by S / r leaves where no pair of a
group exceeds 1; a marker that keeps its distance to all of another group as well, as one on the axis of a hinge does,
belongs to both. What never moves against each other in the trial cannot be told apart: the more it shows, the better.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

from ..data import KinemarkError, MarkerSet, Trajectories
from ..data.array_types import Bools, Floats, Ints
from ..data.marker_set import Place
from ..data.marker_sides import sides_by_name
from ..numerics.evenly import evenly_rounded
from .side_pairs import sides_by_shape
from .template import names_in

RELATIVE, OF_SIZE = 0.012, 0.004
"""The two parts of (1), shares of D and of R; measured on gait of seven subjects, see docs/theory/label.md."""
LONG = 0.45
"""Share of R beyond which (1) is a third; chosen: where legs alone have markers, a shank is 0.43 of R."""
ALSO = 0.8
"""Looseness to all of a group up to which a marker of another group belongs to it too; chosen."""
FRAMES = 600
"""Frames of a trial that are looked at, evenly spread; chosen: as `template.FRAMES`, and more for short motions."""
TOGETHER = 0.25
"""Share of the frames in which two markers must both be seen; chosen."""
LEAST_MOVING = 0.1
"""Share of all pairs that must change their distance by more than (1), lest nothing moves; chosen."""
TURNED = 30.0
"""Degrees by which an object turns whose distances stay as they are, so that it is one segment; chosen: a subject who
stands still turns by a few."""


class Distances(NamedTuple):
    """Of M markers: (M, M) mean distance D and its standard deviation S, mm; NaN where too few frames have both."""

    mean: Floats
    spread: Floats

    @property
    def looseness(self) -> Floats:
        """(M, M) S over r of (1): up to 1 on one segment; infinite where unknown."""
        size = np.nanmax(self.mean)
        r = np.hypot(RELATIVE * self.mean, OF_SIZE * size) * np.where(self.mean > LONG * size, 1 / 3, 1.0)
        loose = np.where(np.isfinite(self.mean), self.spread / r, np.inf)
        np.fill_diagonal(loose, 0.0)
        return loose


def learn_marker_set(trial: Trajectories, *, names: Sequence[str] | None = None, name: str = "") -> MarkerSet:
    """The marker set that a labelled trial shows.

    Args:
        trial: labelled; the more joints move, the better.
        names: of the markers; where None, all that have samples, without those that begin with "*" or were computed.
        name: of the set.

    Raises:
        KinemarkError: fewer than three markers have names and samples, or the trial shows no motion, so that segments
            cannot be told from each other.
    """
    wanted = [name for name in trial.names if name in names_in([trial])] if names is None else list(names)
    there = tuple(one for one in wanted if one in trial.names and np.isfinite(trial[one].xyz).any())
    if len(there) < 3:
        raise KinemarkError(f"The trial has {len(there)} named markers with samples. Wanted are three or more.")
    xyz = _sampled(trial, there)
    distances = _distances(xyz)
    if not np.isfinite(distances.mean[np.triu_indices(len(there), 1)]).any():
        raise KinemarkError("No two of the markers are seen together for long enough to know their distance.")
    loose = distances.looseness
    if _moving(loose) < LEAST_MOVING and not _turned(xyz):
        raise KinemarkError(
            "The trial shows hardly any motion: all distances stay as they are, so that segments cannot be told from "
            "each other. Give a trial in which all joints move."
        )
    groups = _groups(loose)
    segments = {_segment_name(there, group, groups): tuple(there[i] for i in group) for group in groups}
    links = _links(distances, loose, groups)
    pairs = sides_by_name(there) or sides_by_shape(there, distances.mean, xyz)
    return MarkerSet(
        there,
        segments,
        links,
        distances.mean[links[:, 0], links[:, 1]],
        distances.spread[links[:, 0], links[:, 1]],
        pairs,
        name=name,
        rigidity={s: _share(distances, g) for s, g in zip(segments, groups, strict=True)},
        joints=_joints(segments, groups, loose, distances),
        places=_places(there, xyz, pairs),
    )


def _sampled(trial: Trajectories, names: tuple[str, ...]) -> Floats:
    """(M, K, 3) places about one of them in some frames."""
    rows = evenly_rounded(trial.n_frames, FRAMES)
    xyz = np.stack([trial[name].xyz[rows] for name in names])
    return np.asarray(xyz - xyz[np.isfinite(xyz).all(-1)][0])


def _distances(xyz: Floats) -> Distances:
    """Of all pairs that are seen together long enough."""
    M = len(xyz)
    mean, spread = np.full((M, M), np.nan), np.full((M, M), np.nan)
    for a in range(M):
        d = np.linalg.norm(xyz[a] - xyz, axis=-1)
        n = np.isfinite(d).sum(1)
        good = n >= max(2, TOGETHER * np.isfinite(xyz[a, :, 0]).sum())
        mean[a, good], spread[a, good] = np.nanmean(d[good], 1), np.nanstd(d[good], 1)
    both = np.isfinite(mean) & np.isfinite(mean.T)
    return Distances(np.where(both, mean, np.nan), np.where(both, spread, np.nan))


def _turned(xyz: Floats) -> bool:
    """Whether half of the pairs of markers (M, F, 3) mm turn by TURNED from where they were first seen."""
    a, b = np.triu_indices(len(xyz), 1)
    across = xyz[b] - xyz[a]
    across = across / np.linalg.norm(across, axis=-1, keepdims=True)
    seen = np.isfinite(across[..., 0])
    first = np.take_along_axis(across, seen.argmax(1)[:, None, None], axis=1)
    cosine = np.where(seen, (across * first).sum(-1), 1.0).min(1)
    return bool(np.median(cosine) < np.cos(np.deg2rad(TURNED)))


def _moving(loose: Floats) -> float:
    """Share of the known pairs that are on no one segment."""
    known = loose[np.triu_indices(len(loose), 1)]
    known = known[np.isfinite(known)]
    return float((known > 1).mean()) if len(known) else 0.0


def _groups(loose: Floats) -> list[list[int]]:
    """Markers of each segment, in order; a marker on the axis of a hinge is in two."""
    far = np.where(np.isfinite(loose), np.maximum(loose, loose.T), 1e9)
    tree = scipy.cluster.hierarchy.linkage(scipy.spatial.distance.squareform(far, checks=False), "complete")
    own = scipy.cluster.hierarchy.fcluster(tree, 1.0, "distance")
    groups = [np.flatnonzero(own == k).tolist() for k in dict.fromkeys(own.tolist())]
    wider = [[i for i in range(len(far)) if i in group or (far[i, group] <= ALSO).all()] for group in groups]
    kept = [
        g for k, g in enumerate(wider) if len(g) > 1 and not any(_within(g, k, wider, j) for j in range(len(wider)))
    ]
    return sorted(kept)


def _within(group: list[int], k: int, groups: list[list[int]], j: int) -> bool:
    """Whether group k adds nothing to group j; of two that are the same the first stays."""
    return j != k and set(group) <= set(groups[j]) and (set(group) != set(groups[j]) or j < k)


def _segment_name(names: tuple[str, ...], group: list[int], groups: list[list[int]]) -> str:
    """By the first of its markers, as many as tell it from the others."""
    n = next(n for n in range(min(2, len(group)), len(group) + 1) if sum(g[:n] == group[:n] for g in groups) == 1)
    return " ".join(names[i] for i in group[:n])


def _share(distances: Distances, group: list[int]) -> float:
    """Median of S / D of a segment's pairs."""
    a, b = np.triu_indices(len(group), 1)
    i, j = np.array(group)[a], np.array(group)[b]
    return round(float(np.median(distances.spread[i, j] / distances.mean[i, j])), 4)


def _links(distances: Distances, loose: Floats, groups: list[list[int]]) -> Ints:
    """(L, 2) pairs: near neighbours on each segment, and what joins the segments at the least motion."""
    D = np.where(np.isfinite(distances.mean), distances.mean, np.inf)
    links = {
        (i, j)
        for group in groups
        for k, i in enumerate(group)
        for j in group[k + 1 :]
        if not any(max(D[i, c], D[j, c]) < D[i, j] for c in group if c not in (i, j))
    }
    cost = np.where(np.isfinite(loose), D * (0.1 + loose), 0.0)
    for i, j in links:
        cost[i, j] = cost[j, i] = 1e-6
    tree = scipy.sparse.csgraph.minimum_spanning_tree(np.triu(cost, 1)).tocoo()
    links |= {(min(i, j), max(i, j)) for i, j in zip(tree.row.tolist(), tree.col.tolist(), strict=True)}
    return np.array(sorted(links), np.int64).reshape(-1, 2)


def _joints(
    segments: dict[str, tuple[str, ...]], groups: list[list[int]], loose: Floats, distances: Distances
) -> dict[str, tuple[str, str]]:
    """Segments that meet: those that a tree of the least motion joins, named by what is nearest across."""
    names = list(segments)
    n = len(names)
    cost = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1, n):
            part = np.ix_(groups[i], groups[j])
            best = np.nanmin(np.where(np.isfinite(loose[part]), distances.mean[part] * (0.1 + loose[part]), np.inf))
            cost[i, j] = best + 1e-3 if np.isfinite(best) else 0.0
    tree = scipy.sparse.csgraph.minimum_spanning_tree(cost).tocoo()
    pairs = sorted(zip(tree.row.tolist(), tree.col.tolist(), strict=True))
    return {f"{names[i]} – {names[j]}": (names[i], names[j]) for i, j in pairs}


def _places(names: tuple[str, ...], xyz: Floats, pairs: Sequence[tuple[str, str]]) -> dict[str, Place]:
    """Places of the markers in the tallest pose that shows most of them; none without a left and a right."""
    if not pairs:
        return {}
    left, right = (np.array([names.index(pair[k]) for pair in pairs]) for k in (0, 1))
    across = np.nanmean(xyz[left] - xyz[right], 0) * [1, 1, 0]
    wide = np.linalg.norm(across, axis=1)
    seen = np.isfinite(xyz[..., 0]).sum(0)
    tall = np.nanmax(xyz[..., 2], 0) - np.nanmin(xyz[..., 2], 0)
    k = int(np.argmax(np.where((seen >= seen.max() - 2) & np.isfinite(wide), tall, -1.0)))
    if not wide[k] > 0:
        return {}
    y = across[k] / wide[k]
    axes = np.stack([np.cross(y, [0.0, 0.0, 1.0]), y, [0.0, 0.0, 1.0]])
    here = xyz[:, k] @ axes.T
    low, high = np.nanmin(here[:, 2]), np.nanmax(here[:, 2])
    middle = np.nanmean((here[left] + here[right]) / 2, 0)
    size = max(high - low, 1e-9) / 0.94
    shares = (here - [middle[0], middle[1], low]) / size
    there: Bools = np.isfinite(shares).all(1)
    places: dict[str, Place] = {
        name: (round(float(p[0]), 3), round(float(p[1]), 3), round(float(p[2]), 3))
        for name, p, ok in zip(names, shares, there, strict=True)
        if ok
    }
    return places
