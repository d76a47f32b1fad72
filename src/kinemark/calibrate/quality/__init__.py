"""How good a calibration is, whatever way it was made.

`predicted_covariance` predicts the covariance of a marker's position, `volume` maps it over the control volume, with
all cameras and without each; `image_coverage` says where in its image a camera was calibrated; `wand` judges by poses
that took no part; `world_pose` says how well the room is known; `change` compares with a former calibration.
`calibration_evidence` holds all that a verdict needs.
"""

from .calibration_evidence import Check, Evidence, centroid_deviation
from .change import Change, compare
from .image_coverage import ImageCoverage, image_coverage
from .predicted_covariance import (
    apart_from_frame,
    covariance_from,
    joint_of,
    predicted_covariance,
    views,
    visible,
)
from .volume import VolumeMap, map_volume, points_of, view_volume, volume_grid
from .wand import judge_poses
from .world_pose import WorldPose, world_pose

__all__ = [
    "Change",
    "Check",
    "Evidence",
    "ImageCoverage",
    "VolumeMap",
    "WorldPose",
    "apart_from_frame",
    "centroid_deviation",
    "compare",
    "covariance_from",
    "image_coverage",
    "joint_of",
    "judge_poses",
    "map_volume",
    "points_of",
    "predicted_covariance",
    "view_volume",
    "views",
    "visible",
    "volume_grid",
    "world_pose",
]
