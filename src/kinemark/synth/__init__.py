"""The virtual laboratory: cameras, moving subjects, their images, and the exact truth beside them."""

from .arm import arm
from .camera_placement import VOLUME, focal_pixels, look_at, place_camera, ring
from .extra_markers import combined_subjects, with_markers
from .gait import walking
from .gait_body import WalkingBody
from .gait_laboratory import GaitLaboratory, gait_laboratory
from .laboratory import rods_toml, write_calibration, write_session
from .motions import circle_over_cylinder, elbow_flexion, tilted_rectangle
from .observe import ObservedImages, Sight, observe, truth
from .optics import Optics
from .render import film, interlace, render
from .sphere_image import Ellipse, sphere_ellipse
from .subjects import Capsules, Subject, from_trajectories, stationary
from .targets import calibration_box, control_frame, dot_grid, rods_subject, thrown_ball, wand

__all__ = [
    "VOLUME",
    "Capsules",
    "Ellipse",
    "GaitLaboratory",
    "ObservedImages",
    "Optics",
    "Sight",
    "Subject",
    "WalkingBody",
    "arm",
    "calibration_box",
    "circle_over_cylinder",
    "combined_subjects",
    "control_frame",
    "dot_grid",
    "elbow_flexion",
    "film",
    "focal_pixels",
    "from_trajectories",
    "gait_laboratory",
    "interlace",
    "look_at",
    "observe",
    "place_camera",
    "render",
    "ring",
    "rods_subject",
    "rods_toml",
    "sphere_ellipse",
    "stationary",
    "thrown_ball",
    "tilted_rectangle",
    "truth",
    "walking",
    "wand",
    "with_markers",
    "write_calibration",
    "write_session",
]
