"""From matched images to points in space, each with its covariance: one file a method."""

from .camera_pairs import CameraPairs
from .least_squares import LeastSquares, image_errors
from .methods import RECONSTRUCTORS, ReconstructMethod, reconstruct

__all__ = [
    "RECONSTRUCTORS",
    "CameraPairs",
    "LeastSquares",
    "ReconstructMethod",
    "image_errors",
    "reconstruct",
]
