"""Missing samples: fillers, which of them to trust, and how far off they may be."""

from .angles import KalmanAngles, LimbAngles, cycle_events, fit_model, model_events
from .auto import Auto
from .body import Body
from .cyclic import Cyclic
from .edges import Edges, Trimmed, trim_edges
from .fill import LIMIT, METHODS, Filled, FilledGap, fill
from .kalman import Kalman
from .local_regression import LocalRegression
from .low_rank_kalman import LowRankKalman
from .motion import Gap, Motion, Prediction, find_gaps
from .pattern import Pattern
from .pca import PCA
from .polynomials import Cubic, Linear
from .rays import Rays
from .recording import Filling, fill_recording
from .relational import Relational
from .rigid_body import RigidBody
from .static import FromStatic, Placed, place_absent
from .static_shape import StaticShape
from .woltring import Quintic

__all__ = [
    "LIMIT",
    "METHODS",
    "PCA",
    "Auto",
    "Body",
    "Cubic",
    "Cyclic",
    "Edges",
    "Filled",
    "FilledGap",
    "Filling",
    "FromStatic",
    "Gap",
    "Kalman",
    "KalmanAngles",
    "LimbAngles",
    "Linear",
    "LocalRegression",
    "LowRankKalman",
    "Motion",
    "Pattern",
    "Placed",
    "Prediction",
    "Quintic",
    "Rays",
    "Relational",
    "RigidBody",
    "StaticShape",
    "Trimmed",
    "cycle_events",
    "fill",
    "fill_recording",
    "find_gaps",
    "fit_model",
    "model_events",
    "place_absent",
    "trim_edges",
]
