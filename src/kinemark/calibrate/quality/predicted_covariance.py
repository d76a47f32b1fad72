"""How exactly calibrated cameras will place a marker, before any marker is there.

A marker at X is seen by cameras c at pixels that are wrong by ε_c, of variance s² in u and in v, while the cameras'
parameters are wrong by δ, all of them together of covariance Σ. Camera c expects its images to be off by

    C_c = s² I + T_c Σ_cc T_cᵀ,    T_c = d uv / d parameters             (1)

and weighs them by W_c = C_c⁻¹ (`geometry.refine`). With J_c = d uv / d X the position found is off by

    N⁻¹ Σ J_cᵀ W_c (ε_c − T_c δ_c),    N = Σ J_cᵀ W_c J_c                 (2)

so that its covariance is

    N⁻¹ (s² Σ J_cᵀ W_c² J_c + B Σ Bᵀ) N⁻¹,    B = [J_cᵀ W_c T_c]          (3)

which is N⁻¹ where the cameras were calibrated one by one and Σ has no blocks beside its diagonal.

Where a bundle of all cameras found the parameters, Σ depends on where its world was fixed: measured from the first
camera, far places look worse than they are. Moving the world by a small turn ω and shift τ changes every camera by

    r → r − R ω,    t → t − R τ                                          (4)

and all points by ω × X + τ. The turn and shift that best undo the errors (2) over the places of interest are linear
in δ, so that Σ without them is S Σ Sᵀ (5) (Baarda's S-transformation): what remains is the error of shapes and
distances.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...data import PARAMETERS, Camera, Rig
from ...data.array_types import Bools, Floats
from ...geometry import joint_about, origin_near, parameter_jacobian, point_jacobian, project, rig_about, undistort
from ...numerics.small_matrices import inverse3

FOLDED = 1e-3
"""px; further than this from its own image, a point is on the far side of a lens term's fold; chosen (see
studies/calibration_quality.py)."""


class CameraViews(NamedTuple):
    """What each of C cameras says of each of N places; zero where it does not see the place.

    information: (C, N, 3, 3) Jᵀ W J, 1/mm²; noise: (C, N, 3, 3) s² Jᵀ W² J; pull: (C, N, 3, 15) Jᵀ W T; seen: (C, N).
    """

    information: Floats
    noise: Floats
    pull: Floats
    seen: Bools


def visible(rig: Rig, xyz: Floats) -> Bools:
    """(C, N) whether each camera has each place (N, 3) mm in its image; an image of unknown size has no edges."""
    return np.stack([_in_image(camera, xyz) for camera in rig]) if len(rig) else np.zeros((0, len(xyz)), np.bool_)


def _in_image(camera: Camera, xyz: Floats) -> Bools:
    uv = project(camera, xyz)
    inside: Bools = np.asarray(np.isfinite(uv).all(1), np.bool_)
    if (camera.size > 0).all():
        inside &= (uv > -0.5).all(1) & (uv < camera.size - 0.5).all(1)
    ideal = project(_without_lens(camera), xyz[inside])
    inside[inside] = np.linalg.norm(undistort(camera, uv[inside]) - ideal, axis=1) < FOLDED
    return inside


def _without_lens(camera: Camera) -> Camera:
    return Camera(camera.name, camera.size, camera.K, camera.R, camera.t)


def views(rig: Rig, xyz: Floats, *, centroid_sd: float) -> CameraViews:
    """The parts of (2) and (3) of every camera at places (N, 3) mm, for centroids of `centroid_sd` px."""
    c, n = len(rig), len(xyz)
    information, noise, pull = np.zeros((c, n, 3, 3)), np.zeros((c, n, 3, 3)), np.zeros((c, n, 3, len(PARAMETERS)))
    seen = visible(rig, xyz)
    for i, camera in enumerate(rig):
        J, T = point_jacobian(camera, xyz[seen[i]]), parameter_jacobian(camera, xyz[seen[i]])
        W = np.linalg.inv(centroid_sd**2 * np.eye(2) + T @ camera.cov @ T.transpose(0, 2, 1))  # (1)
        JtW = J.transpose(0, 2, 1) @ W
        information[i, seen[i]] = JtW @ J
        noise[i, seen[i]] = centroid_sd**2 * JtW @ JtW.transpose(0, 2, 1)
        pull[i, seen[i]] = JtW @ T
    return CameraViews(information, noise, pull, seen)


def covariance_from(said: CameraViews, joint: Floats, *, without: Sequence[int] = ()) -> Floats:
    """(N, 3, 3) mm² by (3); NaN where fewer than two cameras remain."""
    left = np.array([c not in without for c in range(len(said.seen))], np.bool_)
    information = inverse3(said.information[left].sum(0))
    B = np.where(left[:, None, None, None], said.pull, 0.0).transpose(1, 2, 0, 3).reshape(-1, 3, joint.shape[0])
    cov = information @ (said.noise[left].sum(0) + B @ joint @ B.transpose(0, 2, 1)) @ information  # (3)
    return np.where((said.seen[left].sum(0) >= 2)[:, None, None], cov, np.nan)


def predicted_covariance(
    rig: Rig, xyz: Floats, *, centroid_sd: float, joint: Floats | None = None, without: Sequence[int] = ()
) -> Floats:
    """Covariance (N, 3, 3) mm² of a marker reconstructed at places (N, 3) mm from all cameras that see them.

    Args:
        rig: the cameras, with the covariances of their calibration.
        xyz: (N, 3) mm.
        centroid_sd: standard deviation of a centroid along u and along v, px.
        joint: (15 C, 15 C) covariance of `data.PARAMETERS` of all cameras together, one camera after the other, zero
            for what is held; without it that of the rig, `joint_of`.
        without: cameras, by their place in the rig, that are not used.

    Raises:
        ValueError: the standard deviation is not positive, or a shape is not as above.
    """
    if not centroid_sd > 0:
        raise ValueError(f"centroid_sd is {centroid_sd}, wanted more than 0 px")
    joint = joint_of(rig) if joint is None else joint
    wanted = (len(PARAMETERS) * len(rig),) * 2
    if joint.shape != wanted or xyz.ndim != 2 or xyz.shape[1] != 3:
        raise ValueError(f"joint has shape {joint.shape} and xyz {xyz.shape}, wanted {wanted} and (N, 3)")
    return covariance_from(views(rig, xyz, centroid_sd=centroid_sd), joint, without=without)


def joint_of(rig: Rig) -> Floats:
    """(15 C, 15 C) of the cameras' own covariances, and between cameras what they have in common."""
    p, k = len(PARAMETERS), max((camera.common.shape[1] for camera in rig), default=0)
    F = np.zeros((p * len(rig), k))
    for c, camera in enumerate(rig):
        F[p * c : p * (c + 1), : camera.common.shape[1]] = camera.common
    joint = F @ F.T
    for c, camera in enumerate(rig):
        joint[p * c : p * (c + 1), p * c : p * (c + 1)] = camera.cov
    return joint


def apart_from_frame(rig: Rig, joint: Floats, xyz: Floats, *, centroid_sd: float) -> Floats:
    """The joint covariance (15 C, 15 C) without what a turn and shift of the whole world explain at xyz (N, 3), by (5).

    Places that fewer than two cameras see do not count.
    """
    origin = origin_near(xyz)
    rig, joint, xyz = rig_about(rig, origin), joint_about(rig, joint, origin), xyz - origin
    said = views(rig, xyz, centroid_sd=centroid_sd)
    usable = said.seen.sum(0) >= 2
    inverse = inverse3(said.information.sum(0)[usable])
    B = said.pull[:, usable].transpose(1, 2, 0, 3).reshape(-1, 3, joint.shape[0])
    shift = -(inverse @ B).reshape(-1, joint.shape[0])  # (2): how all the places move with δ
    G = np.concatenate([_turned(xyz[usable]), np.tile(np.eye(3), (int(usable.sum()), 1, 1))], 2).reshape(-1, 6)
    S = np.eye(len(joint)) - _moves(rig) @ np.linalg.pinv(G) @ shift
    return joint_about(rig, S @ joint @ S.T, -origin)  # (5)


def _turned(xyz: Floats) -> Floats:
    """d (ω × X) / d ω, (N, 3, 3)."""
    x, y, z = xyz.T
    zero = np.zeros_like(x)
    return np.stack([np.stack([zero, z, -y], -1), np.stack([-z, zero, x], -1), np.stack([y, -x, zero], -1)], -2)


def _moves(rig: Rig) -> Floats:
    """(15 C, 6) how all parameters change with a turn and a shift of the world, by (4)."""
    H = np.zeros((len(rig), len(PARAMETERS), 6))
    turn, place = PARAMETERS.index("rx"), PARAMETERS.index("tx")
    for c, camera in enumerate(rig):
        H[c, turn : turn + 3, :3] = H[c, place : place + 3, 3:] = -camera.R
    return H.reshape(-1, 6)
