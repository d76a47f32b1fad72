"""From matched images to points in space, each with its covariance."""

from .least_squares import LeastSquares, reconstruct

__all__ = ["LeastSquares", "reconstruct"]
