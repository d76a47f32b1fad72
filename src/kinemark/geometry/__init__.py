"""Cameras, lenses, the DLT, epipolar lines, triangulation and rigid alignment."""

from .align import nearest_rotations, polar_rotations, rigid_align, rigid_poses
from .camera import (
    distort,
    normalised,
    parameter_jacobian,
    point_jacobian,
    project,
    project_all,
    rays,
    to_camera,
    undistort,
)
from .dlt import camera_from_dlt, cameras_from_dlt, decompose, fit_dlt, from_dlt, to_dlt
from .epipolar import epipolar_constants, epipolar_lines, fundamental, line_distance
from .origin import camera_about, joint_about, origin_near, parameters_about, rig_about
from .sphere_offset import sphere_offset
from .triangulate import Triangulated, refine, triangulate

__all__ = [
    "Triangulated",
    "camera_about",
    "camera_from_dlt",
    "cameras_from_dlt",
    "decompose",
    "distort",
    "epipolar_constants",
    "epipolar_lines",
    "fit_dlt",
    "from_dlt",
    "fundamental",
    "joint_about",
    "line_distance",
    "nearest_rotations",
    "normalised",
    "origin_near",
    "parameter_jacobian",
    "parameters_about",
    "point_jacobian",
    "polar_rotations",
    "project",
    "project_all",
    "rays",
    "refine",
    "rig_about",
    "rigid_align",
    "rigid_poses",
    "sphere_offset",
    "to_camera",
    "to_dlt",
    "triangulate",
    "undistort",
]
