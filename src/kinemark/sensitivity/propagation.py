"""From the errors of centroids to those of points, joint angles and means over cycles, to first order.

Errors are of two kinds. Those of a centroid differ from frame to frame and marker to marker; those of a calibration, or
of where a marker was put on the skin, are the same in all frames, and all markers share those of the calibration. So a
quantity y (a coordinate, an angle) in frame f is off by

    δy_f = n_f + S_f η                                                   (1)

with n_f independent of other frames, of covariance N_f, and η the shared errors, of covariance Σ. Then

    cov y_f = N_f + S_f Σ S_fᵀ                                           (2)

**Points.** For cameras of a rig, N and S are those of `calibrate.quality.covariance` eq. 2 (3).

**Angles.** With F = d angle / d marker (by central differences, as any kinematics is a function of positions),

    N = Σ_m F_m N_m F_mᵀ,     S = Σ_m F_m S_m                            (4)

The sum in S is one of vectors: a calibration that shifts all markers alike turns nothing.

**Placement.** A marker that was put d away from its landmark is off by d in every frame: S_m = 1, η = d (5), taken as
fixed in the laboratory's axes. The covariance of one frame is the same as if it were fixed to the limb, since d points
anywhere; and so is that of a mean over cycles, where frames of one phase have the limb in one pose.

**Means.** The mean over cycles at P phases is y̅ = W y (6), W (P, F) having in each row the weights of frames, so that

    cov y̅_p = Σ_f W_pf² N_f + (Σ_f W_pf S_f) Σ (Σ_f W_pf S_f)ᵀ           (7)

The first part falls as one over the number of cycles. The second does not fall at all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..calibrate.quality import joint_of, views
from ..data import Rig
from ..data.array_types import Floats
from ..numerics.small_matrices import inverse3

Kinematics = Callable[[Floats], Floats]
"""Angles (F, A) deg of markers (M, F, 3) mm."""

STEP_MM = 0.05  # mm of a numerical derivative; chosen between rounding and curvature


class Spread(NamedTuple):
    """Errors of (1) for quantities of any shape (…), each of d components.

    own: (…, d, d) N, independent from frame to frame; by: (…, d, K) S; shared: (K, K) Σ.
    """

    own: Floats
    by: Floats
    shared: Floats

    @property
    def cov(self) -> Floats:
        """(…, d, d) by (2)."""
        return self.own + self.common

    @property
    def common(self) -> Floats:
        """(…, d, d) the part that is the same in all frames."""
        return self.by @ self.shared @ self.by.swapaxes(-1, -2)


def rig_points(rig: Rig, xyz: Floats, *, centroid_sd: float, joint: Floats | None = None) -> Spread:
    """Markers (M, F, 3) mm reconstructed by least squares from all cameras that have them in their images.

    Args:
        rig: cameras with the covariance of their calibration.
        xyz: (M, F, 3) mm; what is NaN, or seen by fewer than two cameras, gives NaN.
        centroid_sd: of a centroid along u and along v, px.
        joint: (15 C, 15 C) as in `predicted_covariance`.

    Raises:
        ValueError: the standard deviation is not positive.
    """
    if not centroid_sd > 0:
        raise ValueError(f"centroid_sd is {centroid_sd} px, wanted more than 0")
    joint = joint_of(rig) if joint is None else joint
    flat = xyz.reshape(-1, 3)
    known = np.isfinite(flat).all(1)
    own, by = np.full((len(flat), 3, 3), np.nan), np.full((len(flat), 3, len(joint)), np.nan)
    said = views(rig, flat[known], centroid_sd=centroid_sd)
    inverse = np.where((said.seen.sum(0) >= 2)[:, None, None], inverse3(said.information.sum(0)), np.nan)
    own[known] = inverse @ said.noise.sum(0) @ inverse
    by[known] = -inverse @ said.pull.transpose(1, 2, 0, 3).reshape(-1, 3, len(joint))
    return Spread(own.reshape(*xyz.shape, 3), by.reshape(*xyz.shape, -1), joint)


def placed_points(shape: Sequence[int], *, placement_sd: float) -> Spread:
    """Errors (5) of where M markers of F frames, `shape` (M, F), were put on, mm along each axis."""
    M, F = shape
    by = np.zeros((M, F, 3, 3 * M))
    for m in range(M):
        by[m, :, :, 3 * m : 3 * m + 3] = np.eye(3)
    return Spread(np.zeros((M, F, 3, 3)), by, placement_sd**2 * np.eye(3 * M))


def angle_jacobian(angles: Kinematics, xyz: Floats, *, step: float = STEP_MM) -> Floats:
    """d angle / d marker (F, A, M, 3), deg/mm, of markers (M, F, 3) mm, by central differences.

    Jumps of a whole turn between both sides are taken out.
    """
    out = np.empty((xyz.shape[1], angles(xyz).shape[1], len(xyz), 3))
    for m in range(len(xyz)):
        for axis in range(3):
            shift = np.zeros((len(xyz), 1, 3))
            shift[m, 0, axis] = step
            there = angles(xyz + shift) - angles(xyz - shift)
            out[:, :, m, axis] = ((there + 180) % 360 - 180) / (2 * step)
    return out


def angle_spread(points: Spread, jacobian: Floats) -> Spread:
    """Errors (F, A, …) of angles, each by itself (d = 1), from those of markers (M, F) and J (F, A, M, 3), by (4)."""
    own = np.einsum("fami,mfij,famj->fa", jacobian, points.own, jacobian, optimize=True)
    by = np.einsum("fami,mfik->fak", jacobian, points.by, optimize=True)
    return Spread(own[..., None, None], by[:, :, None], points.shared)


def mean_spread(each: Spread, weights: Floats) -> Spread:
    """Errors (P, …) of weighted means (6) over frames, the first axis (F, …) of `each`, by (7)."""
    return Spread(np.tensordot(weights**2, each.own, 1), np.tensordot(weights, each.by, 1), each.shared)


def cycle_weights(starts: Sequence[float], n_frames: int, *, points: int = 101) -> Floats:
    """W (P, F) of (6): each cycle from one start to the next cut into P points, by linear interpolation, and averaged.

    Args:
        starts: (n + 1) frames, counted from 0 and not necessarily whole, where cycles begin; the last ends the last.
        n_frames: F.
        points: P.

    Raises:
        ValueError: fewer than two starts, or starts that do not grow or lie outside the recording.
    """
    at = np.asarray(starts, np.float64)
    if len(at) < 2 or (np.diff(at) <= 0).any() or at[0] < 0 or at[-1] > n_frames - 1 or points < 2:
        raise ValueError(f"starts are {list(starts)}, wanted two or more that grow, within 0 … {n_frames - 1}")
    W = np.zeros((points, n_frames))
    for a, b in pairwise(at):
        where = np.linspace(a, b, points)
        low = np.minimum(where.astype(np.int64), n_frames - 2)
        share = where - low
        np.add.at(W, (np.arange(points), low), (1 - share) / (len(at) - 1))
        np.add.at(W, (np.arange(points), low + 1), share / (len(at) - 1))
    return W
