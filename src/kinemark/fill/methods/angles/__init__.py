"""The component angle model of Swamidas (1997): lengths and directions of segments over percent of a cycle."""

from ....signal.learn_angle_model import Learned, learn_model
from ....signal.segment_directions import component_angles, directions
from .connect import connect
from .cycle_events import cycle_events, intervals, model_events
from .feedback import KalmanAngles, fill_kalman_angles
from .limb_angles import LimbAngles, fill_limb_angles, fit_model, learned_of

__all__ = [
    "KalmanAngles",
    "Learned",
    "LimbAngles",
    "component_angles",
    "connect",
    "cycle_events",
    "directions",
    "fill_kalman_angles",
    "fill_limb_angles",
    "fit_model",
    "intervals",
    "learn_model",
    "learned_of",
    "model_events",
]
