"""Reconstruction by whichever method."""

from __future__ import annotations

from collections.abc import Callable

from ..data import Cloud, Detections, Matches, Rig
from .camera_pairs import CameraPairs, reconstruct_pairs
from .least_squares import LeastSquares, reconstruct_least_squares

ReconstructMethod = LeastSquares | CameraPairs

RECONSTRUCTORS: dict[type, Callable[..., Cloud]] = {
    LeastSquares: reconstruct_least_squares,
    CameraPairs: reconstruct_pairs,
}
"""What does each method: called with matches, detections, rig, and method=…"""

DEFAULT = LeastSquares()


def reconstruct(matches: Matches, detections: Detections, rig: Rig, *, method: ReconstructMethod = DEFAULT) -> Cloud:
    """The points of all matches, in the order of their frames; residuals in px, covariances in mm²."""
    return RECONSTRUCTORS[type(method)](matches, detections, rig, method=method)
