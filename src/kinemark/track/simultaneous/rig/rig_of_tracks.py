"""The rig adjusted to the images of its own tracks: a bundle adjustment, held to what the images disagree by before.

Epipolar residuals (`adjusted_rig`) tell how cameras are turned, before anything is tracked. Points X of three images
and more tell where each camera stands as well. With q = R X + t in a camera's frame and the image u = F q_xy / q_z + c,
F being K without its last row and column, a camera turned by ω, moved by z ε, z the median depth of its points, and
refocused by the factor 1 + s has

    δq = ω × q − z ε,   δu = ∂u/∂q δq + s F q_xy / q_z                                    (1)

and θ = (ω, ε, s) of all cameras, with the points, minimise

    Σ w |u − û|² / σ² + Σ (θ / θ₀)²                                                       (2)

by Gauss–Newton steps (`numerics.schur`), w being Cauchy's weights and σ the spread of all residuals, anew in each step
(`numerics.robust`). What the images do not tell, as where the rig stands as a whole, stays as it was by the second
term.

How far a calibration is off is seen in the residuals before. So θ₀ of a camera of focal length f is

    θ₀ = k σ_before / f                                                                   (3)

in rad, of the depth, and of the focal length. Groups of cameras that few points tie to each other, as on the two sides
of a plate, so move against each other little farther than the cameras of each disagree. By more, cameras were moved
until the markers of one side met those of the other.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ....data import Camera, Rig
from ....data.array_types import Bools, Floats, Ints
from ....numerics.robust import cauchy_weight, plane_scale
from ....numerics.schur import BlockEquations, block_inverses, block_step
from ..detection_index import Images
from ..following.candidate_points import intersect
from .adjusted_rig import turned

USUAL_SPREAD = 2.0
"""k of (3), without unit; chosen: 1.0 found 97.5 % of the samples of `gait9`, 2.0, 2.5 and 3.0 find 97.9, a fixed θ₀ of
1.5 mrad 97.8; with 2.5 the sides of a plate meet (seed 3003 of an independent generator)."""

FEWEST_IMAGES, FEWEST_POINTS = 3, 50
"""Images of a point that tells, by definition: two always nearly meet; and such points of a recording, chosen: points
of three images leave 150 equations for the 28 of four cameras. By 100 a row whose first pass had 84 stayed as it was,
and lost four of five samples (seed 51028 of an independent generator)."""

MOST_POINTS = 1500
"""Points that are looked at; chosen: more say the same."""

STEPS, SOFT = 8, 2.0
"""Of Gauss–Newton, chosen: what is adjusted no longer changes the tracks; c of Cauchy's weights, standard deviations,
chosen."""

LEAST_GAIN = 0.8
"""σ of (2) as a share of what it is before, from which on the rig stays as it was; chosen: right files have 0.93, as a
robust fit always finds something, and those whose adjustment helped 0.1 to 0.74 (scenes 97000 to 99013 of
benchmarks/tracking_scenes.py)."""

MOST_TAIL = 10.0
"""The 90 % quantile of |u − û|² over σ² times that of a normal distribution, above which the rig stays as it was: what
agrees is then where nothing moves, as of cameras that are not synchronous; chosen: simulated scenes have at most 5, the
infrared footage 80 to 130."""


EXACT = 1e-9
"""px of σ at least, by definition: images without noise leave rounding errors, half of which may be 0."""


class Derivatives(NamedTuple):
    """Residuals (C, S, 2) px, and what moves them: A (C, S, 2, 7) by θ, B (C, S, 2, 3) by the points."""

    r: Floats
    A: Floats
    B: Floats


def rig_of_tracks(detection: Ints, images: Images, rig: Rig, *, least: float = 0.0) -> Rig:
    """The rig by (2), of points with these detections (C, S), −1 for none; the same object where it gains nothing.

    Args:
        least: px, noise of images up to which they agree as well as they say, and the rig stays as it was.
    """
    own = (detection >= 0) & ~images.merged[detection]
    rows = np.flatnonzero(own.sum(0) >= FEWEST_IMAGES)
    if len(rows) < FEWEST_POINTS:
        return rig
    rows = rows[:: -(-len(rows) // MOST_POINTS)]
    detection = np.where(own[:, rows], detection[:, rows], -1)
    xyz = intersect(images, detection).xyz.T
    known = np.isfinite(xyz).all(1)
    xyz, seen, uv = xyz[known], detection[:, known] >= 0, images.uv[detection[:, known]]
    depth, theta = depths_of_points(rig, xyz, seen), np.zeros((len(rig), 7))
    weighted, _ = _weighted(image_derivatives(rig, xyz, uv, depth), seen)
    equations = _equations(weighted, theta, np.ones(len(rig)))
    xyz = xyz + (block_inverses(equations.V[0]) @ equations.h[0][..., None])[..., 0]  # the points alone
    weighted, before = _weighted(image_derivatives(rig, xyz, uv, depth), seen)
    if before <= least * np.sqrt(1 - 3 * len(xyz) / (2 * seen.sum())):  # a point fits three of its coordinates
        return rig
    usual = USUAL_SPREAD * before / np.array([camera.K[0, 0] for camera in rig])  # (3)
    for _ in range(STEPS):
        delta, (epsilon,), _ = block_step(_equations(weighted, theta, usual), 0.0)
        theta, xyz = theta + delta.reshape(theta.shape), xyz + epsilon
        weighted, after = _weighted(image_derivatives(_moved(rig, theta, depth), xyz, uv, depth), seen)
    adjusted = _moved(rig, theta, depth)
    squared = (image_derivatives(adjusted, xyz, uv, depth).r[seen] ** 2).sum(-1)
    tail = np.quantile(squared, 0.9) / (-2 * np.log(0.1) * after**2)
    return adjusted if after < LEAST_GAIN * before and tail < MOST_TAIL else rig


def depths_of_points(rig: Rig, xyz: Floats, seen: Bools) -> Floats:
    """(C) mm, the median depth of the points (S, 3) that each camera sees."""
    z = np.array([xyz @ camera.R[2] + camera.t[2] for camera in rig])
    return np.array([np.median(own[there]) if there.any() else 1.0 for own, there in zip(z, seen, strict=True)])


def image_derivatives(rig: Rig, xyz: Floats, uv: Floats, depth: Floats) -> Derivatives:
    """Of images (C, S, 2) px of points (S, 3) mm, by (1)."""
    R, t, K = (np.array([getattr(camera, name) for camera in rig]) for name in ("R", "t", "K"))
    q = xyz @ R.swapaxes(1, 2) + t[:, None]
    F, n = K[:, None, :2, :2], q[..., :2] / q[..., 2:]
    in_image = (F @ n[..., None])[..., 0]
    D = F @ np.concatenate([np.broadcast_to(np.eye(2), (*n.shape, 2)), -n[..., None]], -1) / q[..., 2:, None]
    turn = -np.cross(q[..., None, :], np.eye(3)).swapaxes(-1, -2)  # ω × q, a column a component of ω
    A = np.concatenate([D @ turn, -D * depth[:, None, None, None], in_image[..., None]], -1)
    return Derivatives(uv - in_image - K[:, None, :2, 2], A, D @ R[:, None])


def _weighted(all_: Derivatives, seen: Bools) -> tuple[Derivatives, float]:
    """The derivatives times √w / σ of (2), 0 where a camera (C, S) does not see the point; and σ."""
    squared = np.where(seen, (all_.r**2).sum(-1), 0.0)
    sigma = max(plane_scale(np.sqrt(squared[seen])), EXACT)
    root = np.where(seen, np.sqrt(cauchy_weight(squared / sigma**2, SOFT)) / sigma, 0.0)
    return Derivatives(all_.r * root[..., None], *(one * root[..., None, None] for one in all_[1:])), sigma


def _equations(by: Derivatives, theta: Floats, usual: Floats) -> BlockEquations:
    """The normal equations of a step from θ (C, 7): each camera's 7 parameters, held by θ₀ (C), and 3 a point."""
    C, n = theta.shape
    prior = usual**-2
    U, g = np.zeros((C, n, C, n)), np.einsum("csai,csa->ci", by.A, by.r) - theta * prior[:, None]
    for c, A in enumerate(by.A):
        U[c, :, c] = prior[c] * np.eye(n) + np.einsum("sai,saj->ij", A, A)
    W = np.einsum("csai,csaj->sicj", by.B, by.A).reshape(by.B.shape[1], 3, C * n)
    V, h = np.einsum("csai,csaj->sij", by.B, by.B), np.einsum("csai,csa->si", by.B, by.r)
    return BlockEquations(U.reshape(C * n, C * n), g.ravel(), [V], [W], [h])


def _moved(rig: Rig, theta: Floats, depth: Floats) -> Rig:
    """The rig with each camera changed by its θ (C, 7), at depths (C) mm."""
    return replace(rig, cameras=tuple(changed_camera(*each) for each in zip(rig, theta, depth, strict=True)))


def changed_camera(camera: Camera, theta: Floats, depth: float) -> Camera:
    """The camera turned and refocused, then moved."""
    new = turned(camera, theta[[0, 1, 2, 6]])
    return replace(new, t=new.t - depth * theta[3:6])
