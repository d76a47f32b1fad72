"""Where to put cameras: candidates in a room, what each would measure of a volume and a walking body, and the best of
them together."""

from .plan import CameraPlan, Planning, plan_cameras
from .prediction import BodyCoverage, Prediction, predict
from .room import Room, Sensor
from .subject import walks

__all__ = [
    "BodyCoverage",
    "CameraPlan",
    "Planning",
    "Prediction",
    "Room",
    "Sensor",
    "plan_cameras",
    "predict",
    "walks",
]
