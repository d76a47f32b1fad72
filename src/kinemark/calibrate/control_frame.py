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
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import linear_sum_assignment

from ..data import Camera, Detections, KinemarkError, Rig, Rods
from ..geometry import decompose, fit_dlt, from_dlt, project
from .control_points import ControlPoints, calibrate_control_points, free_parameters
from .resection import resect
from .spacing import Reading, readings

MOST_POINTS = 100
MOST_IN_ROW = 10
READINGS_A_ROD = 8
TRIALS = 300
ENOUGH = 5
SLACK = (1.0, 3.0, 9.0)
TOLERANCE = 3.0


def calibrate_control_frame(
    detections: Detections,
    rods: Rods,
    *,
    sizes: ArrayLike,
    frame: int = 0,
    tolerance: float = TOLERANCE,
    method: ControlPoints | None = None,
) -> Rig:
    """The rig from one frame in which cameras of image sizes (C, 2) px see the calibration frame.

    Args:
        detections: of all cameras; only valid ones are looked at.
        rods: the calibration frame as surveyed.
        sizes: (C, 2) width and height of the images, px.
        frame: which of the detections' frames.
        tolerance: as in `recognise_control_frame`.
        method: how the cameras are fitted once the markers are known.

    Raises:
        ValueError: there is no such frame.
        KinemarkError: a camera in which the rods are not recognised, or see `calibrate_control_points`.
    """
    if not 0 <= frame < detections.n_frames:
        raise ValueError(f"frame is {frame}, wanted one of the {detections.n_frames} frames from 0 on")
    uv = np.full((len(detections.cameras), rods.xyz.shape[0] * rods.xyz.shape[1], 2), np.nan)
    cov = np.full((*uv.shape, 2), np.nan)
    for c, name in enumerate(detections.cameras):
        rows = np.arange(len(detections))[detections.rows(c, frame)]
        rows = rows[detections.valid[rows]]
        try:
            index = identify_markers(detections.uv[rows], rods, tolerance=tolerance).ravel()
        except KinemarkError as error:
            raise KinemarkError(f"Camera {name}: {error}") from None
        uv[c, index >= 0] = detections.uv[rows[index[index >= 0]]]
        cov[c, index >= 0] = detections.cov[rows[index[index >= 0]]]
    return calibrate_control_points(detections.cameras, sizes, rods.xyz.reshape(-1, 3), uv, cov=cov, method=method)


def recognise_control_frame(
    uv: NDArray[np.float64], rods: Rods, *, tolerance: float = TOLERANCE
) -> NDArray[np.float64]:
    """Which of the points (n, 2) px is which marker: (R, K, 2) px, NaN where a marker is not seen.

    `tolerance` is the RMS distance, px, at which markers may lie from where a camera with one lens term sees them.

    Raises:
        KinemarkError: the rods are not recognised; the message says how many were.
    """
    index = identify_markers(uv, rods, tolerance=tolerance)
    return np.where(index[..., None] >= 0, uv[index], np.nan)


def identify_markers(uv: NDArray[np.float64], rods: Rods, *, tolerance: float = TOLERANCE) -> NDArray[np.int64]:
    """Row of `uv` (n, 2) for each marker (R, K), −1 where it is not seen; errors as in `recognise_control_frame`."""
    if len(uv) > MOST_POINTS:
        raise KinemarkError(
            f"{len(uv)} points are seen where {rods.xyz[..., 0].size} markers hang. Raise the threshold, mask what is "
            "not the calibration frame, or limit the size of markers."
        )
    tight = _readings(uv, rods, tolerance)
    for slack in SLACK:
        read = tight if slack == 1 else _readings(uv, rods, tolerance * slack)
        for size in range(len(rods.names), 2, -1):
            index = _best(_assignments(read, size), uv, rods, tolerance, slack)
            if index is not None:
                return index
    like = sum(bool(options) for options in tight)
    raise KinemarkError(
        f"Among {len(uv)} points, {like} of {len(rods.names)} rods have their like by spacing, and no three of them "
        "fit one camera. At least five markers of each of three rods must be seen. Check the places of the markers, "
        "the threshold, and whether rods hide each other."
    )


def rows_of_points(uv: NDArray[np.float64], *, tolerance: float, fewest: int) -> list[NDArray[np.int64]]:
    """Points (n, 2) on common lines, at least `fewest` each, sorted along the line; each set once."""
    pairs = np.array(list(combinations(range(len(uv)), 2)), np.int64).reshape(-1, 2)
    a, d = uv[pairs[:, 0]], uv[pairs[:, 1]] - uv[pairs[:, 0]]
    length = np.linalg.norm(d, axis=1)
    pairs, a, d, length = (x[length > 0] for x in (pairs, a, d, length))
    offset = uv[None] - a[:, None]
    off_line = np.abs(offset[..., 0] * d[:, None, 1] - offset[..., 1] * d[:, None, 0]) / length[:, None]
    near = off_line <= tolerance
    near = np.unique(near[(near.sum(1) >= fewest) & (near.sum(1) <= MOST_IN_ROW)], axis=0)
    return [_in_order(uv, np.flatnonzero(row)) for row in near]


def _in_order(uv: NDArray[np.float64], row: NDArray[np.int64]) -> NDArray[np.int64]:
    q = _along(uv[row])
    return row[np.argsort(q)]


def _along(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m) place of points (m, 2) along the line that fits them best, px."""
    centred = points - points.mean(0)
    return np.asarray(centred @ np.linalg.svd(centred, full_matrices=False)[2][0])


def _readings(uv: NDArray[np.float64], rods: Rods, tolerance: float) -> list[list[Reading]]:
    """Readings of each rod, most markers and least error first."""
    fewest = max(5, rods.xyz.shape[1] - 1)
    read: list[list[Reading]] = [[] for _ in rods.names]
    for row in rows_of_points(uv, tolerance=tolerance, fewest=fewest):
        for reading in readings(row, _along(uv[row]), rods.along, tolerance=tolerance, fewest=fewest):
            read[reading.rod].append(reading)
    return [sorted(set(options), key=lambda r: (-r.seen, r.error))[:READINGS_A_ROD] for options in read]


def _assignments(read: list[list[Reading]], size: int) -> Iterator[tuple[Reading, ...]]:
    """Choices of one reading for each of `size` rods, no point used twice, the best first."""
    chosen = []
    for rods in combinations(range(len(read)), size):
        for choice in product(*(read[rod] for rod in rods)):
            used = [p for reading in choice for p in reading.points if p >= 0]
            if len(set(used)) == len(used):
                chosen.append(choice)
    chosen.sort(key=lambda choice: (-sum(r.seen for r in choice), sum(r.error**2 for r in choice)))
    return iter(chosen[:TRIALS])


def _best(
    assignments: Iterator[tuple[Reading, ...]], uv: NDArray[np.float64], rods: Rods, tolerance: float, slack: float
) -> NDArray[np.int64] | None:
    """Of the first few right assignments, the one that finds most markers; the first that finds all."""
    best: NDArray[np.int64] | None = None
    right = 0
    for assignment in assignments:
        index = _completed(assignment, uv, rods, tolerance, slack)
        if index is None:
            continue
        right += 1
        if best is None or (index >= 0).sum() > (best >= 0).sum():
            best = index
        if (best >= 0).all() or right == ENOUGH:
            break
    return best


def _completed(
    assignment: tuple[Reading, ...], uv: NDArray[np.float64], rods: Rods, tolerance: float, slack: float
) -> NDArray[np.int64] | None:
    """All markers (R, K) that one camera sees if the assignment is right, or None if it is not."""
    index = np.full(rods.xyz.shape[:2], -1, np.int64)
    for reading in assignment:
        index[reading.rod] = reading.points
    fewest = int((index >= 0).sum())
    for _ in range(2):
        camera = _camera(rods.xyz[index >= 0], uv[index[index >= 0]], tolerance, slack)
        if camera is None:
            return None
        index = _nearest(project(camera, rods.xyz.reshape(-1, 3)), uv, 2 * tolerance).reshape(index.shape)
    return index if (index >= 0).sum() >= fewest else None


def _camera(xyz: NDArray[np.float64], uv: NDArray[np.float64], tolerance: float, slack: float) -> Camera | None:
    """The camera with one lens term that sees these markers (N, 3) at these points (N, 2), if there is one."""
    try:
        P = from_dlt(fit_dlt(xyz, uv))
        seen = np.column_stack([xyz, np.ones(len(xyz))]) @ P.T
        if not _rms(uv - seen[:, :2] / seen[:, 2:]) <= tolerance * slack:
            return None
        K, R, t = decompose(P, front=xyz.mean(0))
    except KinemarkError:
        return None
    K[0, 1] = 0.0
    start = Camera("", np.zeros(2, np.int64), K, R, t)
    same_weight = np.tile(np.eye(2), (len(uv), 1, 1))
    fit = resect(start, xyz, uv, same_weight, free=free_parameters(len(uv), ControlPoints()), steps=15)
    return fit.camera if _rms(fit.residual) <= tolerance else None


def _rms(off: NDArray[np.float64]) -> float:
    return float(np.sqrt((off**2).sum(1).mean()))


def _nearest(projected: NDArray[np.float64], uv: NDArray[np.float64], reach: float) -> NDArray[np.int64]:
    """One point (n, 2) for each projected marker (M, 2) within reach, none twice: (M) index or −1."""
    distance = np.linalg.norm(projected[:, None] - uv[None], axis=-1)
    distance = np.where(np.isfinite(distance), distance, np.inf)  # a marker behind the camera
    marker, point = linear_sum_assignment(np.minimum(distance, 2 * reach))
    index = np.full(len(projected), -1, np.int64)
    close = distance[marker, point] <= reach
    index[marker[close]] = point[close]
    return index
