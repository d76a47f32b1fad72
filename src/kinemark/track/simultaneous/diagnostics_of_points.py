"""What became of points that are not like the others: left out, or given with a great standard deviation."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ...data import Finding, make_finding
from ...numerics.runs import equal_runs
from .simultaneous_method import Simultaneous
from .tracker import TrackingResult


def diagnose_points(result: TrackingResult, method: Simultaneous, volume_margin: float | None) -> list[Finding]:
    """About points outside the volume, of which `volume_margin` mm were allowed, and about uncertain ones."""
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
    return found
