"""How long a wand of known length comes out, frame by frame and place by place, with the error to expect.

Both ends are reconstructed on their own, as a marker would be; nothing knows of the wand's length. An end that camera
c sees with centroid error ε_c, its parameters being wrong by δ_c, is found wrong by (see `quality` eq. 2)

    N⁻¹ Σ J_cᵀ W_c (ε_c − T_c δ_c),    N = Σ J_cᵀ W_c J_c                (1)

so that the length, along the unit vector e from one end to the other, has the variance

    Σ_ends eᵀ N⁻¹ (Σ J_cᵀ W_c C_c W_c J_c) N⁻¹ e  +  b Σ bᵀ              (2)

with the centroids' covariances C_c, the joint covariance Σ of all cameras' parameters, and b the difference between
the ends of eᵀ N⁻¹ [J_cᵀ W_c T_c]: what is wrong at both ends alike does not change the length. Where the world's frame
was fixed does not matter to it either.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...data import Rig
from ...data.array_types import Floats, Ints
from ...geometry import parameter_jacobian, point_jacobian, refine, triangulate
from ...geometry.camera import undistort_all
from ...numerics.small_matrices import inverse3
from ..quality import joint_of

GUESS = 0.1
"""px; standard deviation of centroids that do not state theirs; chosen (see benchmarks/bundle.py)."""


class WandLengths(NamedTuple):
    """F frames of a wand between its outermost markers.

    place: (F, 3) the middle, mm; length: (F) mm; error: (F) length minus the true one, mm; sd: (F) its predicted
    standard deviation, mm; cameras: (F) how many see both ends. NaN where an end is seen by fewer than two cameras.
    """

    place: Floats
    length: Floats
    error: Floats
    sd: Floats
    cameras: Ints


def wand_lengths(
    rig: Rig, uv: Floats, *, along: ArrayLike, cov: Floats | None = None, joint: Floats | None = None
) -> WandLengths:
    """The length of a wand in every frame, from markers uv (C, F, K, 2) px, NaN where not seen.

    Args:
        rig: calibrated cameras.
        uv: as from `points`.
        along: (K) places of the markers along the wand, mm; the first and the last are used.
        cov: (C, F, K, 2, 2) px²; where it is not known, `GUESS`² along u and v.
        joint: (15 C, 15 C) covariance of all cameras' parameters together; without it the cameras' own.
    """
    along = np.asarray(along, np.float64)
    n, f = uv.shape[:2]
    ends = uv[:, :, [0, -1]].reshape(n, 2 * f, 2).transpose(1, 0, 2)
    spread = np.full((*uv.shape, 2), np.nan) if cov is None else cov
    spread = spread[:, :, [0, -1]].reshape(n, 2 * f, 2, 2).transpose(1, 0, 2, 3)
    spread = np.where(np.isfinite(spread), spread, GUESS**2 * np.eye(2))
    ideal = undistort_all(rig, ends)
    xyz = refine(rig, triangulate(ideal, rig.P), ends, spread).xyz
    pair = xyz.reshape(f, 2, 3)
    difference = pair[:, 1] - pair[:, 0]
    length = np.linalg.norm(difference, axis=1)
    sd = np.sqrt(_variance(rig, xyz, ends, spread, difference / length[:, None], joint))
    both = np.isfinite(uv[:, :, [0, -1]]).all((2, 3)).sum(0)
    return WandLengths(pair.mean(1), length, length - (along[-1] - along[0]), sd, both)


def _variance(rig: Rig, xyz: Floats, uv: Floats, cov: Floats, e: Floats, joint: Floats | None) -> Floats:
    """(2), mm² (F), of ends (2F, 3), one after the other, seen at uv (2F, C, 2)."""
    n, p = len(xyz), 15
    normal, noise, pull = np.zeros((n, 3, 3)), np.zeros((n, 3, 3)), np.zeros((n, 3, p * len(rig)))
    for c, camera in enumerate(rig):
        s = np.isfinite(uv[:, c, 0]) & np.isfinite(xyz[:, 0])
        J, T = point_jacobian(camera, xyz[s]), parameter_jacobian(camera, xyz[s])
        JtW = J.transpose(0, 2, 1) @ np.linalg.inv(cov[s, c] + T @ camera.cov @ T.transpose(0, 2, 1))
        normal[s] += JtW @ J
        noise[s] += JtW @ cov[s, c] @ JtW.transpose(0, 2, 1)
        pull[s, :, p * c : p * (c + 1)] = JtW @ T
    to_length = (np.repeat(e, 2, axis=0)[:, None] @ inverse3(normal))[:, 0]  # eᵀ N⁻¹  (2F, 3)
    by_noise = np.einsum("ni,nij,nj->n", to_length, noise, to_length).reshape(-1, 2).sum(1)
    b = np.einsum("ni,nip->np", to_length, pull).reshape(-1, 2, p * len(rig))
    b = b[:, 1] - b[:, 0]
    return by_noise + np.einsum("fp,pq,fq->f", b, joint_of(rig) if joint is None else joint, b)
