"""A point in space from all its images, weighted by their variances, with its covariance.

`triangulate` gives a first guess, and `refine` the answer: it weighs every image by its own covariance and by what the
calibration of its camera leaves open, and gives the covariance of the point.

Detections that come without a covariance (a BTS or CSV file) are given one from the data. With a common standard
deviation s in px of each image coordinate, a point seen by n cameras has 2n − 3 degrees of freedom, and

    Σ |off|² ~ s² χ²(2n − 3)                                             (1)

so s² is the median of Σ |off|² over the median of χ², a value that wrong matches hardly move.

A centroid can be worse than its covariance says: a part of the marker is hidden, or another marker touches it. Images
whose area says so are given more variance (`hidden_images`), and what remains is met by heavy-tailed errors: the error
of an image, d of its own standard deviations, is taken to follow Student's t with ν degrees of freedom in its plane, so
that an image whose d is large counts as one of covariance

    C (ν + d²) / (ν + 2)                                                 (2)

(`numerics.robust`), found by six reweightings. They are only made where an image is off by more than d² = ν + 2, and
never narrow: images that agree keep C.

The centroid of a sphere's image is not the projection of its centre. Where the diameter of the markers is given, what
`sphere_offset` says of the first solution is taken from every image, and the point solved again (3). Otherwise that,
and what any lens differs from its model, is taken to be a hundredth of a pixel (`model_sd`), below which no covariance
is believed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ..data import Cloud, Detections, Matches, Rig
from ..data.array_types import Bools, Floats, Ints
from ..numerics.robust import student_widening
from .camera import undistort_all
from .hidden_images import hidden_variance
from .sphere_offset import sphere_offset
from .triangulate import Triangulated, refine, triangulate

FALLBACK_SD = 0.2
"""px; a usual centroid's, for recordings in which no point is seen by three cameras; chosen, not tuned."""

REWEIGHTINGS = 6
"""Of (2), a number of rounds; chosen, not tuned: d then hardly changes any more."""


@dataclass(frozen=True, slots=True)
class ImageErrors:
    """What is thought of the errors of images.

    Attributes:
        centroid_sd: standard deviation of a centroid that states none, px; None: estimated from the data by (1).
        model_sd: what the camera model leaves out, px; added to every image.
        degrees_of_freedom: ν of (2); small means that wrong images are expected; 0 for plain least squares.
        marker_diameter: of the marker spheres, mm, for (3); None: not corrected.
    """

    centroid_sd: float | None = None
    model_sd: float = 0.01
    degrees_of_freedom: float = 4.0
    marker_diameter: float | None = None


DEFAULT_ERRORS = ImageErrors()


def weighted_points(
    matches: Matches,
    detections: Detections,
    rig: Rig,
    *,
    guess: Floats | None = None,
    uv: Floats | None = None,
    cov: Floats | None = None,
    errors: ImageErrors = DEFAULT_ERRORS,
) -> Cloud:
    """One point for each match, in the same order, not finite where it has none.

    Residuals are in px, covariances in mm².

    Args:
        matches: which images are one point.
        detections: the images.
        rig: the cameras.
        guess: (P, 3) mm, where the points are thought to be, to within some noise of the images; None: the linear
            solution, which takes longer.
        uv: (P, C, 2) px, of the image that each camera has of each point; None: as the detections have them.
        cov: (P, C, 2, 2) px², of the image that each camera has of each point; None: as the detections state.
        errors: of the images.
    """
    seen: Bools = matches.detection >= 0
    uv = np.where(seen[..., None], detections.uv[matches.detection] if uv is None else uv, np.nan)
    steps = 1 if guess is not None else 2
    guess = _linear(rig, uv) if guess is None else guess
    if errors.marker_diameter is not None:
        uv = uv - _sphere_offsets(rig, guess, errors.marker_diameter)  # (3)
        guess = guess if steps == 1 else _linear(rig, uv)
    area = np.where(seen, detections.area[matches.detection], np.nan)
    cov = centroid_cov(detections.cov[matches.detection] if cov is None else cov, rig, guess, uv, errors.centroid_sd)
    variances = np.einsum("pcii->pci", cov)  # a view of both, in every image
    variances += (hidden_variance(rig, guess, area) + errors.model_sd**2)[..., None]
    point = _robust(rig, guess, uv, cov, errors.degrees_of_freedom, steps)
    return Cloud(
        rate=detections.rate,
        start=np.searchsorted(matches.frame, np.arange(matches.n_frames + 1)),
        xyz=point.xyz,
        cov=point.cov,
        residual=np.sqrt(np.nansum(point.residual**2, axis=(1, 2)) / seen.sum(1)),
        detection=matches.detection,
    )


def _linear(rig: Rig, uv: Floats) -> Floats:
    """First solutions (P, 3) mm of images (P, C, 2) px."""
    return triangulate(undistort_all(rig, uv), rig.P)


def _sphere_offsets(rig: Rig, xyz: Floats, diameter: float) -> Floats:
    """(P, C, 2) px by which centroids are off; 0 where that is not defined, as the point is at or behind a camera."""
    return np.nan_to_num(np.stack([sphere_offset(camera, xyz, diameter=diameter) for camera in rig], 1))


def centroid_cov(cov: Floats, rig: Rig, guess: Floats, uv: Floats, stated: float | None) -> Floats:
    """Covariances (P, C, 2, 2) px² of the images, where they state none `stated` px, or by (1)."""
    unknown = np.isnan(cov[..., 0, 0])
    if not (unknown & ~np.isnan(uv[..., 0])).any():
        return cov
    sd = stated or _centroid_sd(rig, guess, uv)
    return np.where(unknown[..., None, None], np.eye(2) * sd**2, cov)


def _centroid_sd(rig: Rig, guess: Floats, uv: Floats) -> float:
    """s of (1), px, from the points that three or more cameras see."""
    freedom: Ints = 2 * (~np.isnan(uv[..., 0])).sum(1) - 3
    three = (freedom >= 3) & ~np.isnan(guess[:, 0])
    if not three.any():
        return FALLBACK_SD
    residual = refine(rig, guess[three], uv[three], np.broadcast_to(np.eye(2), (*uv[three].shape, 2)), steps=2).residual
    return float(
        np.sqrt(
            np.median(np.nansum(residual**2, axis=(1, 2)) / (2 * scipy.special.gammaincinv(freedom[three] / 2, 0.5)))
        )
    )


def _robust(rig: Rig, guess: Floats, uv: Floats, cov: Floats, degrees_of_freedom: float, steps: int) -> Triangulated:
    """The points with heavy-tailed images by (2); those whose images agree are done after one pass."""
    point = refine(rig, guess, uv, cov, steps=steps, exact=steps > 1)
    outlying = (
        np.flatnonzero((_squared(point.residual, cov) > 2 + degrees_of_freedom).any(1))
        if degrees_of_freedom
        else np.zeros(0, np.int64)
    )
    if not len(outlying):
        return point
    xyz, own, residual = point.xyz[outlying], cov[outlying], point.residual[outlying]
    for k in range(REWEIGHTINGS):
        widened = np.maximum(student_widening(_squared(residual, own), degrees_of_freedom), 1.0)  # (2)
        own_now = own * np.nan_to_num(widened, nan=1.0)[..., None, None]
        again = refine(rig, xyz, uv[outlying], own_now, steps=1, exact=steps > 1 or k == REWEIGHTINGS - 1)
        xyz, residual = again.xyz, again.residual
    point.xyz[outlying], point.cov[outlying], point.residual[outlying] = again
    return point


def _squared(residual: Floats, cov: Floats) -> Floats:
    """d² (P, C) of images off by (P, C, 2) px with covariances (P, C, 2, 2)."""
    (a, b), d = (cov[..., 0, 0], cov[..., 0, 1]), cov[..., 1, 1]
    x, y = residual[..., 0], residual[..., 1]
    return (d * x * x - 2 * b * x * y + a * y * y) / (a * d - b * b)


def inside_volume(xyz: Floats, volume: ArrayLike, *, margin: float = 0.0) -> Bools:
    """(…) whether points (…, 3) mm lie in a volume (2, 3) mm, or within `margin` mm of it along each axis."""
    low, high = np.asarray(volume, np.float64)
    return np.asarray(((xyz >= low - margin) & (xyz <= high + margin)).all(-1))


def usable_points(cloud: Cloud, rig: Rig, *, margin: float | None = 100.0) -> Bools:
    """(P) whether a point of `weighted_points` is one, and within `margin` mm of the rig's volume, where it has one.

    `margin` None means that points are used wherever they are.
    """
    known = np.asarray(np.isfinite(cloud.xyz).all(1))
    if margin is None or np.isnan(rig.volume).any():
        return known
    return np.asarray(known & inside_volume(cloud.xyz, rig.volume, margin=margin))
