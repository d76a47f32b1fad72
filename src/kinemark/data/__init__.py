"""What passes between stages: frozen records of arrays, shape and unit beside every field.

C cameras, F frames, M markers, D detections, P points. Arrays in a record are read-only.
"""

from .analog import Analog, ForcePlate
from .angle_model import AngleModel
from .angles import Angles
from .arrays import same
from .cloud import Cloud, Tracks
from .detections import Detections, Validity
from .errors import KinemarkError
from .events import Events
from .fills import Fills
from .finding import SEVERITIES, Finding, FindingKind, Grade, Severity
from .finding_kinds import KINDS, make_finding
from .marker_set import MarkerSet
from .matches import Matches
from .poses import Poses
from .rig import PARAMETERS, Camera, Rig
from .rods import Rods
from .signals import Signal, Signals
from .trajectories import MarkerTrajectory, Origin, Trajectories
from .trial import Identity, Step, Trial

__all__ = [
    "KINDS",
    "PARAMETERS",
    "SEVERITIES",
    "Analog",
    "AngleModel",
    "Angles",
    "Camera",
    "Cloud",
    "Detections",
    "Events",
    "Fills",
    "Finding",
    "FindingKind",
    "ForcePlate",
    "Grade",
    "Identity",
    "KinemarkError",
    "MarkerSet",
    "MarkerTrajectory",
    "Matches",
    "Origin",
    "Poses",
    "Rig",
    "Rods",
    "Severity",
    "Signal",
    "Signals",
    "Step",
    "Tracks",
    "Trajectories",
    "Trial",
    "Validity",
    "make_finding",
    "same",
]
