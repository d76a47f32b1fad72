"""Tracking by the nearest distance alone, to which Swamidas (1997, 4.2.4) compares his predictor.

All distances between the tracks' last points and the points of a frame are sorted, and the shortest is taken first;
each track and each point once. A track without a point keeps its last one for as long as it takes. Nothing is
predicted, and no distance is too long: with all points in sight, every track has a point in every frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...data import Cloud, Tracks
from ...data.array_types import Floats, Ints
from ...data.method import Method, parameter
from ...data.progress import tell
from ..stage import CLOUD, TRACK


@dataclass(frozen=True, slots=True)
class DistanceOnly(Method):
    """The nearest distance alone, shortest first, without prediction.

    The document's method has no parameters; these are ours.
    """

    initiate_from: Literal["first", "any"] = parameter(
        "first",
        former="begin",
        meaning="which points begin tracks: first, those of the first frame that has any, or any, those that no "
        "track takes",
    )
    max_coasting: float | None = parameter(
        None,
        former="patience",
        unit="s",
        above=0,
        meaning="coasting: how long a track without points waits; None: for ever",
    )


@TRACK.method("distance_only", DistanceOnly, source="Swamidas 1997, 4.2.4", takes=CLOUD)
def track_distance(cloud: Cloud, *, method: DistanceOnly = DistanceOnly()) -> Tracks:
    """The cloud with identities, numbered as the tracks begin; within a frame in the order of its points."""
    identity = np.full(len(cloud), -1)
    max_missed = np.inf if method.max_coasting is None else method.max_coasting * cloud.rate
    own, last, missed = np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0, np.int64)
    n_tracks = 0
    for f in range(cloud.n_frames):
        tell(f, cloud.n_frames)
        rows = cloud.rows(f)
        points = cloud.xyz[rows]
        track, point = shortest_first(np.linalg.norm(points - last[:, None], axis=-1))
        identity[rows][point] = own[track]
        last[track] = points[point]
        missed += 1
        missed[track] = 0
        if method.initiate_from == "any" or not n_tracks:
            fresh = np.setdiff1d(np.arange(len(points)), point)
            new = np.arange(n_tracks, n_tracks + len(fresh))
            identity[rows][fresh] = new
            own, last = np.concatenate([own, new]), np.concatenate([last, points[fresh]])
            missed = np.concatenate([missed, np.zeros(len(fresh), np.int64)])
            n_tracks += len(fresh)
        alive = missed <= max_missed
        own, last, missed = own[alive], last[alive], missed[alive]
    return Tracks(cloud, identity)


def shortest_first(distance: Floats) -> tuple[Ints, Ints]:
    """Rows and columns of (n, m) distances taken in rising order, each row and each column once."""
    distance = distance.copy()
    rows, columns = [], []
    for _ in range(min(distance.shape)):
        row, column = divmod(int(distance.argmin()), distance.shape[1])
        rows.append(row)
        columns.append(column)
        distance[row], distance[:, column] = np.inf, np.inf
    return np.array(rows, np.int64), np.array(columns, np.int64)
