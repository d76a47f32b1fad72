"""How errors travel: from centroids to the calibration, to points, joint angles and means over cycles.

`propagation` is to first order, for any rig and any kinematics; `observed_errors` what a recording's own residuals say,
and `ranked_sources` what limits its accuracy. The experiment of the UM²AS thesis is `studies/um2as_experiment.py`.
"""

from .observed_errors import Shown, shown
from .propagation import (
    Kinematics,
    Spread,
    angle_jacobian,
    angle_spread,
    cycle_weights,
    mean_spread,
    placed_points,
    rig_points,
)
from .ranked_sources import ErrorBudget, ErrorSource, LostCamera, Ranking, rank, typical
from .sample_frames import SampledFrames, gather, gather_named
from .segment_directions import Rigid, segment_jacobian, segments

__all__ = [
    "ErrorBudget",
    "ErrorSource",
    "Kinematics",
    "LostCamera",
    "Ranking",
    "Rigid",
    "SampledFrames",
    "Shown",
    "Spread",
    "angle_jacobian",
    "angle_spread",
    "cycle_weights",
    "gather",
    "gather_named",
    "mean_spread",
    "placed_points",
    "rank",
    "rig_points",
    "segment_jacobian",
    "segments",
    "shown",
    "typical",
]
