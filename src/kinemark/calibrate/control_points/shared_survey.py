"""The survey's share in the errors of cameras, which all of them have in common.

A control point that was surveyed wrongly by d_i is wrong for every camera that sees it. Each camera c follows it, and
so do points that are reconstructed: more cameras do not make this error less, as they do that of images. With residuals
r_c of camera c in units of its noise s_c, G_ci their derivatives by the places of points, and J by its parameters,

    r_c = (1 − J A⁻¹ Jᵀ)(G_c d + noise),    A = JᵀJ                      (1)

noise of two cameras has nothing in common, so that their residuals agree by the survey alone. With g_ci = G_ciᵀ r_ci
and P_c = G_cᵀ (1 − J A⁻¹ Jᵀ) G_c, the survey's variance is, by the method of moments,

    σ² = Σ_{c<d} g_c · g_d / Σ_{c<d} tr(P_c P_d)                         (2)

and what camera c has of it, the covariance V_c = σ² A⁻¹ Jᵀ G Gᵀ J A⁻¹ of its parameters (3). Points take the errors of
cameras for independent. C cameras tell a coordinate 2 C / 3 times, so that an error that they share looks smaller by
as much in its variance; V_c counts so many times (4). Few points tell σ² by few degrees of freedom,

    ν = (tr Σ P_c)² / tr (Σ P_c)²                                        (5)

and it is enlarged by the factor of `numerics.small_sample`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...data import Camera
from ...data.array_types import Bools, Floats
from ...geometry import parameter_jacobian, point_jacobian, project
from ...numerics.scaled import scaled_inverse
from ...numerics.small_sample import variance_factor
from ..resection import directions
from .fit_camera import POSE_AND_FOCUS, FittedCamera

COORDINATES = 3  # of a place, told by two of each image; by definition
TINY = 1e-300  # keeps what no residual tells from being divided by zero; conventional


class _View(NamedTuple):
    """Of one camera: g (N, 3), the parts of P = D − L Lᵀ, D (N, 3, 3) and L (N, 3, p), and B A⁻¹ Jᵀ G (15, N, 3)."""

    pull: Floats
    own: Floats
    fitted: Floats
    follow: Floats

    @property
    def trace(self) -> float:
        """tr P."""
        return float(np.einsum("nii->", self.own) - (self.fitted**2).sum())


def with_shared_survey(fits: Sequence[FittedCamera], xyz: Floats, uv: Floats, cov: Floats) -> list[Camera]:
    """The cameras of fits to points (N, 3) mm seen at (C, N, 2) px of covariance (C, N, 2, 2), their own by (4)."""
    views = [_view(fit, xyz, *at) for fit, *at in zip(fits, uv, cov, strict=True)]
    common = np.array([[_common(a, b) for a in views] for b in views]).reshape(len(views), len(views))
    agree = np.array([[(a.pull * b.pull).sum() for a in views] for b in views]).reshape(len(views), len(views))
    apart = ~np.eye(len(views), dtype=np.bool_)
    variance = max(agree[apart].sum() / max(common[apart].sum(), TINY), 0.0)  # (2)
    nu = sum(view.trace for view in views) ** 2 / max(common.sum(), TINY)  # (5)
    once = 1.0  # is in the residuals
    more = max(2 * len(fits) / COORDINATES * variance_factor(nu) - once, 0.0) * variance  # (4)
    shared = [np.einsum("ank,bnk->ab", view.follow, view.follow) for view in views]  # (3)
    return [replace(fit.camera, cov=fit.camera.cov + more * V) for fit, V in zip(fits, shared, strict=True)]


def _view(fit: FittedCamera, xyz: Floats, uv: Floats, cov: Floats) -> _View:
    """What one camera says of the survey."""
    camera, kept = fit.camera, fit.kept
    linear = not fit.free.any()
    B = np.eye(15)[:, list(POSE_AND_FOCUS)] if linear else directions(camera, fit.free, fit.tied)
    whiten = np.linalg.inv(np.linalg.cholesky(cov[kept]))
    r = (whiten @ (uv[kept] - project(camera, xyz[kept]))[..., None])[..., 0]
    s = max(float(np.sqrt((r**2).sum() / max(fit.freedom, 1))), 1e-9)
    J = whiten @ parameter_jacobian(camera, xyz[kept]) @ B / s
    G = whiten @ point_jacobian(camera, xyz[kept]) / s
    flat = J.reshape(-1, B.shape[1])
    inverse = scaled_inverse(flat.T @ flat)
    GtJ = G.transpose(0, 2, 1) @ J
    return _View(
        pull=_all(np.einsum("nij,ni->nj", G, r / s), kept),
        own=_all(G.transpose(0, 2, 1) @ G, kept),
        fitted=_all(GtJ @ np.linalg.cholesky(inverse), kept),
        follow=np.moveaxis(_all(GtJ @ inverse @ B.T, kept), 2, 0),
    )


def _all(x: Floats, kept: Bools) -> Floats:
    """x (n, …) of the kept points among all N, zero for the others."""
    whole = np.zeros((len(kept), *x.shape[1:]))
    whole[kept] = x
    return whole


def _common(a: _View, b: _View) -> float:
    """tr(P_a P_b)."""
    cross = np.einsum("nip,niq->pq", a.fitted, b.fitted)
    one = np.einsum("nip,nij,njp->", a.fitted, b.own, a.fitted)
    other = np.einsum("nip,nij,njp->", b.fitted, a.own, b.fitted)
    return float((a.own * b.own).sum() - one - other + (cross**2).sum())
