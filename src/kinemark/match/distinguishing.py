"""What tells markers apart between two cameras, beside the epipolar line (Swamidas 1997, 4.2.1 and 5.2).

Where two markers are in one epipolar plane the line tells nothing. "The use of color coded markers, different shape
markers, banks of markers … may enhance the tracking", and "the distance between markers as fixed lengths". A pair of
images (i, j) would be a marker in the place X_ij at the depths z_i, z_j of both cameras. Of that follow

    size         the radius of the marker by each image, R = √(area / π) z / f (1); of one marker both are alike
    brightness   the peak of each image, as a share of the usual one of its camera (2); of one marker both are alike
    banks        whether X_ij is a corner of a triangle X_ij, X_kl, X_mn of pairs without a common image that has the
                 three distances of a bank; of a segment, whether an X_kl is at its length (3)

and, with d the distance from the line, σ that of a right match, and s the spread of (1) and (2) of one marker,

    cost² = d² + σ² [ (ln R_i/R_j)² / s_R² + (ln p_i/p_j)² / s_p² + BANK² [not (3)] ]                 (4)

What an image does not say (no area, no peak) adds nothing. Places of pairs farther than `FAR` σ from their line count
for no triangle.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import Detections, Rig
from ..data.array_types import Bools, Floats, Ints
from ..geometry import to_camera, triangulate

BANK = 3.0
"""Standard deviations that a marker without its bank is worth in (4); chosen: so far off is no match."""

FAR = 6.0
"""Standard deviations from the line, above which a pair is no marker of a bank; chosen: generous, for speed alone."""


class Distinguishing(NamedTuple):
    """How markers are told apart: σ px, s_R and s_p of (4), None where not; distances (mm) of each bank, and how much a
    distance may be off, mm."""

    line_sd: float
    size_spread: float | None
    brightness_spread: float | None
    banks: tuple[tuple[float, ...], ...]
    bank_tolerance: float

    @property
    def asked(self) -> bool:
        """Whether anything is to tell markers apart."""
        return bool(self.size_spread or self.brightness_spread or self.banks)


def distinguished(
    distance: Floats,
    uv: tuple[Floats, Floats],
    rows: tuple[Ints, Ints],
    detections: Detections,
    rig: Rig,
    cameras: tuple[int, int],
    by: Distinguishing,
) -> Floats:
    """(n, m) px cost (4) of n images of the base with m of the other camera.

    Args:
        distance: (n, m) px d from the line. uv: (n, 2) and (m, 2) px, without lens. rows: of the detections, (n), (m).
        detections, rig: of all cameras. cameras: the two. by: what tells markers apart.
    """
    n, m = distance.shape
    if not (by.asked and n and m):
        return distance
    X = places(uv, rig, cameras)
    square = np.zeros((n, m))
    if by.size_spread:
        radii = [
            _radius(detections.area[own], X, rig, c, k) for k, (own, c) in enumerate(zip(rows, cameras, strict=True))
        ]
        square += np.nan_to_num(((radii[0] - radii[1]) / by.size_spread) ** 2)
    if by.brightness_spread:
        one, other = (_brightness(detections, own, c) for own, c in zip(rows, cameras, strict=True))
        square += np.nan_to_num(((one[:, None] - other) / by.brightness_spread) ** 2)
    if by.banks:
        square += BANK**2 * ~in_banks(X, distance <= FAR * by.line_sd, by.banks, by.bank_tolerance)
    return np.sqrt(distance**2 + by.line_sd**2 * square)  # (4)


def places(uv: tuple[Floats, Floats], rig: Rig, cameras: tuple[int, int]) -> Floats:
    """(n, m, 3) mm X_ij."""
    n, m = len(uv[0]), len(uv[1])
    both = np.stack([np.repeat(uv[0], m, 0), np.tile(uv[1], (n, 1))], 1)
    return triangulate(both, rig.P[list(cameras)]).reshape(n, m, 3)


def _radius(area: Floats, X: Floats, rig: Rig, camera: int, axis: int) -> Floats:
    """(n, m) ln R (1) by the images of one camera, whose rows run along an axis of X."""
    focal = np.sqrt(rig[camera].K[0, 0] * rig[camera].K[1, 1])
    depth = to_camera(rig[camera], X)[..., 2]
    own = np.expand_dims(np.log(np.maximum(area, 1e-9) / np.pi) / 2, 1 - axis)
    return np.asarray(own + np.log(np.maximum(depth, 1e-9) / focal))


def _brightness(detections: Detections, rows: Ints, camera: int) -> Floats:
    """(n) ln of (2)."""
    peak = detections.peak[detections.camera == camera]
    known = peak[np.isfinite(peak) & (peak > 0)]
    usual = float(np.median(known)) if len(known) else np.nan
    return np.asarray(np.log(np.maximum(detections.peak[rows], 1e-9) / usual))


def in_banks(X: Floats, near: Bools, banks: tuple[tuple[float, ...], ...], tolerance: float) -> Bools:
    """(n, m) whether (3) holds for places (n, m, 3) mm of pairs that may be (n, m)."""
    i, j = np.nonzero(near)
    apart = np.linalg.norm(X[i, j][:, None] - X[i, j], axis=-1)
    apart[(i[:, None] == i) | (j[:, None] == j)] = np.inf
    found = np.zeros(len(i), bool)
    for distances in banks:
        edges = [(np.abs(apart - d) <= tolerance).astype(float) for d in distances]
        if len(edges) == 1:
            found |= edges[0].any(1)
        else:
            for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # both ends of each side that has an opposite corner
                sides = edges[a] * (edges[b] @ edges[c])
                found |= (sides > 0).any(1) | (sides > 0).any(0)
    out = np.zeros(near.shape, bool)
    out[i, j] = found
    return out
