"""Points from all their images by least squares (KISS 4.2), weighted by what each image is worth.

The linear solution of KISS eq. 10 is the first guess; `geometry.weighted_points` has the equations (1) to (3), which
the simultaneous tracker shares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..data import Cloud, Detections, Matches, Rig
from ..data.arrays import check_positive
from ..geometry.weighted_points import ImageErrors, usable_points, weighted_points


@dataclass(frozen=True, slots=True)
class LeastSquares:
    """Parameters of the method.

    Attributes:
        centroid_sd: standard deviation of a centroid that states none, px; None: estimated from the data by (1).
        model_sd: what the camera model leaves out, px; added to every image.
        tails: ν of (2); small means that wild images are expected; 0 for plain least squares.
        within_volume: drop points outside the rig's control volume, where it has one.
        volume_margin: how far outside a point may lie, mm.
        marker_diameter: of the marker spheres, mm, for (3); None: not corrected.
    """

    centroid_sd: float | None = None
    model_sd: float = 0.01
    tails: float = 4.0
    within_volume: bool = True
    volume_margin: float = 100.0
    marker_diameter: float | None = None

    def __post_init__(self) -> None:
        check_positive(centroid_sd=self.centroid_sd, marker_diameter=self.marker_diameter)
        for name in ("model_sd", "tails", "volume_margin"):
            if not 0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} is {getattr(self, name)}, wanted 0 or more")


def reconstruct_least_squares(matches: Matches, detections: Detections, rig: Rig, *, method: LeastSquares) -> Cloud:
    """The points of all matches, in the order of their frames; residuals in px, covariances in mm²."""
    cloud = weighted_points(matches, detections, rig, errors=image_errors(method))
    return cloud.keep(usable_points(cloud, rig, margin=method.volume_margin if method.within_volume else None))


def image_errors(method: LeastSquares) -> ImageErrors:
    """What the method thinks of the errors of images."""
    return ImageErrors(method.centroid_sd, method.model_sd, method.tails, method.marker_diameter)
