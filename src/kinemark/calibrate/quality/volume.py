"""The control volume as a grid of places: how exactly each is known, and what every camera contributes there.

At each place the covariance of `covariance` eq. 3 gives the standard deviation of one axis, σ = √(trace / 3) (1), and
that along the largest axis of the covariance, the root of the largest eigenvalue (2). Two rays that meet at the angle α
give a depth that is 1 / sin α as uncertain as a position across them, so the pair of rays nearest to a right angle,

    α = max over pairs of arccos |d_i · d_j|                             (3)

tells at once where the cameras stand too close together. Leaving out one camera at a time tells which ones the volume
rests on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...data import KinemarkError, Rig
from ...data.array_types import Bools, Floats, Ints
from ...geometry.common_view import common_view_centre, seen_by
from .predicted_covariance import covariance_from, joint_of, views

PLACES = 1000  # points of the volume that are looked at, about; chosen for speed
FEWEST_A_SIDE = 4  # of them along each axis; chosen (see studies/calibration_quality.py)

REACHES = np.geomspace(1, 1 / 64, 19)
"""Of a box nobody states, by the largest; chosen: the lens of longest reach fills its image with a person at 100 m."""

SEEN = 0.98
"""Share of a box nobody states that two cameras see; chosen: what is seen less is a finding about a stated volume."""


class VolumeMap(NamedTuple):
    """A control volume of X × Y × Z places.

    axes: (X), (Y), (Z) mm; seen: (X, Y, Z) how many cameras see the place; angle: (X, Y, Z) deg by (3);
    sd, sd_largest_axis: (X, Y, Z) mm by (1) and (2); without: (C, X, Y, Z) mm, (1) without that camera. NaN where fewer
    than two cameras see the place.
    """

    axes: tuple[Floats, Floats, Floats]
    seen: Ints
    angle: Floats
    sd: Floats
    sd_largest_axis: Floats
    without: Floats


def volume_grid(volume: ArrayLike, *, places: int = PLACES) -> tuple[Floats, Floats, Floats]:
    """Coordinates (X), (Y), (Z) mm of about so many places that fill a box (2, 3) mm evenly, its faces included.

    Raises:
        KinemarkError: the box is empty, turned inside out or not finite.
    """
    low, high = np.asarray(volume, np.float64)
    if not (np.isfinite(low).all() and np.isfinite(high).all() and (high > low).all()):
        raise KinemarkError(
            f"The control volume from {low.tolist()} to {high.tolist()} mm is empty. Set volume_mm in session.toml: "
            "the least corner first, then the greatest."
        )
    step = float(np.prod(high - low) / places) ** (1 / 3)
    counts = np.maximum(np.round((high - low) / step).astype(int) + 1, FEWEST_A_SIDE)
    x, y, z = (np.linspace(a, b, n) for a, b, n in zip(low, high, counts, strict=True))
    return x, y, z


def points_of(axes: tuple[Floats, Floats, Floats]) -> Floats:
    """(X · Y · Z, 3) mm the places of a grid, the last axis fastest."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)


def map_volume(
    rig: Rig, volume: ArrayLike, *, centroid_sd: float, joint: Floats | None = None, places: int = PLACES
) -> VolumeMap:
    """How exactly the rig places a marker in a box (2, 3) mm; arguments as in `quality.predicted_covariance`."""
    axes = volume_grid(volume, places=places)
    shape = (len(axes[0]), len(axes[1]), len(axes[2]))
    xyz = points_of(axes)
    said = views(rig, xyz, centroid_sd=centroid_sd)
    joint = joint_of(rig) if joint is None else joint
    cov = covariance_from(said, joint)
    without = [deviation(covariance_from(said, joint, without=(c,))).reshape(shape) for c in range(len(rig))]
    return VolumeMap(
        axes=axes,
        seen=said.seen.sum(0).reshape(shape),
        angle=ray_angle(rig, xyz, said.seen).reshape(shape),
        sd=deviation(cov).reshape(shape),
        sd_largest_axis=largest_axis_deviation(cov).reshape(shape),
        without=np.array(without).reshape(len(rig), *shape),
    )


def deviation(cov: Floats) -> Floats:
    """σ (…) mm of covariances (…, 3, 3) mm², by (1)."""
    return np.sqrt(np.trace(cov, axis1=-2, axis2=-1) / 3)


def largest_axis_deviation(cov: Floats) -> Floats:
    """Standard deviation (…) mm along the largest axis of covariances (…, 3, 3) mm², by (2)."""
    known = np.asarray(np.isfinite(cov).all((-2, -1)))
    largest = np.linalg.eigvalsh(np.where(known[..., None, None], cov, 0.0))[..., -1]
    return np.where(known, np.sqrt(np.maximum(largest, 0.0)), np.nan)


def ray_angle(rig: Rig, xyz: Floats, seen: Bools) -> Floats:
    """(N) deg by (3) at places (N, 3) mm that cameras see (C, N); NaN with fewer than two."""
    direction = xyz[None] - rig.centres[:, None]
    direction /= np.maximum(np.linalg.norm(direction, axis=-1, keepdims=True), 1e-9)
    together = np.abs(np.einsum("ani,bni->abn", direction, direction))
    together[~(seen[:, None] & seen[None])] = np.nan
    together[np.arange(len(rig)), np.arange(len(rig))] = np.nan
    least = np.nanmin(np.where(np.isnan(together), np.inf, together).reshape(-1, len(xyz)), axis=0)
    return np.where(np.isfinite(least), np.degrees(np.arccos(np.minimum(least, 1.0))), np.nan)


def view_volume(rig: Rig) -> Floats:
    """(2, 3) mm a box that at least two cameras look at, for a rig that states none: about `common_view_centre`.

    The box reaches from there a quarter of the median depth of the cameras to each side, or as far as two of them see
    it: a long lens sees much less of what is far away.

    Raises:
        KinemarkError: no two cameras have a place in common in their images.
    """
    centre = common_view_centre(rig)
    if centre is None:
        raise KinemarkError("No two cameras look at a common place. Set volume_mm in session.toml, or calibrate again.")
    depth = np.einsum("ci,ci->c", np.array([camera.R[2] for camera in rig]), centre - rig.centres)
    reach = float(np.median(depth[depth > 0])) / 4
    boxes = [np.stack([centre - r, centre + r]) for r in reach * REACHES]
    shares = ((seen_by(rig, points_of(volume_grid(box))) >= 2).mean() for box in boxes)
    return next((box for box, share in zip(boxes, shares, strict=True) if share >= SEEN), boxes[-1])
