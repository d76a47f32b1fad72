"""The virtual laboratory: cameras, moving subjects, their images, and the exact truth beside them."""

from .arm import arm
from .camera_placement import VOLUME, focal_pixels, look_at, place_camera, ring
from .dressed import dressed, together
from .gait import walking
from .laboratory import rods_toml, write_calibration, write_session
from .motions import circle_over_cylinder, elbow_flexion, tilted_rectangle
from .observe import ObservedImages, Sight, observe, truth
from .optics import Optics
from .render import film, interlace, render
from .sphere_image import Ellipse, sphere_ellipse
from .subjects import Capsules, Subject, from_trajectories, still
from .targets import calibration_box, control_frame, dot_grid, hung, thrown_ball, wand

__all__ = [
    "VOLUME",
    "Capsules",
    "Ellipse",
    "ObservedImages",
    "Optics",
    "Sight",
    "Subject",
    "arm",
    "calibration_box",
    "circle_over_cylinder",
    "control_frame",
    "dot_grid",
    "dressed",
    "elbow_flexion",
    "film",
    "focal_pixels",
    "from_trajectories",
    "hung",
    "interlace",
    "look_at",
    "observe",
    "place_camera",
    "render",
    "ring",
    "rods_toml",
    "sphere_ellipse",
    "still",
    "thrown_ball",
    "tilted_rectangle",
    "together",
    "truth",
    "walking",
    "wand",
    "write_calibration",
    "write_session",
]
