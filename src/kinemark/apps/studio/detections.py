"""Detections as the page draws them, and epipolar lines through lenses."""

from __future__ import annotations

import numpy as np

from ...data import Detections, KinemarkError, Rig, Trajectories
from ...data.array_types import Floats, Ints
from ...geometry import project, undistort
from .desk import OpenDocument
from .messages import DetectionsHeader, EpipolarLine

MOST_FRAMES = 2000
"""That are sent at a time; chosen: 16 MB of 60 markers in 8 cameras."""
POINTS = 64
"""Of an epipolar line; chosen: lenses bend it smoothly."""
BEYOND = 0.5
"""Of the depth of the markers, by which a line goes on before and behind them; chosen."""
MARGIN = 0.1
"""Of an image's size, outside of which a line is not drawn; chosen."""


def seen_between(document: OpenDocument, first: int, last: int) -> tuple[DetectionsHeader, bytes]:
    """The columns of frames first … last, numbers in the recording.

    Raises:
        KinemarkError: there are no detections, or not these frames.
    """
    detections, now = document.editing.detections, document.now.trajectories
    if detections is None:
        raise KinemarkError("This trial has no detections: it is a file of trajectories.")
    a, stop = first - now.first_frame, last - now.first_frame + 1
    if not 0 <= a < stop <= detections.n_frames:
        raise KinemarkError(f"There are frames {now.first_frame} to {now.first_frame + detections.n_frames - 1}.")
    rows = np.concatenate([np.arange(start[a], start[stop]) for start in detections.start])
    about = DetectionsHeader(
        cameras=list(detections.cameras), first=first, last=last, detections=len(rows), head=document.head
    )
    counts = np.diff(detections.start[:, a : stop + 1], axis=1)
    track = _tracks_of(rows, detections, now, a, stop)
    columns = (
        counts.astype("<u4"), detections.uv[rows].astype("<f4"), track.astype("<i4"), detections.validity[rows]
    )  # fmt: skip
    return about, b"".join(column.tobytes() for column in columns)


def _tracks_of(rows: Ints, detections: Detections, now: Trajectories, a: int, stop: int) -> Ints:
    """The trajectory that each row belongs to, −1 for none; `rows` rise."""
    of = np.full(len(rows), -1, np.int64)
    for k, path in enumerate(now):
        own = path.detection[a:stop]
        own = own[own >= 0]
        at = np.searchsorted(rows, own)
        hit = (at < len(rows)) & (rows[at.clip(0, len(rows) - 1)] == own) if len(rows) else np.zeros(len(own), bool)
        of[at[hit]] = k
    return of


def epipolar_lines(document: OpenDocument, camera: str, u: float, v: float) -> list[EpipolarLine]:
    """In every other camera, through its lens, over the depths that the markers have.

    Raises:
        KinemarkError: the trial has no cameras, or none of this name.
    """
    rig = document.editing.rig
    if rig is None or camera not in rig.names:
        raise KinemarkError(f"There is no camera {camera} in this trial.")
    if not np.isfinite([u, v]).all():
        raise KinemarkError("A place in an image is two finite numbers, px.")
    ray = _ray(rig, rig.names.index(camera), u, v, document.now.trajectories)
    found = []
    for other in rig:
        if other.name == camera:
            continue
        front = (ray @ other.R.T + other.t)[:, 2] > 0
        uv = project(other, ray[front])
        low, high = -MARGIN * other.size, (1 + MARGIN) * other.size
        inside = (uv >= low).all(1) & (uv <= high).all(1) if other.size.any() else np.ones(len(uv), bool)
        if inside.sum() > 1:
            found.append(EpipolarLine(camera=other.name, points=[(x, y) for x, y in uv[inside].tolist()]))
    return found


def _ray(rig: Rig, c: int, u: float, v: float, now: Trajectories) -> Floats:
    """(POINTS, 3) mm, places that a camera sees at a pixel, over the depths of the markers."""
    camera = rig[c]
    ideal = undistort(camera, np.array([[u, v]]))[0]
    way = np.linalg.solve(camera.K, np.array([*ideal, 1.0]))
    xyz = now.xyz.reshape(-1, 3)
    depth = (xyz[np.isfinite(xyz[:, 0])] @ camera.R[2]) + camera.t[2]
    depth = depth[depth > 0]
    near, far = (float(depth.min()), float(depth.max())) if len(depth) else (1000.0, 10000.0)
    reach = BEYOND * (far - near)
    depths = np.geomspace(max(near - reach, near / 2), far + reach, POINTS)
    return (depths[:, None] * way - camera.t) @ camera.R
