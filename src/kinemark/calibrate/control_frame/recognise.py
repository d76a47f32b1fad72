"""Recognising the rods of the calibration frame in an image, and calibrating from them (KISS 3.3).

1. Rows: a line through two points, with all points within a slack of it (a lens bends rods a little).
2. Readings: each row as a rod, by its spacings (`spacing`).
3. Assignments: one reading for each of as many rods as possible, no point used twice, the best fits first. An
   assignment is right if one camera sees all its markers where they are: two rods mistaken for each other
   cannot both fit. A DLT within the slack is the first test; a camera with one lens term, whose residual must be
   within `tolerance` however much the lens bends lines, is the second.
4. With that camera all markers are projected into the image, and each takes the nearest point within reach;
   so markers return that a row lacked, and rods that were not read.

The slack begins at `tolerance` and grows until the rods are found. Points that belong to no rod (strobes of other
cameras, reflections) take part in nothing but failed readings.

A rod that hangs elsewhere than described, or a marker that sits elsewhere on it, is found by no camera, and the others
suffice. Two rods that hang at each other's places leave too few: then each pair is swapped in turn, moved across
its direction, and the pair with which a camera fits is named.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ...data import Camera, Detections, KinemarkError, Rig, Rods
from ...data.array_types import Floats, Ints
from ...geometry import decompose, fit_dlt, from_dlt, project, undistort
from ..control_points import (
    ControlFit,
    ControlPoints,
    calibrate_control_points,
    control_point_quality,
    free_parameters,
)
from ..control_points.fit_camera import CameraMethod
from ..resection import resect
from .spacing import Reading, fewest_markers, readings

MOST_POINTS = 100  # images of a camera at most; chosen, lest the search take minutes
MOST_IN_ROW = 10  # points on one line at most; chosen for speed
READINGS_A_ROD = 8  # best readings of each rod that are kept; chosen for speed
TRIALS = 300  # assignments of readings to rods that are tried at most; chosen for speed
TRIALS_SWAPPED = 12  # the same, for rods that hang at each other's places; chosen for speed
TRIALS_FEWER = 40  # the same, with one rod fewer; chosen for speed
ENOUGH = 5  # assignments that fit, after which the best of them is taken; chosen
SLACK = (1.0, 3.0, 9.0)  # times the tolerance, tried one after the other; chosen
TOLERANCE = 3.0  # px by which an image may be off its rod's place; chosen
UNCERTAIN = 0.15  # of the tolerance, RMS, above which one rod may hang elsewhere; chosen
MUCH_BETTER = 0.25  # of the RMS, which a fit with one rod fewer must come below to be believed; chosen


def calibrate_control_frame(
    detections: Detections,
    rods: Rods,
    *,
    sizes: ArrayLike,
    frame: int = 0,
    tolerance: float = TOLERANCE,
    method: CameraMethod | None = None,
    lenses: Sequence[Camera] | None = None,
    diameter: float | None = None,
) -> Rig:
    """The rig from one frame in which cameras of image sizes (C, 2) px see the calibration frame.

    Args:
        detections: of all cameras; only valid ones are looked at.
        rods: the calibration frame as surveyed.
        sizes: (C, 2) width and height of the images, px.
        frame: which of the detections' frames.
        tolerance: as in `recognise_control_frame`.
        method: how the cameras are fitted once the markers are known.
        lenses: (C) linearised cameras, as in `calibrate_control_points`; rods are then straight in their images.
        diameter: of the markers, mm; without it that of `rods`, and 0 corrects nothing.

    Raises:
        ValueError: there is no such frame.
        KinemarkError: a camera in which the rods are not recognised, or see `calibrate_control_points`.
    """
    uv, cov = _recognised(detections, rods, frame, tolerance, lenses)
    return calibrate_control_points(
        detections.cameras,
        sizes,
        rods.xyz.reshape(-1, 3),
        uv,
        cov=cov,
        method=method,
        lenses=lenses,
        diameter=rods.marker_diameter if diameter is None else diameter,
        points=rods.marker_names,
    )


def control_frame_quality(
    detections: Detections,
    rods: Rods,
    *,
    sizes: ArrayLike,
    method: CameraMethod | None = None,
    lenses: Sequence[Camera] | None = None,
) -> ControlFit:
    """The rig of `calibrate_control_frame` from the first frame, with residuals and errors of markers left out;
    arguments as there."""
    uv, cov = _recognised(detections, rods, 0, TOLERANCE, lenses)
    return control_point_quality(
        detections.cameras,
        sizes,
        rods.xyz.reshape(-1, 3),
        uv,
        cov=cov,
        method=method,
        lenses=lenses,
        diameter=rods.marker_diameter,
        points=rods.marker_names,
    )


def _recognised(
    detections: Detections, rods: Rods, frame: int, tolerance: float, lenses: Sequence[Camera] | None
) -> tuple[Floats, Floats]:
    """Where every camera sees the markers (R·K): (C, R·K, 2) px and covariance, NaN where it does not."""
    if not 0 <= frame < detections.n_frames:
        raise ValueError(f"frame is {frame}, wanted one of the {detections.n_frames} frames from 0 on")
    uv = np.full((len(detections.cameras), rods.xyz.shape[0] * rods.xyz.shape[1], 2), np.nan)
    cov = np.full((*uv.shape, 2), np.nan)
    for c, name in enumerate(detections.cameras):
        rows = np.arange(len(detections))[detections.rows(c, frame)]
        rows = rows[detections.valid[rows]]
        points = detections.uv[rows] if lenses is None else undistort(lenses[c], detections.uv[rows])
        inside = np.isfinite(points).all(1)
        rows, points = rows[inside], points[inside]
        try:
            index = identify_markers(points, rods, tolerance=tolerance).ravel()
        except KinemarkError as error:
            raise KinemarkError(f"Camera {name}: {error}") from None
        uv[c, index >= 0] = detections.uv[rows[index[index >= 0]]]
        cov[c, index >= 0] = detections.cov[rows[index[index >= 0]]]
    return uv, cov


def recognise_control_frame(uv: Floats, rods: Rods, *, tolerance: float = TOLERANCE) -> Floats:
    """Which of the points (n, 2) px is which marker: (R, K, 2) px, NaN where a marker is not seen.

    `tolerance` is the RMS distance, px, at which markers may lie from where a camera with one lens term sees them.

    Raises:
        KinemarkError: the rods are not recognised; the message says how many were.
    """
    index = identify_markers(uv, rods, tolerance=tolerance)
    return np.where(index[..., None] >= 0, uv[index], np.nan)


def identify_markers(uv: Floats, rods: Rods, *, tolerance: float = TOLERANCE) -> Ints:
    """Row of `uv` (n, 2) for each marker (R, K), −1 where it is not seen; errors as in `recognise_control_frame`."""
    if len(uv) > MOST_POINTS:
        raise KinemarkError(
            f"{len(uv)} points are seen where {rods.present.sum()} markers hang. Raise the threshold, mask what is "
            "not the calibration frame, or limit the size of markers."
        )
    tight = _readings(uv, rods, tolerance)
    for slack in SLACK:
        read = tight if slack == 1 else _readings(uv, rods, tolerance * slack)
        for size in range(len(rods.names), 2, -1):
            found = _best(_assignments(read, size), uv, rods, tolerance, slack)
            if found is None:
                continue
            if found.rms > UNCERTAIN * tolerance:  # one rod may hang elsewhere, and the others tell better
                fewer = _best(
                    _assignments(read, max(size - 1, 3), TRIALS_FEWER), uv, rods, tolerance, slack, sharpest=True
                )
                found = fewer if fewer is not None and fewer.rms < MUCH_BETTER * found.rms else found
            return found.markers
    like = [name for name, options in zip(rods.names, tight, strict=True) if options]
    swapped = _swapped(tight, uv, rods, tolerance)
    named = f" ({', '.join(like)})" if like else ""
    raise KinemarkError(
        f"Among {len(uv)} points, {len(like)} of {len(rods.names)} rods have their like by spacing{named}, and no "
        f"three of them fit one camera. {swapped}At least five markers of each of three rods must be seen. Check the "
        "places of the markers, the threshold, and whether rods hide each other."
    )


def _swapped(read: list[list[Reading]], uv: Floats, rods: Rods, tolerance: float) -> str:
    """The pairs of rods that may hang at each other's places, as a sentence, if a camera sees them so.

    Rods at the corners of a rectangle look the same after half a turn, with the other two swapped: both are named.
    """
    pairs = []
    for a, b in combinations(range(len(rods.names)), 2):
        if not read[a] or not read[b]:
            continue
        xyz = rods.xyz.copy()
        across = np.nanmean(xyz[b], axis=0) - np.nanmean(xyz[a], axis=0)
        axis = rods.axes[a]
        across = across - (across @ axis) * axis
        xyz[a], xyz[b] = xyz[a] + across, xyz[b] - across
        moved = replace(rods, xyz=xyz)
        if _best(_assignments(read, len(rods.names), TRIALS_SWAPPED), uv, moved, tolerance, 1.0) is not None:
            pairs.append(f"{rods.names[a]} and {rods.names[b]}")
    if not pairs:
        return ""
    return f"They do if {', or '.join(pairs)}, hang at each other's places: exchange two rods, or their coordinates. "


def rows_of_points(uv: Floats, *, tolerance: float, fewest: int, most: int = MOST_IN_ROW) -> list[Ints]:
    """Points (n, 2) on common lines, `fewest` to `most` each, sorted along the line; each set once."""
    pairs = np.array(list(combinations(range(len(uv)), 2)), np.int64).reshape(-1, 2)
    a, d = uv[pairs[:, 0]], uv[pairs[:, 1]] - uv[pairs[:, 0]]
    length = np.linalg.norm(d, axis=1)
    pairs, a, d, length = (x[length > 0] for x in (pairs, a, d, length))
    offset = uv[None] - a[:, None]
    distance = np.abs(offset[..., 0] * d[:, None, 1] - offset[..., 1] * d[:, None, 0]) / length[:, None]
    near = distance <= tolerance
    near = np.unique(near[(near.sum(1) >= fewest) & (near.sum(1) <= most)], axis=0)
    return [_in_order(uv, np.flatnonzero(row)) for row in near]


def _in_order(uv: Floats, row: Ints) -> Ints:
    """The row (m) sorted along the line that fits its points best."""
    centred = uv[row] - uv[row].mean(0)
    direction = np.linalg.eigh(centred.T @ centred)[1][:, -1]
    return row[np.argsort(centred @ direction)]


def _readings(uv: Floats, rods: Rods, tolerance: float) -> list[list[Reading]]:
    """Readings of each rod, most markers and least error first."""
    whole = rods.present.sum(1)
    fewest = min(fewest_markers(int(k)) for k in whole)
    rows = rows_of_points(uv, tolerance=tolerance, fewest=fewest, most=max(MOST_IN_ROW, int(whole.max()) + 3))
    read: list[list[Reading]] = [[] for _ in rods.names]
    for reading in readings(rows, uv, rods.along, tolerance=tolerance):
        read[reading.rod].append(reading)
    return [sorted(set(options), key=lambda r: (-r.seen, r.error))[:READINGS_A_ROD] for options in read]


def _assignments(read: list[list[Reading]], size: int, most: int = TRIALS) -> Iterator[tuple[Reading, ...]]:
    """Choices of one reading for each of `size` rods, no point used twice, the best first."""
    chosen = []
    for rods in combinations(range(len(read)), size):
        for choice in product(*(read[rod] for rod in rods)):
            used = [p for reading in choice for p in reading.points if p >= 0]
            if len(set(used)) == len(used):
                chosen.append(choice)
    chosen.sort(key=lambda choice: (-sum(r.seen for r in choice), sum(r.error**2 for r in choice)))
    return iter(chosen[:most])


class _AssignedPoints(NamedTuple):
    """Row of the points for each marker (R, K), −1 where it is not seen, and how far off the camera's are, RMS px."""

    markers: Ints
    rms: float


def _best(
    assignments: Iterator[tuple[Reading, ...]],
    uv: Floats,
    rods: Rods,
    tolerance: float,
    slack: float,
    sharpest: bool = False,
) -> _AssignedPoints | None:
    """Of the first few right assignments the one that finds most markers, the first that finds all; or the sharpest."""
    best: _AssignedPoints | None = None
    right = 0
    for assignment in assignments:
        found = _completed(assignment, uv, rods, tolerance, slack)
        if found is None:
            continue
        right += 1
        more = best is None or (found.markers >= 0).sum() > (best.markers >= 0).sum()
        if best is None or (found.rms < best.rms if sharpest else more):
            best = found
        if not sharpest and ((best.markers >= 0)[rods.present].all() or right == ENOUGH):
            break
    return best


def _completed(
    assignment: tuple[Reading, ...], uv: Floats, rods: Rods, tolerance: float, slack: float
) -> _AssignedPoints | None:
    """All markers that one camera sees if the assignment is right, or None if it is not."""
    index = np.full(rods.xyz.shape[:2], -1, np.int64)
    for reading in assignment:
        index[reading.rod] = reading.points
    fewest = int((index >= 0).sum())
    rms = float("inf")
    for _ in range(2):
        camera = _camera(rods.xyz[index >= 0], uv[index[index >= 0]], tolerance, slack)
        if camera is None:
            return None
        rms = camera.residual
        index = _nearest(project(camera, rods.xyz.reshape(-1, 3)), uv, 2 * tolerance).reshape(index.shape)
    return _AssignedPoints(index, rms) if (index >= 0).sum() >= fewest else None


def _camera(xyz: Floats, uv: Floats, tolerance: float, slack: float) -> Camera | None:
    """The camera with one lens term that sees these markers (N, 3) at these points (N, 2), if there is one."""
    try:
        P = from_dlt(fit_dlt(xyz, uv))
        seen = np.column_stack([xyz, np.ones(len(xyz))]) @ P.T
        if not _rms(uv - seen[:, :2] / seen[:, 2:]) <= tolerance * slack:
            return None
        K, R, t = decompose(P, front=xyz.mean(0))
    except KinemarkError:
        return None
    if K[1, 1] < 0:  # mirrored: images count v downwards, so two rods hang at each other's places
        return None
    K[0, 1] = 0.0
    start = Camera("", np.zeros(2, np.int64), K, R, t)
    same_weight = np.tile(np.eye(2), (len(uv), 1, 1))
    fit = resect(start, xyz, uv, same_weight, free=free_parameters(len(uv), ControlPoints()), steps=15)
    return fit.camera if _rms(fit.residual) <= tolerance else None


def _rms(residual: Floats) -> float:
    return float(np.sqrt((residual**2).sum(1).mean()))


def _nearest(projected: Floats, uv: Floats, reach: float) -> Ints:
    """One point (n, 2) for each projected marker (M, 2) within reach, none twice: (M) index or −1."""
    distance = np.linalg.norm(projected[:, None] - uv[None], axis=-1)
    distance = np.where(np.isfinite(distance), distance, np.inf)  # a marker behind the camera
    marker, point = scipy.optimize.linear_sum_assignment(np.minimum(distance, 2 * reach))
    index = np.full(len(projected), -1, np.int64)
    close = distance[marker, point] <= reach
    index[marker[close]] = point[close]
    return index
