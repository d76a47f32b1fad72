"""From markers at known places, or a wand waved about, to calibrated cameras, and how good they are.

control_points/   cameras from surveyed points: fit, refusals, errors left out, judgement
control_frame/    the hanging rods, recognised in an image
wand/, bundle/    a stick with markers, all cameras at once
quality/          how exactly a rig places markers, where, and without which camera
lens/             lenses from plane grids and chessboards
aspect            aspect ratio of the pixels
reference_marker  shifts of the images since the calibration
resection         least squares of one camera
l_frame           an L-frame on the floor, recognised and read over all frames
world_frame       turning and scaling a rig into the laboratory
world_check       cameras and surveyed points that do not fit the rig when the world is recorded
assign            which dot is which point of a known body, from a few that were picked by hand
"""

from .aspect import AspectRatio, aspect_ratio
from .assign import assign_points
from .bundle import Bundle, BundleFit, calibrate_points, calibrate_sticks
from .control_frame import calibrate_control_frame, identify_markers, recognise_control_frame
from .control_points import (
    ControlFit,
    ControlPoints,
    Dlt,
    Judgement,
    calibrate_control_points,
    control_point_quality,
    judge_control_points,
)
from .lens.chessboard import find_corners
from .lens.dot_grid import order_grid, part_of_grid
from .lens.linearisation import GridView, LensFit, Linearisation, linearise, straightness
from .quality import map_volume, predicted_covariance
from .reference_marker import MarkShift, corrected, find_marks, mark_shift, reference_shift
from .stage import CALIBRATE
from .wand import Wand, WandLengths, calibrate_wand, wand_lengths, wand_points

__all__ = [
    "CALIBRATE",
    "AspectRatio",
    "Bundle",
    "BundleFit",
    "ControlFit",
    "ControlPoints",
    "Dlt",
    "GridView",
    "Judgement",
    "LensFit",
    "Linearisation",
    "MarkShift",
    "Wand",
    "WandLengths",
    "aspect_ratio",
    "assign_points",
    "calibrate_control_frame",
    "calibrate_control_points",
    "calibrate_points",
    "calibrate_sticks",
    "calibrate_wand",
    "control_point_quality",
    "corrected",
    "find_corners",
    "find_marks",
    "identify_markers",
    "judge_control_points",
    "linearise",
    "map_volume",
    "mark_shift",
    "order_grid",
    "part_of_grid",
    "predicted_covariance",
    "recognise_control_frame",
    "reference_shift",
    "straightness",
    "wand_lengths",
    "wand_points",
]
