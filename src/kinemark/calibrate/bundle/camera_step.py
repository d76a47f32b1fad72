"""Whether a camera was moved while it was calibrated: from some moment on the cameras do not fit each other as before.

Cameras c and d at C_c and C_d see a marker along u_c and u_d, and are off one plane, in px by Sampson's distance, by

    e = (b × u_d) · u_c / |∂[(b × u_d) · u_c] / ∂(pixels of both)|,    b ∝ C_d − C_c     (1)

To first order e goes with what is wrong in the parameters of both: the image's offset, rotation, focal length, two lens
terms and the centre, by the derivatives G of (1), taken where the pixels are corrected by e. A camera that was moved at
τ has an image that lies beside by δ px from then on, S being the columns of its offset in G, and 0 before τ:

    e = G θ + S δ + noise                                                (2)

θ takes up what the adjustment to all poses made of a move. With N_b = Σ GᵀG and g_b = Σ Gᵀe of blocks b of time, (2) is
solved for each camera and moment by them alone. With N = Σ N_b, S̃ = S − G N⁻¹ GᵀS and A = S̃ᵀS̃, δᵀAδ is by how much
the squares become less; what makes them least is what is taken, of moves with great z if there are any. Both of

    z₀² = δᵀAδ / 2 s²,    z² = (1 − 1 / m)² δᵀA (Σ_b s_b s_bᵀ)⁻¹ A δ / 2                 (3)

must be great: the one by the noise s of all e, the other by the blocks' scores s_b = Σ S̃ᵀ(e − Gθ − Sδ), as a lens term
that lacks makes neighbouring images wrong alike (White 1980); m is the lesser number of blocks before and after.

(2) holds for small moves. After a greater one the images may all have been left out (`images_beside`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ...data import Camera, Rig
from ...data.array_types import Bools, Floats, Ints
from ...geometry import lens
from ...geometry.camera import normalised
from ...numerics.vectors import homogeneous
from .images_beside import ImagesBeside, images_beside

BLOCKS, LEAST_BLOCKS = 24, 12
"""Blocks of time, and the least of them; chosen: in each, some seconds of waving, the wand crosses the images."""
SIDE = 2
"""Blocks before a move and after it at least; chosen: a tripod may be touched when somebody goes to switch off."""
FEWEST = 5
"""Frames a block with images of two cameras; chosen, as scores of fewer follow strays."""
SURE = 4.5
"""Of both z of (3); chosen: by steps above `LEAST_PX` z was up to 3.6 in three published runs of a waved LED (where z₀,
which knows no lens, was up to 9), and up to 3.2 in 45 simulated wands that nobody touched."""
LEAST_PX = 0.25
"""Length of δ; chosen: smaller steps are below what a calibration is off anyway."""
CLEAR = 1.1
"""By how much more than any other camera the one that is named makes the squares less; chosen."""
TRIMMED = 5.0
"""Medians of |e| in a block of two cameras, beyond which an image is another thing's; chosen."""
UNKNOWNS = 11
"""Of a camera in θ; by definition."""
FAINT = 1e-9
"""Of unknowns that nothing tells, added to N after scaling; chosen for rounding."""


class CameraStep(NamedTuple):
    """A moment from which on the cameras do not fit each other as before.

    Attributes:
        camera: the name of the camera whose move explains it best.
        alone: whether no other camera's move explains it nearly as well.
        frame: of F frames, from 0, the first of the block in which it happened.
        px: by how much its image lies beside afterwards.
        before, after: frames, a block to either side: up to `before` nothing was moved yet, from `after` on all was.
        kept: the images by which the camera was calibrated then: those "after" the move, "before" it, or "all".
    """

    camera: str
    alone: bool
    frame: int
    px: float
    before: int
    after: int
    kept: str = "all"

    def parted(self, names: Sequence[str], n_frames: int) -> Iterator[tuple[str, Bools]]:
        """`kept`, and the images (C, F) without those of the other side, of the camera that was moved, or of all where
        nobody knows which."""
        others, frame = [self.alone and name != self.camera for name in names], np.arange(n_frames)
        yield "after", np.array(others)[:, None] | (frame >= self.after)
        yield "before", np.array(others)[:, None] | (frame < self.before)


class _Sums(NamedTuple):
    """Of B blocks, over C cameras with P = 11 C unknowns: N (B, P, P), g (B, P); squares of all e (B), and how many;
    medians of |e| (C, C, B) px of two cameras."""

    N: Floats
    g: Floats
    squares: Floats
    images: Ints
    medians: Floats


class _Move(NamedTuple):
    """From block t on camera c is δ (2) px beside; gain δᵀAδ, and z of (3)."""

    c: int
    t: int
    delta: Floats
    gain: float
    z: float


def camera_step(rig: Rig, uv: Floats) -> CameraStep | None:
    """The camera that was moved while markers were waved about, or None where the cameras fit each other all the time.

    Args:
        rig: C cameras as they fit best to all frames, or to a part of them.
        uv: (C, F, K, 2) px; K markers in F frames in order of time, NaN where not seen.
    """
    frames = np.flatnonzero((np.isfinite(uv[..., 0]).sum(0) >= 2).any(1))
    n_blocks = min(BLOCKS, len(frames) // FEWEST)
    if n_blocks < LEAST_BLOCKS:
        return None
    sums = _sums(rig, uv[:, frames], n_blocks)
    move = _small(sums, len(rig)) or images_beside(sums.medians, side=SIDE)
    if move is None or move.px < LEAST_PX:
        return None
    before, frame, after = (int(frames[-(-t * len(frames) // n_blocks)]) for t in (move.t - 1, move.t, move.t + 1))
    return CameraStep(rig.names[move.c], move.alone, frame, move.px, before, after)


def _small(sums: _Sums, cameras: int) -> ImagesBeside | None:
    """The move by (2) and (3), or None; of those that are sure by the blocks, the one that makes the squares least."""
    moves = [_greatest(sums, c) for c in range(cameras)]
    best, second = sorted(moves, key=lambda move: (-(move.z >= SURE), -move.gain))[:2]
    noise = (sums.squares.sum() - best.gain) / max(sums.images.sum(), 1)
    if best.z < SURE or best.gain < 2 * SURE**2 * noise:  # (3)
        return None
    alone = cameras > 2 and best.gain > CLEAR * second.gain
    return ImagesBeside(best.c, best.t, float(np.linalg.norm(best.delta)), alone)


def _sums(rig: Rig, uv: Floats, B: int) -> _Sums:
    P, n_frames = UNKNOWNS * len(rig), uv.shape[1]
    N, g, squares, count = np.zeros((B, P, P)), np.zeros((B, P)), np.zeros(B), np.zeros(B, np.int64)
    medians = np.full((len(rig), len(rig), B), np.nan)
    xy = [lens.undistort(normalised(camera, uv[c]), camera.distortion) for c, camera in enumerate(rig)]
    block = np.broadcast_to(((np.arange(n_frames) * B) // n_frames)[:, None], uv.shape[1:3])
    for c, d in combinations(range(len(rig)), 2):
        both = np.isfinite(xy[c][..., 0]) & np.isfinite(xy[d][..., 0])
        if not both.any():
            continue
        e, G = _epipolar(rig[c], rig[d], xy[c][both], xy[d][both])
        at = np.concatenate([_own(c), _own(d)])
        for b, kept in _blocks(e, block[both]):
            N[b][np.ix_(at, at)] += G[kept].T @ G[kept]
            g[b][at] += G[kept].T @ e[kept]
            squares[b], count[b] = squares[b] + e[kept] @ e[kept], count[b] + len(kept)
            own = np.abs(e[block[both] == b])
            medians[c, d, b] = medians[d, c, b] = np.median(own) if len(own) >= FEWEST else np.nan
    return _Sums(N, g, squares, count, medians)


def _own(c: int) -> Ints:
    return np.arange(UNKNOWNS * c, UNKNOWNS * (c + 1))


def _blocks(e: Floats, block: Ints) -> list[tuple[int, Ints]]:
    """Of each block those e (n) px that are not far beyond its median."""
    rows = [(int(b), np.flatnonzero(block == b)) for b in np.unique(block)]
    return [(b, at[np.abs(e[at]) <= TRIMMED * np.median(np.abs(e[at]))]) for b, at in rows]


def _epipolar(c: Camera, d: Camera, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """e (n) px of (1), and G (n, 22), of markers at x and y (n, 2) of the normalised image planes."""
    baseline = (d.centre - c.centre) / np.linalg.norm(d.centre - c.centre)
    fc, fd = np.diag(c.K)[:2], np.diag(d.K)[:2]
    off, gc, gd, _ = _coplanarity(c, d, baseline, x, y)
    size = _size(gc[:, :2] / fc, gd[:, :2] / fd)
    e = off / size
    x = x - (e / size)[:, None] * gc[:, :2] / fc**2
    y = y - (e / size)[:, None] * gd[:, :2] / fd**2
    _, gc, gd, apart = _coplanarity(c, d, baseline, x, y)
    size = _size(gc[:, :2] / fc, gd[:, :2] / fd)
    G = np.hstack([_derivatives(x, gc, fc), -apart, _derivatives(y, gd, fd), apart])
    return e, G / size[:, None]


def _coplanarity(c: Camera, d: Camera, b: Floats, x: Floats, y: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """(b × u_d) · u_c (n), and its gradients (n, 3) by x and by y, homogeneous, and by b, across b."""
    u, v = homogeneous(x) @ c.R, homogeneous(y) @ d.R
    by_u, by_b = np.cross(b, v), np.cross(v, u)
    return (u * by_u).sum(1), by_u @ c.R.T, np.cross(u, b) @ d.R.T, by_b - (by_b @ b)[:, None] * b


def _size(c: Floats, d: Floats) -> Floats:
    """The denominator of (1); where both rays run along the baseline it is not let to 0."""
    size = np.sqrt((c**2).sum(1) + (d**2).sum(1))
    return np.maximum(size, 1e-3 * np.median(size))


def _derivatives(x: Floats, by_x: Floats, f: Floats) -> Floats:
    """(n, 8) by the image's offset, px, rotation, focal length and two lens terms, from those by x, homogeneous."""
    r2, along = (x**2).sum(1), (by_x[:, :2] * x).sum(1)
    return np.column_stack([by_x[:, :2] / f, np.cross(homogeneous(x), by_x), along, along * r2, along * r2**2])


def _greatest(sums: _Sums, c: int) -> _Move:
    """The moment at which a move of camera c makes the squares least."""
    total = sums.N.sum(0)
    scale = np.sqrt(np.maximum(np.diag(total), FAINT))
    inverse = np.linalg.inv(total / scale[:, None] / scale + FAINT * np.eye(len(total))) / scale[:, None] / scale
    moves = (_move(sums, inverse, c, t) for t in range(SIDE, len(sums.N) - SIDE + 1))
    return max(moves, key=lambda move: (move.z >= SURE, move.gain))


def _move(sums: _Sums, inverse: Floats, c: int, t: int) -> _Move:
    """(2) and (3) for camera c and block t."""
    own, after = _own(c)[:2], np.arange(len(sums.N)) >= t
    N_S = sums.N[after][:, :, own].sum(0)
    projected = inverse @ N_S
    A = N_S[own] - N_S.T @ projected
    A = A + FAINT * max(np.trace(A), FAINT) * np.eye(2)
    total = sums.g.sum(0)
    delta = np.linalg.solve(A, sums.g[after][:, own].sum(0) - projected.T @ total)
    scores = _scores(sums, inverse @ (total - N_S @ delta), delta, own, after, projected)
    m = min(t, len(sums.N) - t)
    spread = scores.T @ scores * (m / (m - 1)) ** 2
    z2 = A @ delta @ np.linalg.pinv(spread) @ A @ delta / 2  # (3)
    return _Move(c, t, delta, float(delta @ A @ delta), float(np.sqrt(max(z2, 0.0))))


def _scores(sums: _Sums, theta: Floats, delta: Floats, own: Ints, after: Bools, projected: Floats) -> Floats:
    """s_b (B, 2) of (3)."""
    left = sums.g - sums.N @ theta - after[:, None] * (sums.N[:, :, own] @ delta)
    return np.asarray(after[:, None] * left[:, own] - left @ projected)
