"""What became of points that are not like the others: left out, given with a great standard deviation, or on tracks
that likely continue earlier ones."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ...data import Finding, make_finding
from ...numerics.runs import equal_runs
from .continuations import continuations
from .simultaneous_method import Simultaneous
from .tracker import TrackingResult


def diagnose_points(result: TrackingResult, method: Simultaneous, volume_margin: float | None) -> list[Finding]:
    """About points outside the volume, of which `volume_margin` mm were allowed, uncertain ones, and fragments."""
    found, cloud, outside = [], result.tracks.cloud, result.outside
    if len(outside) and volume_margin is not None:
        found.append(
            make_finding(
                "points_dropped_outside",
                points=len(outside),
                points_share=len(outside) / (len(outside) + len(cloud)),
                margin_mm=volume_margin,
                least_mm_list=outside.min(0),
                greatest_mm_list=outside.max(0),
            )
        )
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
