"""Matching as the Kiss system does it: base cameras, triplets and search circles (Shafiq, Tümer and Güler 2001, 4.1).

The image i of a base camera is a line l of another camera (KISS eq. 8), written with a² + b² = 1 so that

    d = |a u + b v + c|                                                  (1)

is the distance of an image from it in px. The images within the search band d < `search_band`, at most five of a
camera and the nearest first, are the candidates of i; cameras that have any are its candidate cameras. They are put in
order by the distance of their nearest candidate, the least first. With the first of them, r, and the second, s:

    for each candidate j in r, for each candidate k in s:
        the lines of i and j in s meet at l_i × l_j; k must lie within the search circle about that point,
        and so must j about the meeting point of the lines of i and k in r, and i about that of j and k in its own  (2)

The first that holds all three ways is a marker. If none does, the third camera in the order takes the place of s, and
so on; r stays. The images of the remaining cameras that lie within the search circle join the marker (3), all its
images are excluded from further search, and the next image of the base camera is looked at. When they are through,
the next camera is the base (4).

An image with candidates in one camera only makes a marker with each of them (5), so ghosts as well, which are left to
the tracking; it is excluded then, its candidates are not, as other images may need them. An image whose candidates in
several cameras agree in no triplet makes none, unless `all_duals` asks for every pair (6).

This is the paper's method with the paper's weaknesses. The first triplet that fits wins, so a wrong one robs others of
their images, and the answer depends on the order of the cameras and of their images. Where the three cameras and the
marker lie in a plane, the lines in (2) run along each other and meet anywhere. And the limits are in px, equal for all
cameras. `epipolar` lets all candidates compete instead. In (3) the paper leaves open which two of the lines are taken:
here it is the two that cross at the steepest angle.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from math import hypot, inf
from typing import Literal, NamedTuple

import numpy as np

from ..data import Detections, Matches, Rig
from ..data.array_types import Bools, Floats, Ints
from ..data.method import Method, parameter
from ..data.progress import tell
from ..geometry import fundamental
from ..geometry.ideal_pixels import ideal_pixels
from ..numerics.vectors import across
from .epipolar_triplets import collected, costs
from .stage import MATCH

Line = list[float]
"""a, b, c of (1)."""


@dataclass(frozen=True, slots=True)
class KissTriplets(Method):
    """Triplets by intersections of epipolar lines, each verified by a third camera: the method of the Kiss system.

    The paper states neither band nor circle, which were found by trials in its laboratory.
    """

    search_band: float = parameter(2.0, unit="px", above=0, meaning="half width of the band about an epipolar line")
    search_radius: float = parameter(
        4.0, unit="px", above=0,
        meaning="radius of the circle about an intersection of epipolar lines; wider than the band, as two lines "
        "are off and they cross at a slant",
    )  # fmt: skip
    candidates: int = parameter(
        5, unit="images", low=1,
        meaning="images considered for an image in each other camera, the nearest to its epipolar line",
    )  # fmt: skip
    priority: Literal["distance", "angle"] = parameter(
        "distance",
        meaning="which candidate cameras are tried first: distance, those with an image nearest to the epipolar "
        "line, as the paper has it; or angle, those whose lines of sight cross the base camera's most "
        "squarely in the middle of the volume",
    )
    all_duals: bool = parameter(
        False,
        meaning="make every pair of an image and its candidates a marker where no triplet can be verified; (6)",
    )


class TripletFrame(NamedTuple):
    """The N images of one frame, counted from 0.

    detection: (N) index in `Detections`; camera: of each; uv: px; lines: lines[s][i], the epipolar line of image i in
    camera s; near: near[i][s], the images of camera s within the band of image i and distances, the nearest first.
    """

    detection: Ints
    camera: list[int]
    uv: list[list[float]]
    lines: list[list[Line]]
    near: list[dict[int, list[tuple[float, int]]]]


Ranked = list[tuple[int, list[int]]]
"""Candidate cameras in order of priority, and in each the candidates, the best first."""


@MATCH.method("kiss_triplets", KissTriplets, source="Shafiq, Tümer and Güler 2001, 4.1")
def match_kiss(detections: Detections, rig: Rig, *, method: KissTriplets) -> Matches:
    """Groups of detections that are one marker, ghosts among them; called through `match`."""
    uv, P = ideal_pixels(detections, rig), rig.P
    n = len(rig)
    F = np.array([[fundamental(P[r], P[s]) if r != s else np.zeros((3, 3)) for s in range(n)] for r in range(n)])
    steep = crossings(rig).tolist()
    found = [np.full((0, n), -1)]
    for f in range(detections.n_frames):
        tell(f, detections.n_frames)
        detection = np.concatenate([np.arange(*detections.rows(c, f).indices(len(uv))) for c in range(n)])
        frame = _frame(detection[np.isfinite(uv[detection, 0])], uv, detections, F, method.search_band)
        groups = list(_markers(frame, steep, method))
        detection = np.full((len(groups), n), -1)
        for g, images in enumerate(groups):
            for i in images:
                detection[g, frame.camera[i]] = frame.detection[i]
        found.append(detection)
    detection = np.concatenate(found)
    return collected([(detection, costs(detection, uv, P))], detections)


def sharing(matches: Matches) -> Bools:
    """(G) groups that share an image with another one. Of those that share an image, all but one are ghosts."""
    seen = matches.detection >= 0
    uses = np.bincount(matches.detection[seen], minlength=1)
    return np.asarray(((uses[matches.detection] > 1) & seen).any(1))


def crossings(rig: Rig) -> Floats:
    """(C, C) sine of the angle between two cameras' lines of sight to the point nearest to all optical axes."""
    along = np.array([camera.R[2] for camera in rig])
    projectors = across(along)
    centre = np.linalg.lstsq(projectors.sum(0), (projectors @ rig.centres[..., None]).sum(0)[:, 0])[0]
    sight = centre - rig.centres
    sight /= np.linalg.norm(sight, axis=1, keepdims=True)
    return np.linalg.norm(np.cross(sight[:, None], sight), axis=-1)


def _frame(detection: Ints, uv: Floats, detections: Detections, F: Floats, band: float) -> TripletFrame:
    """The images of one frame with all their lines and candidates."""
    camera = np.searchsorted(detections.start[:, -1], detection, side="right")
    h = np.column_stack([uv[detection], np.ones(len(detection))])
    lines, distance = np.empty((len(F), len(detection), 3)), np.full((len(detection), len(detection)), np.inf)
    with np.errstate(invalid="ignore", divide="ignore"):  # a camera has no lines in itself
        for r in range(len(F)):
            own = camera == r
            lines[:, own] = h[own] @ F[r].swapaxes(1, 2)
        lines /= np.hypot(lines[..., 0], lines[..., 1])[..., None]
        for s in range(len(F)):
            own = camera == s
            distance[:, own] = np.abs(lines[s] @ h[own].T)  # (1)
        i, j = np.nonzero(distance < band)
    near: list[dict[int, list[tuple[float, int]]]] = [{} for _ in detection]
    order = np.lexsort([distance[i, j], i])
    where = camera.tolist()
    for a, b, d in zip(i[order].tolist(), j[order].tolist(), distance[i, j][order].tolist(), strict=True):
        near[a].setdefault(where[b], []).append((d, b))
    return TripletFrame(detection, where, uv[detection].tolist(), lines.tolist(), near)


def _markers(frame: TripletFrame, steep: list[list[float]], method: KissTriplets) -> Iterator[list[int]]:
    """The images of each marker, with every camera as the base in turn (4)."""
    free = [True] * len(frame.detection)
    pairs: set[tuple[int, int]] = set()
    for i in range(len(frame.detection)):  # images are in the order of their cameras
        if not free[i]:
            continue
        ranked = _ranked(frame, i, free, steep, method)
        marker = _triplet(frame, i, ranked, method.search_radius) if len(ranked) > 1 else []
        if marker:
            marker = _joined(frame, marker, ranked, method.search_radius)
            for image in marker:
                free[image] = False
            yield marker
        elif len(ranked) == 1 or method.all_duals:
            pairs.update((min(i, j), max(i, j)) for _, images in ranked for j in images)  # (5) (6)
            free[i] = len(ranked) > 1
    yield from (list(pair) for pair in sorted(pairs))


def _ranked(frame: TripletFrame, i: int, free: list[bool], steep: list[list[float]], method: KissTriplets) -> Ranked:
    """The candidate cameras of image i."""
    found = []
    for s, candidates in frame.near[i].items():
        images = [(d, j) for d, j in candidates if free[j]][: method.candidates]
        if images:
            first = images[0][0] if method.priority == "distance" else -steep[frame.camera[i]][s]
            found.append((first, s, [j for _, j in images]))
    return [(s, images) for _, s, images in sorted(found)]


def _triplet(frame: TripletFrame, i: int, ranked: Ranked, radius: float) -> list[int]:
    """The first three images that agree by (2); none if there are none."""
    (_, first), *others = ranked
    for _, second in others:
        for j in first:
            for k in second:
                if all(_distance(frame, *three) < radius for three in ((i, j, k), (i, k, j), (j, k, i))):
                    return [i, j, k]
    return []


def _distance(frame: TripletFrame, one: int, other: int, image: int) -> float:
    """Distance px of an image from where the epipolar lines of two others meet in its camera."""
    lines = frame.lines[frame.camera[image]]
    u, v = _meet(lines[one], lines[other])
    at = frame.uv[image]
    return hypot(u - at[0], v - at[1])


def _meet(one: Line, other: Line) -> tuple[float, float]:
    """Where two lines meet, px; infinitely far off if they are parallel."""
    w = _steepness(one, other)
    if w == 0:
        return inf, inf
    return (one[1] * other[2] - one[2] * other[1]) / w, (one[2] * other[0] - one[0] * other[2]) / w


def _steepness(one: Line, other: Line) -> float:
    """Sine of the angle between two lines, with its sign."""
    return one[0] * other[1] - one[1] * other[0]


def _joined(frame: TripletFrame, marker: list[int], ranked: Ranked, radius: float) -> list[int]:
    """The marker's three images and those that join them (3)."""
    joined = list(marker)
    cameras = {frame.camera[image] for image in marker}
    for s, images in ranked:
        if s in cameras:
            continue
        lines = [frame.lines[s][image] for image in marker]
        u, v = _meet(*max(combinations(lines, 2), key=lambda two: abs(_steepness(*two))))
        distance, best = min((hypot(u - frame.uv[j][0], v - frame.uv[j][1]), j) for j in images)
        if distance < radius:
            joined.append(best)
    return joined
