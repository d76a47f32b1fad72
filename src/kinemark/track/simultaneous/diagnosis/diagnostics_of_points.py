"""What became of points that are not like the others: left out, given with a great standard deviation, or on tracks
that likely continue earlier ones."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from ....data import Finding, make_finding
from ....data.array_types import Floats
from ....data.finding import red_if
from ....geometry.weighted_points import inside_volume
from ....numerics.runs import equal_runs
from ..following.room_scale import scaled
from ..joining.continuations import continuations
from ..simultaneous_method import Simultaneous
from ..tracker import TrackingResult

UNITS = {"m": 1000.0, "cm": 10.0, "in": 25.4}
"""mm in the units in which a volume may have been written by mistake; by definition."""
HELD = 0.5
"""Share of the points left out that the volume must hold in another unit for that to be said; chosen: most."""
KEPT_RED = 0.3
"""Share of the points that must lie in the volume: with fewer what is given is not what was seen; chosen, as for images
that are not used."""
HALL_MM = 30_000.0
"""As large as a volume may be in another unit for that to be said; chosen: a hall. One of metres that a subject
left is not too small for anybody."""


def diagnose_points(
    result: TrackingResult, method: Simultaneous, volume_margin: float | None, volume: Floats | None = None
) -> list[Finding]:
    """About points outside the volume (2, 3) mm, of which `volume_margin` mm were allowed, uncertain and fragments."""
    method = scaled(method, result.scale)
    found, cloud, outside = [], result.tracks.cloud, result.outside
    if len(outside) and volume_margin is not None:
        found.append(points_left_out(outside, len(cloud), volume_margin, volume))
    sd = np.sqrt(np.trace(cloud.cov, axis1=1, axis2=2))
    uncertain = np.flatnonzero(sd > method.uncertain_sd)
    if len(uncertain):
        frame = np.unique(cloud.frame[uncertain])
        cuts = equal_runs(frame - np.arange(len(frame)))
        spans = [(frame[a], frame[b - 1]) for a, b in pairwise(cuts)]
        found.append(
            make_finding(
                "positions_uncertain",
                frames=spans,
                points=len(uncertain),
                points_share=len(uncertain) / len(cloud),
                limit_mm=method.uncertain_sd,
            )
        )
    pairs = continuations(result.tracks)
    if len(pairs):
        earlier, later = ([f"*{track + 1}" for track in column] for column in pairs.T.tolist())
        found.append(make_finding("tracks_continue", tracks=len(pairs), earlier_list=earlier, later_list=later))
    return found


def points_left_out(
    outside: Floats, kept: int, margin: float, volume: Floats | None, markers: Iterable[str] = ()
) -> Finding:
    """About points (N, 3) mm outside a volume (2, 3) mm, beside which so many were kept; red where few were.

    `markers` are those of which nothing was kept.
    """
    return make_finding(
        "points_dropped_outside",
        severity=red_if(kept < KEPT_RED * (len(outside) + kept)),
        markers=markers,
        points=len(outside),
        points_share=len(outside) / (len(outside) + kept),
        margin_mm=margin,
        least_mm_list=outside.min(0),
        greatest_mm_list=outside.max(0),
        unit=None if volume is None or kept > len(outside) else _written_in(outside, volume),
    )


def _written_in(outside: Floats, volume: Floats) -> str | None:
    """The unit in which the volume would hold the most of the points that it leaves out, if that is most of them."""
    held = {
        unit: inside_volume(outside, volume * mm).mean()
        for unit, mm in UNITS.items()
        if np.ptp(volume, 0).max() * mm <= HALL_MM
    }
    return max((unit for unit, share in held.items() if share > HELD), key=held.__getitem__, default=None)
