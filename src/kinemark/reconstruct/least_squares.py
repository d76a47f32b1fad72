"""Points from all their images by least squares (KISS 4.2), weighted by the variance of each image.

The linear solution of KISS eq. 10 is the first guess; `geometry.weighted_points` has the equations (1) to (3), which
the simultaneous tracker shares.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..data import Cloud, Detections, Matches, Rig
from ..data.method import Method, parameter
from ..geometry.weighted_points import ImageErrors, usable_points, weighted_points
from .stage import RECONSTRUCT


@dataclass(frozen=True, slots=True)
class LeastSquares(Method):
    """Each point from all its images by weighted least squares of their residuals, with heavy tails."""

    centroid_sd: float | None = parameter(
        None, unit="px", above=0,
        meaning="standard deviation of a centroid that states none; None: estimated from the data by (1)",
    )  # fmt: skip
    model_sd: float = parameter(
        0.01, unit="px", low=0,
        meaning="what the camera model leaves out, a standard deviation that is added to every image's",
    )  # fmt: skip
    degrees_of_freedom: float = parameter(
        4.0, former="tails", unit="degrees of freedom", low=0,
        meaning="ν of (2), of Student's t; small means that outliers are expected; 0 for plain least squares",
    )  # fmt: skip
    within_volume: bool = parameter(True, meaning="drop points outside the rig's control volume, where it has one")
    volume_margin: float = parameter(100.0, unit="mm", low=0, meaning="how far outside the volume a point may lie")
    marker_diameter: float | None = parameter(
        None, unit="mm", above=0,
        meaning="diameter of the marker spheres, for (3); None: not corrected for perspective",
    )  # fmt: skip


@RECONSTRUCT.method("least_squares", LeastSquares, source="Shafiq, Tümer and Güler 2001, 4.2")
def reconstruct_least_squares(matches: Matches, detections: Detections, rig: Rig, *, method: LeastSquares) -> Cloud:
    """The points of all matches, in the order of their frames; residuals in px, covariances in mm²."""
    cloud = weighted_points(matches, detections, rig, errors=image_errors(method))
    return cloud.keep(usable_points(cloud, rig, margin=method.volume_margin if method.within_volume else None))


def image_errors(method: LeastSquares) -> ImageErrors:
    """The error model of images that the method states."""
    return ImageErrors(method.centroid_sd, method.model_sd, method.degrees_of_freedom, method.marker_diameter)
