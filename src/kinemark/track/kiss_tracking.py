"""Tracking as the Kiss system does it (Shafiq, Tümer and Güler 2001, 4.3).

Every point of the first frame starts a track. A track is predicted into the next frame by the ladder of
`signal.extrapolation`:

    points known   1                2                 3, 4                          5 or more
    prediction     where it is      line              line through the last 3       parabola through the last 5

and takes the point nearest to the prediction within the search sphere (1), or, with one point known, the nearest
neighbour within the distance limit (2). Where two tracks want one point, it goes to the nearer; the paper does not say.
A track that finds none ends there, and points that no track takes start new ones (3). When all frames are through,
pieces that end and start within two fields and agree are blended (4), and short tracks, most of them ghosts, removed
(5): `editing`, whose functions can be used alone.

All limits are lengths that fit one rate and one kind of motion; the defaults are for gait at 50 Hz. A track ends at its
first miss, so where a marker is lost for longer than two fields it comes in pieces, and a ghost within the sphere that
is nearer than the marker leads a track astray. `ladder` takes its limits from the rate and the covariances.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..data import Cloud, Tracks
from ..data.array_types import Floats, Ints
from ..data.arrays import check_positive
from ..geometry.weighted_points import inside_volume
from ..signal import PAST, assign_nearest, extrapolate
from .editing import blend, without_short

Volume = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True, slots=True)
class KissTracking:
    """Parameters of the method; of the paper's values only the two fields (of 50 Hz) of blending are known.

    Attributes:
        search_radius: of the search sphere about a prediction, mm; (1).
        distance_limit: of the nearest neighbour of a track of one point, mm; (2).
        blend_within: longest time from the end of a track to the start of one that continues it, s; (4). 0: none.
        shortest: tracks of fewer points than this lose their identity; (5).
        volume: least and greatest corner of the control volume, mm; points outside are dropped first. None: all stay.
    """

    search_radius: float = 40.0
    distance_limit: float = 100.0
    blend_within: float = 0.04
    shortest: int = 10
    volume: Volume | None = None

    def __post_init__(self) -> None:
        check_positive(search_radius=self.search_radius, distance_limit=self.distance_limit, shortest=self.shortest)
        if not 0 <= self.blend_within <= 60:
            raise ValueError(f"blend_within is {self.blend_within}, wanted 0 to 60 s")
        if self.volume is not None and not all(a < b for a, b in zip(*self.volume, strict=True)):
            raise ValueError(f"volume is {self.volume}, wanted its least corner and then its greatest")


class ActiveKissTrack(NamedTuple):
    """T tracks that may grow: id (T); known (T) points so far; past (T, 5, 3) the last of them, mm."""

    id: Ints
    known: Ints
    past: Floats


def track_kiss(cloud: Cloud, *, method: KissTracking) -> Tracks:
    """The cloud's points within the volume, with identities; called through `track`."""
    if method.volume is not None:
        cloud = cloud.keep(inside_volume(cloud.xyz, method.volume))
    tracks = link(cloud, method=method)
    blended = blend(tracks, within=method.blend_within, radius=method.search_radius, reach=method.distance_limit)  # (4)
    return without_short(blended, shortest=method.shortest)  # (5)


def link(cloud: Cloud, *, method: KissTracking) -> Tracks:
    """All track pieces, (1) to (3), numbered in the order in which they begin."""
    identity = np.full(len(cloud), -1)
    active = ActiveKissTrack(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, PAST, 3)))
    n_tracks = 0
    for f in range(cloud.n_frames):
        points, own = cloud[f], identity[cloud.rows(f)]
        predicted = extrapolate(active.past, active.known)
        off = np.linalg.norm(points - predicted[:, None], axis=-1)
        limit = np.where(active.known > 1, method.search_radius, method.distance_limit)
        which, taken = assign_nearest(off, limit)
        own[taken] = active.id[which]
        fresh = np.flatnonzero(own < 0)  # (3)
        own[fresh] = np.arange(n_tracks, n_tracks + len(fresh))
        n_tracks += len(fresh)
        grown = np.concatenate([active.past[which, 1:], points[taken, None]], 1)
        active = ActiveKissTrack(
            np.concatenate([active.id[which], own[fresh]]),
            np.concatenate([active.known[which] + 1, np.ones(len(fresh), np.int64)]),
            np.concatenate([grown, np.repeat(points[fresh, None], PAST, 1)]),
        )
    return Tracks(cloud, identity)
