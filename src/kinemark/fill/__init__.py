"""Missing samples: fillers, which of them to trust, and how far off they may be."""

from .edges import GapEdges, Trimmed, trim_edges
from .fill import fill
from .fill_recording import Filling, fill_recording
from .filled_gap import Filled, FilledGap
from .judge.auto import Auto
from .marker_array import Gap, MarkerArray, Prediction, find_gaps
from .methods.along_line import AlongLine
from .methods.angles import KalmanAngles, LimbAngles, cycle_events, fit_model, model_events
from .methods.body import Body
from .methods.circle import Circle
from .methods.cyclic import Cyclic
from .methods.kalman_predictor import Kalman
from .methods.local_regression import LocalRegression
from .methods.low_rank_kalman import LowRankKalman
from .methods.pattern import Pattern
from .methods.pca import PCA
from .methods.polynomials import Cubic, Linear
from .methods.quintic import Quintic
from .methods.relational import Relational
from .methods.rigid_body import RigidBody
from .methods.stage import FILL
from .piece_matches import PieceMatch, piece_matches
from .prepared import GapFill, PreparedFill, prepare
from .rays import Rays
from .static import FromStatic, PlacedMarker, place_absent
from .static_shape import StaticShape
from .usual_limit import LIMIT, usual_limit

__all__ = [
    "FILL",
    "LIMIT",
    "PCA",
    "AlongLine",
    "Auto",
    "Body",
    "Circle",
    "Cubic",
    "Cyclic",
    "Filled",
    "FilledGap",
    "Filling",
    "FromStatic",
    "Gap",
    "GapEdges",
    "GapFill",
    "Kalman",
    "KalmanAngles",
    "LimbAngles",
    "Linear",
    "LocalRegression",
    "LowRankKalman",
    "MarkerArray",
    "Pattern",
    "PieceMatch",
    "PlacedMarker",
    "Prediction",
    "PreparedFill",
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
    "piece_matches",
    "place_absent",
    "prepare",
    "trim_edges",
    "usual_limit",
]
