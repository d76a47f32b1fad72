"""Matching over N cameras along epipolar lines, three cameras first, then two (KISS 4.1).

The image of a marker in camera s lies near the epipolar line of its image in camera r. Two images whose lines agree
meet in space, and the projection of that point into a third camera is where the two epipolar lines there intersect;
an image within the search radius of the intersection completes a triplet, and images near it in the remaining
cameras join it. KISS walks over base cameras and lets the first match win. Here all candidates of a frame are set up
first and then compete, so the order of the cameras has no influence:

1. pairs of images within the search band of each other's epipolar lines, at most five for an image and a camera;
2. each pair's point, projected into every other camera, takes the nearest candidate within the search radius;
3. a group whose images lie at distances d from the projections of its point has the score

       m = Σ (ρ² − d²)                                                                  (1)

   with the search radius ρ: more cameras are better, and a camera that fits badly adds little;
4. the group with the highest score takes its images, the others lose them and are scored again, until no group with
   three images is left;
5. what is left over is matched by pairs, the closest to their epipolar lines first (`pairs`).

All frames of a block go through each step together.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, NamedTuple

import numpy as np

from ..data import Detections, Matches, Rig
from ..data.array_types import Bools, Floats, Ints
from ..data.method import Method, parameter
from ..data.progress import tell
from ..geometry import fundamental, triangulate
from ..geometry.ideal_pixels import ideal_pixels
from ..numerics.runs import equal_runs
from .stage import MATCH

BLOCK = 512  # frames matched together, enough to share numpy's overhead; chosen
CELLS = 1 << 24  # pairs of images in a block, at most: bounds the memory; chosen


@dataclass(frozen=True, slots=True)
class EpipolarTriplets(Method):
    """Triplets of images that confirm each other by epipolar lines, grown to all cameras; then pairs."""

    search_band: float = parameter(2.0, unit="px", above=0, meaning="half width of the band about an epipolar line")
    search_radius: float = parameter(
        2.0, unit="px", above=0, meaning="radius about an intersection of epipolar lines; ρ of (1)"
    )
    candidates: int = parameter(
        5, unit="images", low=1,
        meaning="images considered for an image in each other camera, the nearest to its epipolar line",
    )  # fmt: skip
    pairs: Literal["none", "best", "all"] = parameter(
        "all",
        meaning="what becomes of images that only two cameras share: none; best, the nearest to their epipolar "
        "lines first, each image once; or all, every combination, which leaves the choice to the tracking",
    )
    pair_band: float = parameter(1.0, unit="px", above=0, meaning="half width about an epipolar line for such pairs")


class FrameImages(NamedTuple):
    """The images of one block: ideal pixels (D, 2), and rows[c] (F, n) of each camera, −1 beyond the frame's last."""

    uv: Floats
    rows: list[Ints]


class TripletEdges(NamedTuple):
    """E pairs of images: cameras r < s, rows i and j, distance px from the epipolar line (the greater of the two)."""

    r: Ints
    s: Ints
    i: Ints
    j: Ints
    distance: Floats


@MATCH.method("epipolar_triplets", EpipolarTriplets)
def match_epipolar(detections: Detections, rig: Rig, *, method: EpipolarTriplets) -> Matches:
    """Groups of detections that are one marker; called through `match`."""
    blocks = blocks_of(detections, rig)
    return collected([_match_block(seen, rig.P, method) for seen in blocks], detections)


def collected(groups: list[tuple[Ints, Floats]], detections: Detections) -> Matches:
    """Views (G, C) and costs (G) of all blocks in the order of their frames."""
    detection = np.concatenate(
        [detection for detection, _ in groups] or [np.zeros((0, len(detections.cameras)), np.int64)]
    )
    cost = np.concatenate([cost for _, cost in groups] or [np.zeros(0)])
    frame = detections.frame[detection.max(1)] if len(detection) else np.zeros(0, np.int64)
    order = np.argsort(frame, kind="stable")
    return Matches(frame[order], detection[order], cost[order], detections.n_frames)


def blocks_of(detections: Detections, rig: Rig) -> Iterator[FrameImages]:
    """The valid detections, without lens distortion, a block of frames at a time."""
    uv = ideal_pixels(detections, rig)
    block = min(BLOCK, max(CELLS // max(int(detections.counts.max(initial=1)), 1) ** 2, 1))
    for first in range(0, detections.n_frames, block):
        tell(first, detections.n_frames)
        cut = detections.start[:, first : first + block + 1]
        yield FrameImages(uv, [_padded(rows) for rows in cut])


def _padded(start: Ints) -> Ints:
    """Rows (F, n) of each frame from offsets (F+1), −1 beyond a frame's last."""
    counts = np.diff(start)
    j = np.arange(counts.max(initial=0))
    return np.where(j < counts[:, None], start[:-1, None] + j, -1)


def _match_block(seen: FrameImages, P: Floats, method: EpipolarTriplets) -> tuple[Ints, Floats]:
    """Views (G, C) and costs (G) px of all frames of a block."""
    edges = _edges(seen, P, method)
    detection, score = _groups(edges, seen, P, method)
    taken = np.zeros(len(seen.uv), bool)
    chosen = [_assign_images(detection, score, taken, seen.uv, P, method.search_radius)]
    if method.pairs != "none":
        chosen.append(_pairs(edges, taken, len(P), method))
    detection = np.concatenate(chosen)
    return detection, costs(detection, seen.uv, P)


def costs(detection: Ints, uv: Floats, P: Floats) -> Floats:
    """(G) RMS distance of the images of groups (G, C) from the reprojection of their point, px."""
    _, squared = _fit(detection, uv, P)
    return np.sqrt(np.nansum(squared, axis=1) / (detection >= 0).sum(1))


def _edges(seen: FrameImages, P: Floats, method: EpipolarTriplets) -> TripletEdges:
    """Step 1 for all pairs of cameras."""
    parts = []
    for r, s in combinations(range(len(P)), 2):
        frame, i, j, distance = _near_lines(seen, r, s, fundamental(P[r], P[s]), method.search_band)
        i, j = seen.rows[r][frame, i], seen.rows[s][frame, j]
        few = (_rank(i, distance) < method.candidates) & (_rank(j, distance) < method.candidates)
        parts.append(TripletEdges(np.full(few.sum(), r), np.full(few.sum(), s), i[few], j[few], distance[few]))
    return TripletEdges(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _near_lines(seen: FrameImages, r: int, s: int, F: Floats, band: float) -> tuple[Ints, Ints, Ints, Floats]:
    """Frame, place in camera r, place in camera s and distance of all pairs within the band, both ways."""
    first, second = seen.uv[seen.rows[r]], seen.uv[seen.rows[s]]
    first[seen.rows[r] < 0] = np.nan
    second[seen.rows[s] < 0] = np.nan
    lines = first @ F[:, :2].T + F[:, 2]
    back = second @ F[:2] + F[2]
    product = lines[..., :2] @ second.transpose(0, 2, 1) + lines[..., 2:]
    slope = np.hypot(lines[..., 0], lines[..., 1])[:, :, None]  # both ways: the smaller slope is the greater distance
    slope = np.minimum(slope, np.hypot(back[..., 0], back[..., 1])[:, None])
    np.abs(product, out=product)
    frame, i, j = np.nonzero(product < band * slope)
    return frame, i, j, product[frame, i, j] / slope[frame, i, j]


def _rank(key: Ints, value: Floats) -> Ints:
    """Place of each entry among those with its key, by rising value."""
    order = np.lexsort([value, key])
    ends = equal_runs(key[order])
    rank = np.empty(len(key), np.int64)
    rank[order] = np.arange(len(key)) - np.repeat(ends[:-1], np.diff(ends))
    return rank


def _groups(edges: TripletEdges, seen: FrameImages, P: Floats, method: EpipolarTriplets) -> tuple[Ints, Floats]:
    """Steps 2 and 3: detections (H, C) of three or more cameras and their scores (H)."""
    neighbours, base = _neighbours(edges, len(seen.uv), len(P))
    found = []
    for r, s in combinations(range(len(P)), 2):
        own = (edges.r == r) & (edges.s == s)
        i, j = edges.i[own], edges.j[own]
        xyz = triangulate(np.stack([seen.uv[i], seen.uv[j]], 1), P[[r, s]])
        detection = np.full((len(i), len(P)), -1)
        detection[:, r], detection[:, s] = i, j
        for c in set(range(len(P))) - {r, s}:
            detection[:, c] = _nearest(xyz, neighbours[base[i], c], seen.uv, P[c], method.search_radius)
        found.append(detection[(detection >= 0).sum(1) >= 3])
    detection = _distinct(np.concatenate(found))
    return _score_groups(detection, seen.uv, P, method.search_radius)


def _neighbours(edges: TripletEdges, n: int, n_cameras: int) -> tuple[Ints, Ints]:
    """Candidates (B, C, k) of each image that has any, −1 beyond the last, and where in them each row stands (n)."""
    i, other = np.concatenate([edges.i, edges.j]), np.concatenate([edges.j, edges.i])
    camera, distance = np.concatenate([edges.s, edges.r]), np.concatenate([edges.distance, edges.distance])
    base = np.full(n, -1)
    have = np.unique(i)
    base[have] = np.arange(len(have))
    rank = _rank(i * n_cameras + camera, distance)
    neighbours = np.full((len(have), n_cameras, rank.max(initial=0) + 1), -1)
    neighbours[base[i], camera, rank] = other
    return neighbours, base


def _nearest(xyz: Floats, candidates: Ints, uv: Floats, P: Floats, radius: float) -> Ints:
    """Of candidates (H, k) the one nearest to the projection of xyz (H, 3), if within the radius, else −1."""
    squared = _squared(uv[candidates], _project(xyz, P)[:, None])
    squared = np.where((candidates >= 0) & (squared < radius**2), squared, np.inf)
    best = squared.argmin(1)[:, None]
    found = np.isfinite(np.take_along_axis(squared, best, 1))
    return np.where(found, np.take_along_axis(candidates, best, 1), -1)[:, 0]


def _project(xyz: Floats, P: Floats) -> Floats:
    """Ideal pixels (…, 2) of points (…, 3), NaN behind the camera."""
    x = xyz @ P[:, :3].T + P[:, 3]
    return x[..., :2] / np.where(x[..., 2:] > 0, x[..., 2:], np.nan)


def _squared(a: Floats, b: Floats) -> Floats:
    """|a − b|² over the last axis of two."""
    d = a - b
    return d[..., 0] ** 2 + d[..., 1] ** 2


def _distinct(detection: Ints) -> Ints:
    """Rows without repetition, distinguished by a 64-bit hash (a clash is one in 10⁸ recordings)."""
    weights = np.random.default_rng(0).integers(1, 1 << 62, detection.shape[1], dtype=np.uint64) | np.uint64(1)
    _, first = np.unique((detection.astype(np.uint64) * weights).sum(1, dtype=np.uint64), return_index=True)
    return detection[np.sort(first)]


def _fit(detection: Ints, uv: Floats, P: Floats) -> tuple[Floats, Floats]:
    """The point (H, 3) of each group and the squared distances (H, C) px² of its images from it, NaN unseen."""
    images = np.where((detection >= 0)[..., None], uv[detection], np.nan)
    xyz = triangulate(images, P)
    projected = np.stack([_project(xyz, p) for p in P], 1)
    return xyz, _squared(images, projected)


def _score_groups(detection: Ints, uv: Floats, P: Floats, radius: float) -> tuple[Ints, Floats]:
    """Groups of three or more images within the radius, and their scores by (1); an image outside leaves its group."""
    _, squared = _fit(detection, uv, P)
    outside = squared > radius**2
    if outside.any():
        largest = np.where(np.isnan(squared), -1.0, squared).argmax(1)
        bad = outside.any(1)
        detection = detection.copy()
        detection[np.flatnonzero(bad), largest[bad]] = -1
        detection = detection[(detection >= 0).sum(1) >= 3]
        return _score_groups(detection, uv, P, radius)
    return detection, np.nansum(radius**2 - squared, axis=1)


def _assign_images(detection: Ints, score: Floats, taken: Bools, uv: Floats, P: Floats, radius: float) -> Ints:
    """Step 4: the winning groups; marks their images in `taken`."""
    chosen = [detection[:0]]
    while len(detection):
        best = _best_groups(detection, score, len(uv))
        chosen.append(detection[best])
        taken[detection[best][detection[best] >= 0]] = True
        detection, score = detection[~best], score[~best]
        lost = (detection >= 0) & taken[detection]
        changed = lost.any(1)
        rest = np.where(lost[changed], -1, detection[changed])
        kept, weight = _score_groups(rest[(rest >= 0).sum(1) >= 3], uv, P, radius)
        detection, score = np.concatenate([detection[~changed], kept]), np.concatenate([score[~changed], weight])
    return np.concatenate(chosen)


def _best_groups(detection: Ints, score: Floats, n: int) -> Bools:
    """Groups (H) that are the best at every one of their images; ties go to the first."""
    place = np.empty(len(detection), np.int64)
    place[np.argsort(-score, kind="stable")] = np.arange(len(detection), 0, -1)
    best = np.zeros(n + 1, np.int64)
    np.maximum.at(best, detection.ravel(), np.repeat(place, detection.shape[1]))
    return ((best[detection] == place[:, None]) | (detection < 0)).all(1)


def _pairs(edges: TripletEdges, taken: Bools, n_cameras: int, method: EpipolarTriplets) -> Ints:
    """Step 5: detections (G, C) of two cameras each, from images that no larger group has taken."""
    free = ~taken[edges.i] & ~taken[edges.j] & (edges.distance < method.pair_band)
    edges = TripletEdges(edges.r[free], edges.s[free], edges.i[free], edges.j[free], edges.distance[free])
    detection = np.full((len(edges.i), n_cameras), -1)
    detection[np.arange(len(detection)), edges.r] = edges.i
    detection[np.arange(len(detection)), edges.s] = edges.j
    if method.pairs == "all":
        return detection
    chosen, score = [detection[:0]], -edges.distance
    while len(detection):
        best = _best_groups(detection, score, len(taken))
        chosen.append(detection[best])
        taken[detection[best][detection[best] >= 0]] = True
        free = ~((detection >= 0) & taken[detection]).any(1)
        detection, score = detection[free], score[free]
    return np.concatenate(chosen)
