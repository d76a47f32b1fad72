"""From matched images to points in space, each with its covariance: one file a method."""

from .camera_pairs import CameraPairs
from .least_squares import LeastSquares, image_errors
from .methods import reconstruct
from .stage import RECONSTRUCT

__all__ = [
    "RECONSTRUCT",
    "CameraPairs",
    "LeastSquares",
    "image_errors",
    "reconstruct",
]
