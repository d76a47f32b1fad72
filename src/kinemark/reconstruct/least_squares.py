"""Points from all their images by least squares (KISS 4.2), weighted by what each image is worth.

The linear solution of KISS eq. 10 is the first guess, and `geometry.refine` the answer: it weighs every image by its
own covariance and by what the calibration of its camera leaves open, and gives the covariance of the point.

Detections that come without a covariance (a BTS or CSV file) are given one from the data. With a common standard
deviation s in px of each image coordinate, a point seen by n cameras has 2n − 3 degrees of freedom, and

    Σ |off|² ~ s² χ²(2n − 3)                                             (1)

so s² is the median of Σ |off|² over the median of χ², a value that wrong matches hardly move.

A centroid can be worse than its covariance says: a part of the marker is hidden, or another marker touches it. Images
whose area says so are given more variance (`hidden`), and what remains is met by heavy tails: the error of an image,
d of its own standard deviations, is taken to follow Student's t with ν degrees of freedom in its plane, so that an
image whose d is large counts as one of covariance

    C (ν + d²) / (ν + 2)                                                 (2)

found by six reweightings. They are only made where an image is off by more than d² = ν + 2, and never narrow: images
that agree keep C.

The centroid of a sphere's image is not the projection of its centre. Where the diameter of the markers is given, what
`geometry.sphere_offset` says of the first solution is taken from every image, and the point solved again (3). Otherwise
that, and what any lens differs from its model, is taken to be a hundredth of a pixel (`model_sd`), below which no
covariance is believed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

from ..data import Cloud, Detections, Matches, Rig
from ..data.array_types import Floats
from ..data.method import Method, parameter
from ..geometry import Triangulated, refine, sphere_offset, triangulate, undistort
from .hidden import hidden_variance
from .stage import RECONSTRUCT

FALLBACK_SD = 0.2  # px; a usual centroid's, for recordings in which no point is seen by three cameras
REWEIGHTINGS = 6


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
    tails: float = parameter(
        4.0, unit="degrees of freedom", low=0,
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
    cloud = located(matches, detections, rig, method=method)
    return cloud.keep(wanted(cloud, rig, method=method))


def located(
    matches: Matches,
    detections: Detections,
    rig: Rig,
    *,
    guess: Floats | None = None,
    method: LeastSquares = LeastSquares(),
) -> Cloud:
    """One point for each match, in the same order, not finite where it has none.

    Args:
        guess: (P, 3) mm, where the points are thought to be, to within some noise of the images; None: the linear
            solution, which takes longer.
        matches, detections, rig, method: as for `reconstruct`.
    """
    seen: NDArray[np.bool_] = matches.view >= 0
    uv = np.where(seen[..., None], detections.uv[matches.view], np.nan)
    steps = 1 if guess is not None else 2
    guess = _linear(rig, uv) if guess is None else guess
    if method.marker_diameter is not None:
        uv = uv - _sphere_offsets(rig, guess, method.marker_diameter)  # (3)
        guess = guess if steps == 1 else _linear(rig, uv)
    area = np.where(seen, detections.area[matches.view], np.nan)
    cov = centroid_cov(detections.cov[matches.view], rig, guess, uv, method)
    variances = np.einsum("pcii->pci", cov)  # a view of both, in every image
    variances += (hidden_variance(rig, guess, area) + method.model_sd**2)[..., None]
    point = _robust(rig, guess, uv, cov, method.tails, steps)
    return Cloud(
        rate=detections.rate,
        start=np.searchsorted(matches.frame, np.arange(matches.n_frames + 1)),
        xyz=point.xyz,
        cov=point.cov,
        residual=np.sqrt(np.nansum(point.off**2, axis=(1, 2)) / seen.sum(1)),
        view=matches.view,
    )


def wanted(cloud: Cloud, rig: Rig, *, method: LeastSquares = LeastSquares()) -> NDArray[np.bool_]:
    """(P) whether a point of `located` is one, and in the control volume where the method asks for it."""
    return np.isfinite(cloud.xyz).all(1) & _inside(cloud.xyz, rig, method)


def _linear(rig: Rig, uv: Floats) -> Floats:
    """First solutions (P, 3) mm of images (P, C, 2) px."""
    return triangulate(np.stack([undistort(camera, uv[:, c]) for c, camera in enumerate(rig)], 1), rig.P)


def _sphere_offsets(rig: Rig, xyz: Floats, diameter: float) -> Floats:
    """(P, C, 2) px by which centroids are off; 0 where that is not defined, as the point is at or behind a camera."""
    return np.nan_to_num(np.stack([sphere_offset(camera, xyz, diameter=diameter) for camera in rig], 1))


def centroid_cov(cov: Floats, rig: Rig, guess: Floats, uv: Floats, method: LeastSquares) -> Floats:
    """Covariances (P, C, 2, 2) px² of the images, by (1) where they state none."""
    unknown = np.isnan(cov[..., 0, 0])
    if not (unknown & ~np.isnan(uv[..., 0])).any():
        return cov
    sd = method.centroid_sd or _centroid_sd(rig, guess, uv)
    return np.where(unknown[..., None, None], np.eye(2) * sd**2, cov)


def _centroid_sd(rig: Rig, guess: Floats, uv: Floats) -> float:
    """s of (1), px, from the points that three or more cameras see."""
    freedom: NDArray[np.int64] = 2 * (~np.isnan(uv[..., 0])).sum(1) - 3
    three = (freedom >= 3) & ~np.isnan(guess[:, 0])
    if not three.any():
        return FALLBACK_SD
    off = refine(rig, guess[three], uv[three], np.broadcast_to(np.eye(2), (*uv[three].shape, 2)), steps=2).off
    return float(np.sqrt(np.median(np.nansum(off**2, axis=(1, 2)) / (2 * gammaincinv(freedom[three] / 2, 0.5)))))


def _robust(rig: Rig, guess: Floats, uv: Floats, cov: Floats, tails: float, steps: int) -> Triangulated:
    """The points with heavy-tailed images by (2); those whose images agree are done after one pass."""
    point = refine(rig, guess, uv, cov, steps=steps, exact=steps > 1)
    wild = np.flatnonzero((_squared(point.off, cov) > 2 + tails).any(1)) if tails else np.zeros(0, np.int64)
    if not len(wild):
        return point
    xyz, own, off = point.xyz[wild], cov[wild], point.off[wild]
    for k in range(REWEIGHTINGS):
        widened = np.maximum((tails + _squared(off, own)) / (tails + 2), 1.0)  # (2)
        own_now = own * np.nan_to_num(widened, nan=1.0)[..., None, None]
        again = refine(rig, xyz, uv[wild], own_now, steps=1, exact=steps > 1 or k == REWEIGHTINGS - 1)
        xyz, off = again.xyz, again.off
    point.xyz[wild], point.cov[wild], point.off[wild] = again
    return point


def _squared(off: Floats, cov: Floats) -> Floats:
    """d² (P, C) of images off by (P, C, 2) px with covariances (P, C, 2, 2)."""
    (a, b), d = (cov[..., 0, 0], cov[..., 0, 1]), cov[..., 1, 1]
    x, y = off[..., 0], off[..., 1]
    return (d * x * x - 2 * b * x * y + a * y * y) / (a * d - b * b)


def _inside(xyz: Floats, rig: Rig, method: LeastSquares) -> NDArray[np.bool_]:
    """Whether points (P, 3) lie in the control volume; all do where the rig has none."""
    if not method.within_volume or np.isnan(rig.volume).any():
        return np.ones(len(xyz), bool)
    low, high = rig.volume
    return np.asarray(((xyz >= low - method.volume_margin) & (xyz <= high + method.volume_margin)).all(1))
