"""How well the room is known: the error that all positions have in common, because an L-frame says where the world is.

A bundle knows its cameras in a frame in which the waved points rest as a whole (`bundle.parameter_covariance`). Points
whose places are known, as an L-frame's markers, then carry it into the room. Where they are seen at X_m with the errors
dX_m, the room is laid wrongly by the motion p = (ω, τ, γ) that fits these best,

    p = G⁺ dX,    G_m = (−[X_m − c]×, 1, (X_m − c) / ρ)                  (1)

about their middle c, with growth γ only where lengths came from them as well (ρ is their spread). By (2) of
`predicted_covariance`

    dX_m = N_m⁻¹ Σ J_cᵀ W_c (ε̄_c − T_c δ_c)                              (2)

in which δ, the cameras' errors, is common to all of them, and ε̄ is the mean of n frames, of variance s² / n. Thus

    Σ_p = G⁺ (D Σ Dᵀ + noise / n) G⁺ᵀ                                    (3)

and a position at X is moved in the room by g(X) p, with g as G_m. That is the same in every frame and nearly the same
at neighbouring places: it changes no distance and no angle between markers, and no filter can lessen it. So it stands
beside the covariance of a position, which is that of positions relative to each other:

    covariance in the room = C + g Σ_p gᵀ                                (4)

What is known of the points is taken as exact: arms measured wrongly, or a floor that is not level, are not in it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data import Rig
from ...data.array_types import Floats
from ...geometry import joint_about, rig_about
from ...numerics.small_matrices import inverse3
from ...numerics.vectors import cross_matrix
from .predicted_covariance import views

FEWEST = 3  # points that fix a world; by definition


class WorldPose(NamedTuple):
    """The error of a world's pose, about a place in it.

    centre: (3,) mm c of (1); cov: (7, 7) Σ_p of (3), of a turn, rad, a shift, mm, and a growth, mm; spread: ρ, mm.
    """

    centre: Floats
    cov: Floats
    spread: float

    def at(self, xyz: Floats) -> Floats:
        """(N, 3, 3) mm², what it adds to the covariances of positions (N, 3) mm, by (4)."""
        g = _motions(xyz - self.centre, self.spread)
        return g @ self.cov @ g.transpose(0, 2, 1)


def world_pose(
    rig: Rig, joint: Floats, known: Floats, *, centroid_sd: float, frames: int = 1, grows: bool = False
) -> WorldPose | None:
    """The error with which points at known places put the world of a rig; None where those in two
    images do not fix it.

    Args:
        rig: C cameras, in the world that the points gave.
        joint: (15 C, 15 C) covariance of all cameras' parameters together, of a `BundleFit`.
        known: (M, 3) mm where the points are in it.
        centroid_sd: standard deviation of a centroid along u and along v, px.
        frames: of how many the places are the mean.
        grows: whether the points gave the lengths as well.
    """
    centre = np.round(known.mean(0))
    about, joint, near = rig_about(rig, centre), joint_about(rig, joint, centre), known - centre
    said = views(about, near, centroid_sd=centroid_sd)
    usable = said.seen.sum(0) >= 2
    if usable.sum() < FEWEST:
        return None
    near = near[usable]
    inverse = inverse3(said.information[:, usable].sum(0))
    D = inverse @ said.pull[:, usable].transpose(1, 2, 0, 3).reshape(len(near), 3, -1)
    D = D.reshape(-1, joint.shape[0])
    cov = D @ joint @ D.T  # (2)
    noise = inverse @ said.noise[:, usable].sum(0) @ inverse / frames
    for m, own in enumerate(noise):
        cov[3 * m : 3 * m + 3, 3 * m : 3 * m + 3] += own
    spread = float(np.sqrt((near**2).sum(1).mean()))
    G = _motions(near, spread).reshape(-1, 7)
    G[:, 6] *= grows
    if np.linalg.matrix_rank(G[:, :6]) < 6:
        return None
    back = np.linalg.pinv(G)  # (1)
    return WorldPose(centre, back @ cov @ back.T, spread)


def _motions(offset: Floats, spread: float) -> Floats:
    """G_m (M, 3, 7) of (1) at places (M, 3) mm from the centre."""
    one = np.broadcast_to(np.eye(3), (len(offset), 3, 3))
    return np.concatenate([-cross_matrix(offset), one, offset[..., None] / spread], -1)
