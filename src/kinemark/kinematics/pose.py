"""Where a body is, from three or more markers on it, and the points that it carries.

A template p_k (mm, about any origin) comes from a static trial: the markers of all its frames laid upon each other
(generalised Procrustes). In a frame with markers x_k the pose minimises

    Σ_k |R p_k + t − x_k|²,   R = U diag(1, 1, det U Vᵀ) Vᵀ,   U S Vᵀ = Σ (x_k − x̄)(p_k − p̄)ᵀ             (1)

over the markers seen (Kabsch 1976; Söderkvist and Wedin 1993). Three that are not on a line are needed. If each marker
is off by σ in each direction, the error of the rotation, as a vector in the laboratory, has the covariance

    σ² [Σ (|r_k|² I − r_k r_kᵀ)]⁻¹,   r_k = R (p_k − p̄)                                                  (2)

and σ² is estimated by Σ |R p_k + t − x_k|² / (3 K − 6) (3). Points q known in the static trial move with the body:
R q + t (4) (calibrated anatomical landmarks, Cappozzo et al. 1995). What all markers of a cluster do together, as skin
over bone does, (2) and (3) cannot see.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats, Ints
from ..data.arrays import column, set_columns

ON_A_LINE = 1e-3
"""A cluster's second greatest extent over its greatest below which its markers are on a line; chosen."""


class Pose(NamedTuple):
    """A body over frames (…): where its template lies in the laboratory.

    Attributes:
        R: (…, 3, 3) the template's axes as columns; t: (…, 3) mm its origin; NaN where unknown.
        residual: (…) mm, √ of (3): how far one marker is off along an axis; NaN with three markers that fit exactly
            or where unknown.
        used: (…) how many markers were seen.
    """

    R: Floats
    t: Floats
    residual: Floats
    used: Ints


@dataclass(frozen=True, slots=True, eq=False)
class ClusterTemplate:
    """A cluster as the static trial has it.

    Attributes:
        markers: (K) names; xyz: (K, 3) mm about their mean.
        points: (P) names of what it carries; local: (P, 3) mm, in the same axes.
    """

    name: str
    markers: tuple[str, ...]
    xyz: Floats
    points: tuple[str, ...]
    local: Floats

    def __post_init__(self) -> None:
        set_columns(
            self,
            xyz=column("xyz", self.xyz, np.float64, len(self.markers), 3),
            local=column("local", self.local, np.float64, len(self.points), 3),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Template:
    """All clusters of a model."""

    clusters: tuple[ClusterTemplate, ...]

    @property
    def points(self) -> frozenset[str]:
        """Every point that is carried."""
        return frozenset(p for cluster in self.clusters for p in cluster.points)

    def of(self, marker: str) -> Template:
        """Only the clusters that have a marker."""
        return Template(tuple(cluster for cluster in self.clusters if marker in cluster.markers))

    def __getitem__(self, name: str) -> ClusterTemplate:
        """The cluster of that name."""
        for cluster in self.clusters:
            if cluster.name == name:
                return cluster
        raise KeyError(f"no cluster {name!r}; there are {', '.join(c.name for c in self.clusters)}")


def body_pose(template: Floats, xyz: Floats) -> Pose:
    """The pose (1) of a template (K, 3) in every frame of markers (K, …, 3) mm; NaN markers are left out.

    Raises:
        ValueError: the numbers of markers differ.
    """
    if len(template) != len(xyz) or template.shape[1:] != (3,) or xyz.shape[-1:] != (3,):
        raise ValueError(f"template is {template.shape} and xyz {xyz.shape}, wanted (K, 3) and (K, …, 3)")
    x = np.moveaxis(xyz, 0, -2)
    seen = np.asarray(np.isfinite(x).all(-1))
    n = seen.sum(-1)
    w = seen / np.maximum(n, 1)[..., None]
    x = np.where(seen[..., None], x, 0.0)
    p_mean, x_mean = w @ template, (w[..., None] * x).sum(-2)
    p, x = template - p_mean[..., None, :], x - x_mean[..., None, :]
    U, S, Vt = np.linalg.svd(np.einsum("...k,...ki,...kj->...ij", w, x, p))
    U[..., :, 2] *= np.sign(np.linalg.det(U @ Vt))[..., None]
    R = U @ Vt  # (1)
    good = (n >= 3) & (S[..., 1] > ON_A_LINE**2 * S[..., 0])
    squared = ((x - p @ np.swapaxes(R, -1, -2)) ** 2).sum(-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        residual = np.where(good, np.sqrt((seen * squared).sum(-1) / (3 * n - 6)), np.nan)  # (3)
    R = np.where(good[..., None, None], R, np.nan)
    return Pose(R, x_mean - np.einsum("...ij,...j->...i", R, p_mean), residual, n)


def rotation_covariance(template: Floats, pose: Pose, sd_mm: Floats | float) -> Floats:
    """(…, 3, 3) deg² of the rotation's error as a vector in the laboratory (2), with all markers of (K, 3) seen.

    Args:
        template: (K, 3) mm.
        pose: of it.
        sd_mm: σ of a marker along an axis, one for all or one a frame (…).
    """
    p = template - template.mean(0)
    inertia = (p * p).sum() * np.eye(3) - p.T @ p
    C = pose.R @ np.linalg.inv(inertia) @ np.swapaxes(pose.R, -1, -2)  # (2)
    return C * np.asarray(sd_mm)[..., None, None] ** 2 * np.degrees(1.0) ** 2


def cluster_template(
    name: str, markers: tuple[str, ...], xyz: Floats, points: tuple[str, ...], carried: Floats
) -> ClusterTemplate:
    """A template from the static frames in which all markers (K, F, 3) mm are seen; carried (P, F, 3) mm.

    Raises:
        KinemarkError: no frame has all markers, they are on a line, or a point is never seen with them.
    """
    frames = np.isfinite(xyz).all(axis=(0, 2))
    if not frames.any():
        raise KinemarkError(f"No frame of the static trial has all of {', '.join(markers)}. Record another one.")
    x = xyz[:, frames]
    shape = x[:, 0] - x[:, 0].mean(0)
    if np.linalg.svd(shape, compute_uv=False)[1] <= ON_A_LINE * np.linalg.norm(shape):
        raise KinemarkError(f"The markers {', '.join(markers)} are on a line, which shows no rotation about it.")
    for _ in range(3):  # to the mean of all frames laid upon it; it moves by less than a micron after the second
        pose = body_pose(shape, x)
        shape = _into(pose, x).mean(1)
        shape = shape - shape.mean(0)
    local = _into(body_pose(shape, x), carried[:, frames])
    there = np.asarray(np.isfinite(local).all(-1))
    if absent := [p for p, seen in zip(points, there, strict=True) if not seen.any()]:
        raise KinemarkError(f"The static trial never shows {', '.join(absent)} with all of cluster {name}.")
    mean = np.array([one[seen].mean(0) for one, seen in zip(local, there, strict=True)]).reshape(-1, 3)
    return ClusterTemplate(name, markers, shape, points, mean)


def _into(pose: Pose, xyz: Floats) -> Floats:
    """Positions (N, F, 3) mm in the laboratory, in the body's axes."""
    return np.einsum("fji,nfj->nfi", pose.R, xyz - pose.t)


def carry(points: Mapping[str, Floats], template: Template) -> dict[str, Floats]:
    """Where the bodies have the points that they carry (4), (…, 3) mm each, from their markers (…, 3) mm by name."""
    found: dict[str, Floats] = {}
    for cluster in template.clusters:
        if cluster.points and all(m in points for m in cluster.markers):
            pose = body_pose(cluster.xyz, np.array([points[m] for m in cluster.markers]))
            for name, q in zip(cluster.points, cluster.local, strict=True):
                found[name] = pose.R @ q + pose.t  # (4)
    return found
