"""Single rays: what one camera saw of a marker while the others lost it.

Two cameras are needed for a point, but where a filler says that a marker is at x with covariance P, one image tells the
two directions across its ray. An image z of covariance R that no track has is the marker's own when, with u and J the
projection of x and its derivative,

    S = J P Jᵀ + R,   d² = (z − u)ᵀ S⁻¹ (z − u) < GATE                     (1)

is true of it and of no other free image, and when chance would hardly put one there: with b free images per px² of the
camera, π GATE √|S| b < CHANCE (2). Images that count update the position camera after camera,

    x ← x + P Jᵀ S⁻¹ (z − u),   P ← P − P Jᵀ S⁻¹ J P                       (3)

(Kalman 1960). What a filler is wrong by lasts for many frames, so one image alone may be another marker's; images count
only in runs of LEAST frames that the same camera has them, one after the other (4).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import Camera, Detections, Rig, Tracks
from ..data.array_types import Bools, Floats, Ints
from ..data.trajectories import camera_bits
from ..geometry import point_jacobian, project
from ..numerics.runs import true_runs

GATE = 9.21
"""99 % of χ² with two degrees of freedom; chosen (see benchmarks/gaps.py)."""
CHANCE = 0.05  # images expected by chance within the gate; chosen, a usual level (see benchmarks/gaps.py)
LEAST = 3  # frames in a row; chosen, as chance does not last (see benchmarks/gaps.py)
USUAL_SD = 0.3
"""px, of images that state no noise; chosen (see benchmarks/gaps.py)."""


class Rays(NamedTuple):
    """What cameras saw: rig and detections of the trial's own frames, and which of these (D) no track has."""

    rig: Rig
    detections: Detections
    free: Bools

    @classmethod
    def left_by(cls, tracks: Tracks, detections: Detections, rig: Rig) -> Rays:
        """The images that tracks left over."""
        free = detections.valid.copy()
        used = tracks.cloud.detection[tracks.id >= 0]
        free[used[used >= 0]] = False
        return cls(rig, detections, free)


class RefinedByRays(NamedTuple):
    """Positions (L, 3) mm, covariances (L, 3, 3) mm², and detections (L, C) of cameras that saw it alone, −1: none."""

    xyz: Floats
    cov: Floats
    detection: Ints

    @property
    def cameras(self) -> NDArray[np.uint32]:
        """(L) which cameras contributed to each, as bits."""
        return camera_bits(self.detection)


class _RayImages(NamedTuple):
    """Of one camera and L frames: index of the image that fits, −1: none; its innovation (L, 2) px; J and S of (1)."""

    detection: Ints
    innovation: Floats
    J: Floats
    S: Floats


def sharpened(xyz: Floats, cov: Floats, start: int, rays: Rays) -> RefinedByRays:
    """A fill of L frames from `start` on, with what single cameras saw in them.

    Args:
        xyz: (L, 3) mm, NaN where nothing is known; cov: (L, 3, 3) mm².
        start: frame of the recording, from 0.
        rays: what the cameras saw.
    """
    xyz, cov = xyz.copy(), cov.copy()
    detection = np.full((len(xyz), len(rays.rig)), -1, np.int64)
    for c, camera in enumerate(rays.rig):
        found = _fitting(camera, c, xyz, cov, start, rays)
        rows = np.flatnonzero(found.detection >= 0)
        if not len(rows):
            continue
        J, P = found.J[rows], cov[rows]
        gain = P @ J.transpose(0, 2, 1) @ np.linalg.inv(found.S[rows])
        xyz[rows] += (gain @ found.innovation[rows, :, None])[..., 0]  # (3)
        P = P - gain @ J @ P
        cov[rows] = (P + P.transpose(0, 2, 1)) / 2
        detection[rows, c] = found.detection[rows]
    return RefinedByRays(xyz, cov, detection)


def _fitting(camera: Camera, c: int, xyz: Floats, cov: Floats, start: int, rays: Rays) -> _RayImages:
    """The images of a camera that count."""
    seen = rays.detections
    n = len(xyz)
    detection, innovation = np.full(n, -1), np.full((n, 2), np.nan)
    known = np.asarray(np.isfinite(xyz).all(1) & np.isfinite(cov).all((1, 2)))
    safe = np.where(known[:, None], xyz, camera.centre + camera.R[2] * 1000)
    uv, J = project(camera, safe), point_jacobian(camera, safe)
    JPJ = J @ np.where(known[:, None, None], cov, 0.0) @ J.transpose(0, 2, 1)
    S = JPJ + np.eye(2) * USUAL_SD**2
    in_front: Bools = (safe @ camera.R[2] + camera.t[2]) > 0
    own = rays.free[seen.camera == c]
    density = own.sum() / max(seen.n_frames, 1) / max(float(np.prod(camera.size)), 1.0)
    sure = np.pi * GATE * np.sqrt(np.linalg.det(S)) * density < CHANCE  # (2)
    looked: Bools = known & in_front & sure & (start + np.arange(n) < seen.n_frames)
    for i in np.flatnonzero(looked).tolist():
        first, stop, _ = seen.rows(c, start + i).indices(len(seen))
        rows = first + np.flatnonzero(rays.free[first:stop])
        noise = np.where(np.isfinite(seen.cov[rows]), seen.cov[rows], np.eye(2) * USUAL_SD**2)
        difference = seen.uv[rows] - uv[i]
        squared = (difference * np.linalg.solve(JPJ[i] + noise, difference[..., None])[..., 0]).sum(1)
        near = np.flatnonzero(squared < GATE)  # (1)
        if len(near) == 1:
            detection[i], innovation[i], S[i] = rows[near[0]], difference[near[0]], JPJ[i] + noise[near[0]]
    detection[~_lasting(detection >= 0)] = -1
    return _RayImages(detection, innovation, J, S)


def _lasting(found: Bools) -> Bools:
    """Which (L) lie in runs of LEAST and more (4); a gap shorter than that has all of its frames for a run."""
    out = np.zeros(len(found), bool)
    for first, stop in true_runs(found):
        out[first:stop] = stop - first >= min(LEAST, len(found))
    return out
