"""Steps in which a path of a file leaves its companions: its distances from those that keep theirs change at once.

Where frames are few, a foot's own motion hides that two of its markers were exchanged; the body's shape does not. Of
the NEAR paths nearest to a path those COMPANIONS whose distance d_k changes least from frame to frame tell, by the
median of |d_k(f + 1) − d_k(f)|. A step is sudden where this is more than JUMP times what is usual there and JUMP_MM
besides noise, as of jumps (`paths`, (5)).
"""

from __future__ import annotations

import numpy as np
import scipy

from ...data.array_types import Floats, Ints
from ...data.progress import tell
from ...numerics.evenly import evenly
from ...numerics.row_quantiles import row_medians
from .carried import COMPANIONS, NEAR
from .paths import JUMP, JUMP_MM, RESTLESS, USUAL_STEPS, Paths

FEWEST, LOOKED_AT = 3, 200
"""Companions that tell, at least, and frames that say which paths are near; chosen, as in `carried`."""


def companion_steps(paths: Paths) -> list[Ints]:
    """Of each path, indices of the last samples before such steps, from one frame to the next; none of those that have
    images, of which tracking itself says where it was not sure."""
    if not paths.xyz.size or paths.images.any():
        return [np.zeros(0, np.int64) for _ in paths.frames]
    near = _nearest(paths)
    return [_sudden(paths, p, near[p]) for p in range(len(paths.frames))]


def _nearest(paths: Paths) -> Ints:
    """(M, ≤ NEAR) of each path, the nearest first; −1 where there is none."""
    frames = evenly(paths.xyz.shape[1], LOOKED_AT)
    xyz = paths.xyz[:, frames]
    far = np.array([row_medians(np.linalg.norm(xyz - own, axis=2)) for own in xyz])
    np.fill_diagonal(far, np.nan)
    order = np.argsort(far, axis=1, kind="stable")[:, :NEAR]
    return np.where(np.isfinite(np.take_along_axis(far, order, axis=1)), order, -1)


def _sudden(paths: Paths, p: int, near: Ints) -> Ints:
    tell(p, len(paths.frames))
    own, near = paths.frames[p], near[near >= 0]
    if len(own) < 3 or len(near) < FEWEST:
        return np.zeros(0, np.int64)
    change, step = _change(paths, p, near), np.diff(own) == 1
    least = JUMP * paths.sd[p] + JUMP_MM
    if not (step & (change > least)).any():  # so that what is usual is not asked for, which takes longest
        return np.zeros(0, np.int64)
    usual = scipy.ndimage.median_filter(np.nan_to_num(change), 2 * USUAL_STEPS + 1, mode="nearest")
    usual = np.minimum(usual, RESTLESS * np.nanmedian(change)) if np.isfinite(change).any() else usual
    return np.flatnonzero(step & (change > JUMP * (usual + paths.sd[p]) + JUMP_MM))


def _change(paths: Paths, p: int, near: Ints) -> Floats:
    """(N − 1) mm between samples of path p that follow each other, NaN where too few tell."""
    own = paths.frames[p]
    off = paths.xyz[near][:, own] - paths.xyz[p, own]
    change = np.abs(np.diff(np.sqrt(np.einsum("mfk,mfk->mf", off, off)), axis=1))
    steady = change[np.argsort(row_medians(change), kind="stable")[:COMPANIONS]]
    return np.where(np.isfinite(steady).sum(0) >= FEWEST, row_medians(steady.T), np.nan)
