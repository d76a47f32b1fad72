"""Tracking as the Kiss system does it (Shafiq, Tümer and Güler 2001, 4.3).

Every point of the first frame starts a track. A track is predicted into the next frame by the ladder of
`signal.extrapolation`:

    points known   1                2                 3, 4                          5 or more
    prediction     where it is      line              line through the last 3       parabola through the last 5

and takes the point nearest to the prediction within the search sphere (1), or, with one point known, the nearest
neighbour within the distance limit (2). Where two tracks want one point, it goes to the nearer; the paper does not say.
A track that finds none ends there, and points that no track takes start new ones (3). When all frames are through,
fragments that end and start within two fields and agree are blended (4), and short tracks, most of them ghosts, removed
(5): `editing`, whose functions can be used alone.

All limits are lengths that fit one rate and one kind of motion; the defaults are for gait at 50 Hz. A track ends at its
first miss, so where a marker is lost for longer than two fields it comes in fragments, and a ghost within the sphere
that is nearer than the marker leads a track astray. `ladder` takes its limits from the rate and the covariances.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..data import Cloud, Tracks
from ..data.array_types import Floats, Ints
from ..data.method import Method, parameter
from ..data.progress import tell
from ..geometry.weighted_points import inside_volume
from ..signal import PAST, assign_nearest, extrapolate
from .editing import blend, without_short
from .stage import CLOUD, TRACK

Volume = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True, slots=True)
class KissTracking(Method):
    """Extrapolation, a search sphere and blending of fragments: the tracking of the Kiss system.

    Of the paper's values only the two fields (of 50 Hz) of blending are known.
    """

    search_radius: float = parameter(
        40.0, unit="mm", above=0, meaning="radius of the search sphere (gate) about a prediction; (1)"
    )
    max_distance: float = parameter(
        100.0,
        former="distance_limit",
        unit="mm",
        above=0,
        meaning="farthest nearest neighbour of a track of one point; (2)",
    )
    max_gap: float = parameter(
        0.04, former="blend_within", unit="s", low=0, high=60,
        meaning="longest time from the end of a track to the start of one that continues it (stitching); (4); 0: "
        "none",
    )  # fmt: skip
    min_points: int = parameter(
        10, former="shortest", unit="points", low=1, meaning="tracks of fewer points than this lose their identity; (5)"
    )
    volume: Volume | None = parameter(
        None, unit="mm",
        meaning="least and greatest corner of the control volume; points outside are dropped first; None: all stay",
    )  # fmt: skip

    def check_together(self) -> None:
        """Refuse a volume whose corners are swapped."""
        if self.volume is not None and not all(a < b for a, b in zip(*self.volume, strict=True)):
            raise ValueError(f"volume is {self.volume}, wanted its least corner and then its greatest")


class ActiveKissTrack(NamedTuple):
    """T tracks that may grow: id (T); known (T) points so far; past (T, 5, 3) the last of them, mm."""

    id: Ints
    known: Ints
    past: Floats


@TRACK.method("kiss_tracking", KissTracking, source="Shafiq, Tümer and Güler 2001, 4.3", takes=CLOUD)
def track_kiss(cloud: Cloud, *, method: KissTracking) -> Tracks:
    """The cloud's points within the volume, with identities; called through `track`."""
    if method.volume is not None:
        cloud = cloud.keep(inside_volume(cloud.xyz, method.volume))
    tracks = link(cloud, method=method)
    blended = blend(
        tracks, max_gap=method.max_gap, search_radius=method.search_radius, max_distance=method.max_distance
    )  # (4)
    return without_short(blended, min_points=method.min_points)  # (5)


def link(cloud: Cloud, *, method: KissTracking) -> Tracks:
    """All fragments, (1) to (3), numbered in the order in which they begin."""
    identity = np.full(len(cloud), -1)
    active = ActiveKissTrack(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, PAST, 3)))
    n_tracks = 0
    for f in range(cloud.n_frames):
        tell(f, cloud.n_frames)
        points, own = cloud[f], identity[cloud.rows(f)]
        predicted = extrapolate(active.past, active.known)
        off = np.linalg.norm(points - predicted[:, None], axis=-1)
        limit = np.where(active.known > 1, method.search_radius, method.max_distance)
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
