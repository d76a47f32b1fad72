"""A point in space from its images in two or more cameras.

A camera with rows p1, p2, p3 of P sees X at the ideal pixel (u, v) when

    (p1 − u p3) · (X, 1) = 0,   (p2 − v p3) · (X, 1) = 0                 (1)  KISS eq. 7, Swamidas eq. 3.8

Written for n cameras, (1) is B X = D (2) with the least squares solution X = (BᵀB)⁻¹ BᵀD (3): KISS eq. 9–10,
Swamidas eq. 3.9–3.12. Cameras that do not see the point give rows of zeros (4), so that one batch serves every
pattern of visibility. (3) minimises no distance in the image, so a far camera weighs more than it should.

`refine` minimises Σ (uv − project(X))ᵀ C⁻¹ (uv − project(X)) (5), distortion included, by Gauss-Newton steps from
(3). C is the covariance of each centroid plus what the camera's own calibration leaves open,
C = C_centroid + J_θ C_θ J_θᵀ (6), and the inverse of the normal matrix, V = (Σ Jᵀ C⁻¹ J)⁻¹ (7), is the covariance of X
where each camera errs by itself. Errors F that the cameras have in common (`Camera.common`) move X by V Σ N_c, the sum
of what they do in each camera c, N_c = J_cᵀ C_c⁻¹ J_θ F_c, so that its covariance is

    V + V ((Σ N_c)(Σ N_c)ᵀ − Σ N_c N_cᵀ) V                               (8)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import Camera, Rig
from ..data.array_types import Bools, Floats, Ints
from ..numerics.small_matrices import inverse3, solve3
from .camera import calibration_errors, project_with_jacobian


class Triangulated(NamedTuple):
    """Refined points: xyz (N, 3) mm; cov (N, 3, 3) mm²; residual (N, C, 2) px, seen minus reprojected, NaN unseen."""

    xyz: Floats
    cov: Floats
    residual: Floats


def triangulate(uv: Floats, P: Floats) -> Floats:
    """World points (N, 3) mm from ideal pixels uv (N, C, 2), NaN where unseen, and projections P (C, 3, 4), by (3).

    Fewer than two views, or rays that are parallel, give NaN.
    """
    rows = P[:, :2] - uv[..., None] * P[:, 2:]  # (1)  (N, C, 2, 4)
    seen = ~np.isnan(uv[..., 0])
    rows = np.where(seen[..., None, None], rows, 0.0).reshape(len(uv), 2 * len(P), 4)  # (4)
    B, D = rows[..., :3], -rows[..., 3]  # (2)
    normal = np.matmul(B.transpose(0, 2, 1), B)
    return np.where((seen.sum(1) >= 2)[:, None], solve3(normal, np.einsum("nij,ni->nj", B, D)), np.nan)  # (3)


def refine(rig: Rig, xyz: Floats, uv: Floats, cov: Floats, *, steps: int = 3, exact: bool = True) -> Triangulated:
    """The most likely points by (5), from first guesses xyz (N, 3) mm.

    Args:
        rig: C cameras; where one has a parameter covariance, (6) adds it, and (8) what cameras have in common.
        xyz: (N, 3) from `triangulate`.
        uv: (N, C, 2) pixels as the lens drew them, NaN where unseen.
        cov: (N, C, 2, 2) their covariance, px².
        steps: Gauss-Newton steps; two bring a good first guess to the micrometre.
        exact: work out cov and residual anew where the last step led to; else they follow from the projections where it
            began as if these were linear, which is as good where the step is small beside the cameras' distance.
    """
    seen = ~np.isnan(uv[..., 0]) & ~np.isnan(xyz[:, :1])
    views = [_view(camera, c, s, xyz, uv, cov) for c, (camera, s) in enumerate(zip(rig, seen.T, strict=True))]
    step = np.zeros_like(xyz)
    for _ in range(steps):
        normal, pull, each = _normal_equations(views, xyz)
        step = solve3(normal, pull)
        xyz = xyz + step
    if exact or not steps:
        normal, _, each = _normal_equations(views, xyz)
        step = np.zeros_like(xyz)
    residual = np.full(uv.shape, np.nan)
    for c, (view, (beside, J)) in enumerate(zip(views, each, strict=True)):
        residual[view.point, c] = (beside if exact else beside - np.einsum("ain,ni->an", J, step[view.point])).T
    V = inverse3(normal)  # (7)
    return Triangulated(xyz, V + _in_common(views, each, V) if rig.has_common_errors else V, residual)


class _View(NamedTuple):
    """What a camera sees: n points, their uv (2, n) px, xx, xy and yy of C⁻¹ (3, n) 1/px², and J_θ F (2, k, n) px."""

    camera: Camera
    point: Ints
    uv: Floats
    weight: Floats
    common: Floats

    def weighed(self, J: Floats) -> Floats:
        """C⁻¹ J (2, 3, n) of J (2, 3, n)."""
        xx, xy, yy = self.weight
        return np.stack([xx * J[0] + xy * J[1], xy * J[0] + yy * J[1]])


def _view(camera: Camera, c: int, seen: Bools, xyz: Floats, uv: Floats, cov: Floats) -> _View:
    """What camera c sees of points at xyz (N, 3) mm."""
    point = np.flatnonzero(seen)
    C, common = cov[point, c].transpose(1, 2, 0), np.zeros((2, 0, len(point)))
    if camera.cov.any():
        variance, common = calibration_errors(camera, xyz[point].T)
        C = C + variance  # (6)
    weight = np.stack([C[1, 1], -C[0, 1], C[0, 0]]) / (C[0, 0] * C[1, 1] - C[0, 1] * C[1, 0])
    return _View(camera, point, uv[point, c].T, weight, common)


def _normal_equations(views: list[_View], xyz: Floats) -> tuple[Floats, Floats, list[tuple[Floats, Floats]]]:
    """Σ Jᵀ C⁻¹ J (N, 3, 3), Σ Jᵀ C⁻¹ e (N, 3), and of each view e = uv − project (2, n) px and J (2, 3, n)."""
    normal, pull, each = np.zeros((3, 3, len(xyz))), np.zeros((3, len(xyz))), list[tuple[Floats, Floats]]()
    for view in views:
        drawn, J = project_with_jacobian(view.camera, xyz[view.point].T)
        each.append((residual := view.uv - drawn, J))
        WJ = view.weighed(J)
        normal[..., view.point] += np.einsum("ain,ajn->ijn", WJ, J)
        pull[:, view.point] += np.einsum("ain,an->in", WJ, residual)
    return normal.transpose(2, 0, 1), pull.T, each


def _in_common(views: list[_View], each: list[tuple[Floats, Floats]], V: Floats) -> Floats:
    """(N, 3, 3) mm² by which (8) differs from V (N, 3, 3), with J of `each` view."""
    k = max(view.common.shape[1] for view in views)
    together, apart = np.zeros((3, k, len(V))), np.zeros((3, 3, len(V)))
    for view, (_, J) in zip(views, each, strict=True):
        if not view.common.size:
            continue
        N = np.einsum("ain,akn->ikn", view.weighed(J), view.common)
        together[..., view.point] += N
        apart[..., view.point] += np.einsum("ikn,jkn->ijn", N, N)
    return np.asarray(V @ (np.einsum("ikn,jkn->ijn", together, together) - apart).transpose(2, 0, 1) @ V)
