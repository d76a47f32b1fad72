"""The tracking of Swamidas (1997): Kalman prediction with regions of acceptance, and nearest distance beside it."""

from ...signal.kalman import KalmanState, initial_state, predict, update
from .constraints import Constraint
from .diagnostics import diagnose_model
from .distance_only import DistanceOnly, track_distance
from .predictions import ModelUse, SwamidasResult
from .swamidas_method import Swamidas
from .tracking import follow_points, track_swamidas

__all__ = [
    "Constraint",
    "DistanceOnly",
    "KalmanState",
    "ModelUse",
    "Swamidas",
    "SwamidasResult",
    "diagnose_model",
    "follow_points",
    "initial_state",
    "predict",
    "track_distance",
    "track_swamidas",
    "update",
]
