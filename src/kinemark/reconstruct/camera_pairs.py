"""Points from pairs of cameras that agree (UM²AS: University of Manitoba Motion Analysis System, thesis, 2.4).

UM²AS is "three two-camera systems": every pair of cameras m, n that sees a marker gives a solution of its own, the
linear one of `geometry.triangulate` with these two alone (UM²AS eq. 2.5),

    X_mn = (BᵀB)⁻¹ Bᵀ D                                                  (1)

A marker that one camera or none sees has no position (UM²AS eq. 2.6); with two cameras X_mn is the position (2) (UM²AS
eq. 2.7). With three there are three solutions. One of them is left out if it is at least twice as far from both others
as they are from each other (figure 2.9), and the mean of what is left is the position (3), UM²AS eq. 2.8.

**More cameras.** With n cameras there are n(n − 1)/2 solutions. One bad camera spoils those n − 1 in which it takes
part, and the (n − 1)(n − 2)/2 others stay together. So with

    k = max(1, (n − 1)(n − 2)/2 − 1),     m_p = distance of solution p from the k-th nearest other one        (4)

solution p is left out if

    m_p ≥ `outlier_ratio` · min_q m_q,   m_p > min_q m_q                        (5)

For n = 3 is k = 1, and (5) is the rule of the paper: if d₃ is the least of three distances, the two solutions that it
joins have m = d₃, and the third has the smaller of its two distances, which (5) asks to be twice d₃ or more.

**What the rule can do.** It finds a pair whose rays are nearly parallel, as its solution is far from all others. It
cannot find a bad camera of three: that camera is in two of the three solutions, and where these two happen to be
moved alike, it is the third one, the right one, that is left out. From four cameras on, one bad camera is found unless
its solutions happen to be moved alike and are as many as the others, as three of six are.

**Covariance.** Written with the depth w of the point in a camera, the row of B for an image at the ideal pixel û is
w ∂û/∂X, so that errors e of the images move the solutions and their mean by, to first order,

    X_mn − X = N_mn⁻¹ Σ_c w_c² J_cᵀ e_c,     N_mn = Σ_c w_c² J_cᵀ J_c,   J = ∂û/∂X,   c = m, n                (6)
    H_c = the mean over the solutions kept of N⁻¹ w_c² J_cᵀ A_c,         C_X = Σ_c H_c C_c H_cᵀ               (7)

with A = ∂û/∂u of the lens (from ∂û/∂X = A ∂u/∂X) and C_c the covariance of the centroid and of what the calibration
of the camera leaves open. Solutions that share a camera share its error; (7) counts that. The images of the n cameras
that have a part in the mean are off by Σ d² in their own standard deviations, which follows χ² with 2n − 3 degrees of
freedom. Where it is beyond what noise makes of one point in twenty, q, something is wrong, and C_X is widened to

    C_X max(1, Σ d² / q)                                                 (8)

The paper states no uncertainty; (6) to (8) are ours and change no position.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import scipy

from ..data import Cloud, Detections, Matches, Rig
from ..data.array_types import Bools, Floats, Ints
from ..data.method import ONE, Method, parameter
from ..geometry import parameter_jacobian, point_jacobian, project, to_camera, triangulate
from ..geometry.camera import undistort_all
from ..geometry.hidden_images import hidden_variance
from ..geometry.weighted_points import centroid_cov, usable_points
from ..numerics.small_matrices import inverse3
from .stage import RECONSTRUCT

BLOCK = 100_000  # distances between solutions worked on at once, so that they stay in the cache; chosen


@dataclass(frozen=True, slots=True)
class CameraPairs(Method):
    """Each point as the mean of the solutions of camera pairs that agree: the method of UM²AS."""

    outlier_ratio: float = parameter(
        2.0, former="excess", unit=ONE, low=1,
        meaning="a solution this many times as far from the others as they are from each other, or farther, is left "
        "out (5); UM²AS: 2",
    )  # fmt: skip
    centroid_sd: float | None = parameter(
        None, unit="px", above=0,
        meaning="standard deviation of a centroid that states none; None: estimated from the data",
    )  # fmt: skip
    model_sd: float = parameter(
        0.01, unit="px", low=0,
        meaning="what the camera model leaves out, a standard deviation that is added to every image's",
    )  # fmt: skip
    within_volume: bool = parameter(True, meaning="drop points outside the rig's control volume, where it has one")
    volume_margin: float = parameter(100.0, unit="mm", low=0, meaning="how far outside the volume a point may lie")


@RECONSTRUCT.method("camera_pairs", CameraPairs, source="UM²AS, 2.4")
def reconstruct_pairs(matches: Matches, detections: Detections, rig: Rig, *, method: CameraPairs) -> Cloud:
    """The points of all matches, in the order of their frames; called through `reconstruct`."""
    seen: Bools = matches.detection >= 0
    uv = np.where(seen[..., None], detections.uv[matches.detection], np.nan)
    each = solutions(rig, uv)
    kept = agreeing(each, seen.sum(1), outlier_ratio=method.outlier_ratio)
    xyz = _mean(each, kept)
    area = np.where(seen, detections.area[matches.detection], np.nan)
    cov = centroid_cov(detections.cov[matches.detection], rig, xyz, uv, method.centroid_sd)
    cov = cov + (hidden_variance(rig, xyz, area) + method.model_sd**2)[..., None, None] * np.eye(2)
    residual = uv - np.stack([project(camera, xyz) for camera in rig], 1)
    cloud = Cloud(
        rate=detections.rate,
        start=np.searchsorted(matches.frame, np.arange(matches.n_frames + 1)),
        xyz=xyz,
        cov=_covariance(rig, xyz, kept, residual, cov),
        residual=np.sqrt(np.nansum(residual**2, axis=(1, 2)) / np.maximum(seen.sum(1), 1)),
        detection=matches.detection,
    )
    margin = method.volume_margin if method.within_volume else None
    return cloud.keep(usable_points(cloud, rig, margin=margin) & np.isfinite(cloud.cov).all((1, 2)))


def solutions(rig: Rig, uv: Floats) -> Floats:
    """(P, Q, 3) mm: the point of every pair of cameras (1), in the order of `itertools.combinations`.

    uv (P, C, 2) px, NaN where unseen. NaN where one of a pair does not see the point, or where the rays are parallel.
    """
    ideal = undistort_all(rig, uv)
    pairs = list(combinations(range(len(rig)), 2))
    out = np.full((len(uv), len(pairs), 3), np.nan)
    for q, pair in enumerate(pairs):
        both = ~np.isnan(ideal[:, pair, 0]).any(1)
        out[both, q] = triangulate(ideal[both][:, pair], rig.P[list(pair)])  # (1)
    return out


def agreeing(each: Floats, views: Ints, *, outlier_ratio: float = 2.0) -> Bools:
    """(P, Q) the solutions (P, Q, 3) that are not left out by (5), of points seen by `views` (P) cameras."""
    kept = np.zeros(each.shape[:2], bool)
    step = max(1, BLOCK // max(each.shape[1] ** 2, 1))
    for first in range(0, len(each), step):
        rows = slice(first, first + step)
        there = ~np.isnan(each[rows, :, 0])
        k = np.maximum((views[rows] - 1) * (views[rows] - 2) // 2 - 1, 1)  # (4)
        k = np.minimum(k, np.maximum(there.sum(1) - 1, 1))  # parallel rays have no solution
        m = _nearest(each[rows], k)
        least = m.min(axis=1, keepdims=True, initial=np.inf)
        kept[rows] = there & ((m < outlier_ratio * least) | (m <= least))  # (5)
    return kept


def _nearest(each: Floats, k: Ints) -> Floats:
    """(P, Q) mm: distance of each solution (P, Q, 3) from the k-th (P) nearest other one; inf where there is none."""
    square = sum((x[:, :, None] - x[:, None]) ** 2 for x in np.moveaxis(each, -1, 0))
    square = np.where(np.isnan(square) | np.eye(each.shape[1], dtype=bool), np.inf, square)
    m = np.full(each.shape[:2], np.inf)
    for value in np.unique(k).tolist():
        if value <= each.shape[1]:
            m[k == value] = np.partition(square[k == value], value - 1, axis=2)[..., value - 1]
    return np.sqrt(m)


def _mean(each: Floats, kept: Bools) -> Floats:
    """(P, 3) mm, the mean of the solutions kept (3); NaN where there is none."""
    total = np.where(kept[..., None], each, 0.0).sum(1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(total / kept.sum(1)[:, None])


def _covariance(rig: Rig, xyz: Floats, kept: Bools, residual: Floats, cov: Floats) -> Floats:
    """(P, 3, 3) mm², of the mean of the solutions kept (7), widened by (8)."""
    pull, normal, image = _pair_terms(rig, xyz, cov)
    H = np.zeros_like(pull)  # (P, C, 3, 2)
    used = np.zeros(H.shape[:2], bool)
    for q, (a, b) in enumerate(combinations(range(len(rig)), 2)):
        own = kept[:, q]
        inverse = inverse3(normal[own, a] + normal[own, b])
        for c in (a, b):
            H[own, c] += inverse @ pull[own, c]  # (6)
            used[own, c] = True
    H /= np.maximum(kept.sum(1), 1)[:, None, None, None]
    squared = (residual * np.linalg.solve(image, residual[..., None])[..., 0]).sum(-1)
    usual = 2 * scipy.special.gammaincinv(np.maximum(used.sum(1) - 1.5, 0.5), 0.95)
    widened = np.maximum(np.sum(squared, axis=1, where=used) / usual, 1.0)  # (8)
    part = H @ image @ H.swapaxes(-1, -2)
    return np.asarray(np.sum(part, axis=1, where=used[..., None, None]) * widened[:, None, None])  # (7)


def _pair_terms(rig: Rig, xyz: Floats, cov: Floats) -> tuple[Floats, Floats, Floats]:
    """Of (6) and (7), for each point and camera: w² Jᵀ A (P, C, 3, 2), w² Jᵀ J (P, C, 3, 3) and C (P, C, 2, 2)."""
    pull, normal = np.empty((len(xyz), len(rig), 3, 2)), np.empty((len(xyz), len(rig), 3, 3))
    image = cov.copy()
    for c, camera in enumerate(rig):
        drawn = point_jacobian(camera, xyz)
        x = to_camera(camera, xyz)
        xy1 = np.column_stack([x[:, :2] / x[:, 2:], np.ones(len(x))])
        J = camera.K[:2, :2] @ (np.eye(3)[:2] - xy1[:, :2, None] * np.eye(3)[2]) @ camera.R  # w ∂û/∂X
        A = np.linalg.solve(drawn @ drawn.swapaxes(1, 2), drawn @ J.swapaxes(1, 2)).swapaxes(1, 2)  # w ∂û/∂u
        pull[:, c], normal[:, c] = J.swapaxes(1, 2) @ A, J.swapaxes(1, 2) @ J
        if camera.cov.any():
            by = parameter_jacobian(camera, xyz)
            image[:, c] += by @ camera.cov @ by.swapaxes(1, 2)
    return pull, normal, image
