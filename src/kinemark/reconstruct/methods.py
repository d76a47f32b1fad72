"""Reconstruction by whichever method."""

from __future__ import annotations

from ..data import Cloud, Detections, Matches, Rig
from ..data.method import Method
from .stage import RECONSTRUCT


def reconstruct(matches: Matches, detections: Detections, rig: Rig, *, method: Method | None = None) -> Cloud:
    """The points of all matches, in the order of their frames; residuals in px, covariances in mm².

    Args:
        matches: which detections are one marker.
        detections: of all cameras.
        rig: the cameras.
        method: one of `RECONSTRUCT`; `LeastSquares()` where None.

    Raises:
        ValueError: the method is none of `RECONSTRUCT`.
    """
    method = method or RECONSTRUCT.make()
    return RECONSTRUCT.function(method)(matches, detections, rig, method=method)
