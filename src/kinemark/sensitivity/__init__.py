"""How errors travel: from centroids to the calibration, to points, joint angles and means over cycles.

`um2as` is the experiment of the UM²AS thesis (chapter 4), a million samples at a time (`sampling`, `dlt`); `chain` the
same to first order for any rig and any kinematics; `evidence` what a recording's own residuals say, and `ranking` what
limits its accuracy.
"""

from .observed_errors import Shown, shown
from .parameter_bound import ParameterBound, first_order_bound, parameter_bound
from .propagation import (
    Kinematics,
    Spread,
    angle_jacobian,
    angle_spread,
    cycle_weights,
    linear_points,
    mean_spread,
    placed_points,
    rig_points,
)
from .ranked_sources import ErrorBudget, ErrorSource, LostCamera, Ranking, rank, typical
from .sample_frames import SampledFrames, gather, gather_named
from .sampling import Sampled, Sampling, climb, sample
from .segment_directions import Rigid, segment_jacobian, segments
from .um2as_experiment import (
    Changed,
    LinearisedErrors,
    Moved,
    calibration_experiment,
    laboratory,
    marker,
    marker_experiment,
)

__all__ = [
    "Changed",
    "ErrorBudget",
    "ErrorSource",
    "Kinematics",
    "LinearisedErrors",
    "LostCamera",
    "Moved",
    "ParameterBound",
    "Ranking",
    "Rigid",
    "Sampled",
    "SampledFrames",
    "Sampling",
    "Shown",
    "Spread",
    "angle_jacobian",
    "angle_spread",
    "calibration_experiment",
    "climb",
    "cycle_weights",
    "first_order_bound",
    "gather",
    "gather_named",
    "laboratory",
    "linear_points",
    "marker",
    "marker_experiment",
    "mean_spread",
    "parameter_bound",
    "placed_points",
    "rank",
    "rig_points",
    "sample",
    "segment_jacobian",
    "segments",
    "shown",
    "typical",
]
