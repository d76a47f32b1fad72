"""Markers → joint angles: segment chains, angles with their covariance, poses, centres, velocities, cycles."""

from ..data.angles import Cycles, NamedAngle, named_angles, outside
from ..data.derivatives import MarkerDerivatives
from ..data.models import LABORATORY, Axis, Centre, Cluster, Joint, JointMotion, Model, Segment
from .centres import JointCentre, joint_centre, static_template
from .chain import joint_angles, joint_matrices, segment_axes
from .cycles import cycles, resampled, spans_of
from .derivatives import marker_derivatives
from .helical import HelicalAxis, helical_axes, helical_axis
from .knee import KneeMotion, knee_motion
from .marker_noise import estimated_sd, with_marker_sd
from .pose import ClusterTemplate, Pose, Template, body_pose, rotation_covariance
from .sequences import AngleMethod, InverseCosines, SignedAngles, inverse_cosines, principal, turned
from .smooth import Butterworth, WoltringSpline, residual_cutoff, smooth
from .stage import ANGLES, SMOOTH
from .velocity import angular_velocity

__all__ = [
    "ANGLES",
    "LABORATORY",
    "SMOOTH",
    "AngleMethod",
    "Axis",
    "Butterworth",
    "Centre",
    "Cluster",
    "ClusterTemplate",
    "Cycles",
    "HelicalAxis",
    "InverseCosines",
    "Joint",
    "JointCentre",
    "JointMotion",
    "KneeMotion",
    "MarkerDerivatives",
    "Model",
    "NamedAngle",
    "Pose",
    "Segment",
    "SignedAngles",
    "Template",
    "WoltringSpline",
    "angular_velocity",
    "body_pose",
    "cycles",
    "estimated_sd",
    "helical_axes",
    "helical_axis",
    "inverse_cosines",
    "joint_angles",
    "joint_centre",
    "joint_matrices",
    "knee_motion",
    "marker_derivatives",
    "named_angles",
    "outside",
    "principal",
    "resampled",
    "residual_cutoff",
    "rotation_covariance",
    "segment_axes",
    "smooth",
    "spans_of",
    "static_template",
    "turned",
    "with_marker_sd",
]
