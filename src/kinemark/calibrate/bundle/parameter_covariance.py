"""The covariance of all cameras' parameters after a bundle adjustment.

S = U − W V⁻¹ Wᵀ of `numerics.schur` (2) is the normal matrix of the cameras' parameters alone, so that their
covariance is S⁻¹ times the variance factor

    χ² / ν · ν / (ν − 2),   ν = equations − unknowns + g                 (1)

as in `resection`. Where nothing ties the world down, S has g = 6 null vectors, or 7 where nothing has a length: a
turn ω, a shift τ and a growth σ of the whole world change no image. They move a point by ω × X + τ + σ X and a
camera by

    r → r − R ω,    t → t − R τ + σ t                                    (2)

Such motions of the world are combined to G so that nothing held moves (3). S + G Gᵀ can be inverted, and gives the
covariance in one of many frames. It is carried to the frame in which the points rest as a whole (Baarda 1973;
S-transformation): with B the points' part of G, and H = Bᵀ dX,

    δ' = δ − G (BᵀB)⁻¹ H                                                  (4)

where dX = J ε, ε = V⁻¹ (h − Wᵀ δ), and V⁻¹ h is not correlated with δ. Errors in it are those that remain when the
calibrated and the true points are laid upon each other.
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Bools, Floats
from ...numerics.schur import BlockEquations, block_inverses, schur_complement
from ...numerics.vectors import cross_matrix
from .parts import Sticks, slices
from .solver import BundleState, Freedom


def joint_covariance(
    state: BundleState, normal: BlockEquations, freedoms: tuple[Freedom, ...], used: Bools
) -> tuple[Floats, int]:
    """(15 C, 15 C) before the factor (1), and g; `used` (N) are the points that a camera sees."""
    T = _block_columns(state, freedoms)
    motions = allowed_motions(state, freedoms, used)
    inverses = [block_inverses(V) for V in normal.V]
    S, _ = schur_complement(normal, inverses)
    G = _camera_motions(state, _centre(state, used)) @ motions
    scale = 1 / np.sqrt(np.maximum(np.diag(normal.U), 1e-300))  # the parameters differ by 10⁸ in size
    null = np.linalg.qr(np.linalg.pinv(T) @ G / scale[:, None])[0]
    M = S * scale * scale[:, None] + null @ null.T
    cov = T @ (scale[:, None] * np.linalg.pinv(M, rcond=1e-15, hermitian=True) * scale) @ T.T
    if motions.shape[1] == 0:
        return (cov + cov.T) / 2, 0
    follow, noise, BtB = _points_follow(state, normal, inverses, motions, used)
    lift = G @ np.linalg.inv(BtB)
    lift[~np.abs(T).any(1)] = 0.0  # by (3) but for rounding
    S_transform = np.eye(len(T)) - lift @ follow @ np.linalg.pinv(T)  # (4)
    cov = S_transform @ cov @ S_transform.T + lift @ noise @ lift.T
    return (cov + cov.T) / 2, motions.shape[1]


def allowed_motions(state: BundleState, freedoms: tuple[Freedom, ...], used: Bools) -> Floats:
    """(7, g) combinations of turn, shift and growth (σ in units of the points' spread) that move nothing held: (3)."""
    centre = _centre(state, used)
    held = np.concatenate([~f.free[9:15] for f in freedoms])
    pose = np.concatenate([np.arange(15 * c + 9, 15 * c + 15) for c in range(len(freedoms))])
    rows = [_camera_motions(state, centre)[pose[held]]]
    for part, at in zip(state.parts, slices(state.parts), strict=True):
        if isinstance(part, Sticks) and used[at].any():
            rows.append(np.eye(7)[6:])
        if part.known and used[at].any():
            rows.append(_point_motions(part.xyz[used[at].reshape(part.xyz.shape[:2]).any(1)], centre).reshape(-1, 7))
    fixed = np.concatenate(rows)
    size = np.linalg.norm(fixed, axis=0)
    size = np.where(size > 0, size, 1.0)
    _, s, Vt = np.linalg.svd(fixed / size, full_matrices=True)
    rank = int((s > 1e-9 * max(s[0], 1e-300)).sum()) if len(s) else 0
    return np.asarray(Vt[rank:].T / size[:, None])


def _centre(state: BundleState, used: Bools) -> Floats:
    """(4,) the points' mean place and spread, about which the world turns and grows."""
    xyz = np.concatenate([part.xyz.reshape(-1, 3) for part in state.parts])[used]
    return np.append(xyz.mean(0), np.sqrt(xyz.var(0).sum()) or 1.0)


def _camera_motions(state: BundleState, centre: Floats) -> Floats:
    """(15 C, 7) of (2), turning and growing about the points' centre."""
    G = np.zeros((len(state.cameras), 15, 7))
    for g, camera in zip(G, state.cameras, strict=True):
        at = camera.R @ centre[:3]
        g[9:12, :3] = -camera.R
        g[12:15, :3] = -camera.R @ cross_matrix(centre[:3])  # turning about the centre m: τ = −ω × m
        g[12:15, 3:6] = -camera.R
        g[12:15, 6] = (camera.t + at) / centre[3]
    return G.reshape(-1, 7)


def _point_motions(xyz: Floats, centre: Floats) -> Floats:
    """(…, 3, 7) of points (…, 3)."""
    offset = xyz - centre[:3]
    eye = np.broadcast_to(np.eye(3), (*xyz.shape, 3))
    return np.concatenate([-cross_matrix(offset), eye, offset[..., None] / centre[3]], -1)


def _points_follow(
    state: BundleState, normal: BlockEquations, inverses: list[Floats], motions: Floats, used: Bools
) -> tuple[Floats, Floats, Floats]:
    """d H / d δ (g, Q), the covariance of H that does not come from δ (g, g), and BᵀB (g, g)."""
    centre, g = _centre(state, used), motions.shape[1]
    follow, noise, BtB = np.zeros((g, len(normal.g))), np.zeros((g, g)), np.zeros((g, g))
    for part, at, inverse, W in zip(state.parts, slices(state.parts), inverses, normal.W, strict=True):
        there = used[at].reshape(part.xyz.shape[:2])
        B = np.where(there[..., None, None], _point_motions(np.nan_to_num(part.xyz), centre) @ motions, 0.0)
        tangents = np.where(there[..., None, None], part.tangents(), 0.0)
        by_body = np.einsum("nkxg,nkxd->ngd", B, tangents)
        follow -= np.einsum("ngd,ndq->gq", by_body @ inverse, W)
        noise += np.einsum("ngd,nhd->gh", by_body @ inverse, by_body)
        BtB += np.einsum("nkxg,nkxh->gh", B, B)
    return follow, noise, BtB


def _block_columns(state: BundleState, freedoms: tuple[Freedom, ...]) -> Floats:
    """T of all cameras together (15 C, Q)."""
    columns = [freedom.columns(camera) for freedom, camera in zip(freedoms, state.cameras, strict=True)]
    T = np.zeros((15 * len(columns), sum(t.shape[1] for t in columns)))
    at = 0
    for c, t in enumerate(columns):
        T[15 * c : 15 * c + 15, at : at + t.shape[1]] = t
        at += t.shape[1]
    return T
