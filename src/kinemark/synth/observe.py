"""Exact ground truth of what cameras see, and quick observations without images.

`truth` projects every marker's centre into every camera and says how much of it limbs leave in sight.
`observe` makes detections from that, with the faults that real images have: noise, images that run together, points
that come from nowhere, markers hidden or dropped. It knows which marker each detection is, so that matching and
tracking can be judged. Noise is about the projected centre; a sphere's image has its centre a few thousandths of a
pixel farther out (`sphere_image`, equation 3), which images made by `render` do show.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from ..data import Camera, Detections, Rig
from ..data.array_types import Bools, Floats, Ints
from ..geometry import project, to_camera
from ..numerics.runs import equal_runs
from .occlusion import visible_fraction
from .render import one_to_one
from .sphere_image import sphere_ellipse
from .subjects import Subject


class Sight(NamedTuple):
    """What C cameras see of M markers over F frames.

    uv (C, M, F, 2) px are the true projections of the centres, distortion in; visible (C, M, F) is how much of each
    marker is in sight, 0 where it is outside the image, behind the camera, hidden or not there; area (C, M, F) px² is
    that of its whole image.
    """

    uv: Floats
    visible: Floats
    area: Floats


@dataclass(frozen=True, slots=True, eq=False)
class ObservedImages:
    """Detections and what they are.

    Attributes:
        detections: D rows.
        marker: (D) index of the subject's marker, the one in front where several ran together; −1 for false points.
        merged: (D) how many markers ran together in the row; 0 for false points.
        sight: the exact truth they were made from.
    """

    detections: Detections
    marker: Ints
    merged: Ints
    sight: Sight

    @property
    def unmerged_views(self) -> Ints:
        """(M, F) cameras that have an image of the marker alone, not run together with others."""
        own = (self.marker >= 0) & (self.merged == 1)
        views = np.zeros(self.sight.uv.shape[1:3], np.int64)
        np.add.at(views, (self.marker[own], self.detections.frame[own]), 1)
        return views


class TruthRows(NamedTuple):
    """Marker images of one camera, before they are put in order; all (N) but uv (N, 2)."""

    frame: Ints
    marker: Ints
    merged: Ints
    uv: Floats
    area: Floats


def truth(rig: Rig, subject: Subject) -> Sight:
    """Where every camera of the rig has every marker in every frame, and whether it sees it."""
    sights = [_sight(camera, subject) for camera in rig]
    return Sight(*(np.array(part) for part in zip(*sights, strict=True)))


def _sight(camera: Camera, subject: Subject) -> Sight:
    limbs = subject.capsules
    with np.errstate(invalid="ignore"):
        uv = project(camera, subject.xyz)
        inside = ((uv >= -0.5) & (uv <= camera.size - 0.5)).all(-1) & one_to_one(camera, subject.xyz)
    area = sphere_ellipse(camera, subject.xyz, subject.radius_mm[:, None]).area
    free = visible_fraction(camera.centre, subject.xyz, subject.radius_mm, limbs.a, limbs.b, limbs.radius)
    return Sight(uv, np.where(inside & np.isfinite(area), np.nan_to_num(free), 0.0), area)


def observe(
    rig: Rig,
    subject: Subject,
    *,
    noise_px: float = 0.1,
    false_per_frame: float = 0.0,
    merge_px: float = 0.0,
    dropout: float = 0.0,
    least_visible: float = 0.5,
    seed: int = 0,
) -> ObservedImages:
    """Detections of a subject in a rig, made without images.

    Args:
        rig: the cameras.
        subject: what they see.
        noise_px: standard deviation of each coordinate, px; also noted as the detections' covariance.
        false_per_frame: mean number of points from nowhere in each camera and frame (Poisson, even over the image).
        merge_px: images whose centres are nearer than this run together, in chains too, at the mean weighted by area.
        dropout: chance that a visible marker is not detected in a camera and frame.
        least_visible: share of a marker that must be in sight.
        seed: of all chance; the same seed gives the same detections.

    Raises:
        ValueError: a parameter is out of range.
    """
    if min(noise_px, false_per_frame, merge_px) < 0 or not 0 <= dropout <= 1:
        raise ValueError("noise_px, false_per_frame and merge_px must not be negative and dropout be within 0 to 1")
    sight = truth(rig, subject)
    rng = np.random.default_rng(seed)
    cameras = []
    for c, camera in enumerate(rig):
        seen = (sight.visible[c] >= max(least_visible, 1e-9)) & (rng.random(sight.visible[c].shape) >= dropout)
        depth = to_camera(camera, subject.xyz)[..., 2]
        rows = _merge(_seen_rows(seen, sight, c), depth, merge_px)
        rows = rows._replace(uv=rows.uv + rng.normal(0.0, noise_px, rows.uv.shape))
        cameras.append(_shuffle(_add_false(rows, camera, subject.n_frames, false_per_frame, rng), rng))
    return _collect(rig, subject, cameras, noise_px, sight)


def _seen_rows(seen: Bools, sight: Sight, c: int) -> TruthRows:
    marker, frame = np.nonzero(seen)
    uv, area = sight.uv[c, marker, frame], sight.area[c, marker, frame] * sight.visible[c, marker, frame]
    return TruthRows(frame, marker, np.ones_like(frame), uv, area)


def _merge(rows: TruthRows, depth: Floats, merge_px: float) -> TruthRows:
    """Images of one frame nearer than merge_px, and chains of such, as one; it is called after the marker in front."""
    n = len(rows.frame)
    order = np.lexsort((depth[rows.marker, rows.frame], rows.frame))
    rows = _take(rows, order)
    first, second = _near_pairs(rows, merge_px)
    blobs, blob = scipy.sparse.csgraph.connected_components(
        scipy.sparse.coo_array((np.ones(len(first)), (first, second)), shape=(n, n)), directed=False
    )
    if blobs == n:
        return rows
    nearest = np.unique(blob, return_index=True)[1]  # rows are in order of depth within their frame
    area = np.bincount(blob, rows.area).astype(np.float64)
    uv = np.stack([np.bincount(blob, rows.area * rows.uv[:, i]) for i in range(2)], -1) / area[:, None]
    return TruthRows(rows.frame[nearest], rows.marker[nearest], np.bincount(blob).astype(np.int64), uv, area)


def _near_pairs(rows: TruthRows, merge_px: float) -> tuple[Ints, Ints]:
    """Indices of rows of one frame whose centres are nearer than merge_px; rows are in order of frame."""
    found: list[Ints] = [np.zeros((2, 0), np.int64)]
    for part in np.split(np.arange(len(rows.frame)), equal_runs(rows.frame)[1:-1]):
        if merge_px > 0 and len(part) > 1:
            apart = np.linalg.norm(rows.uv[part, None] - rows.uv[part], axis=-1)
            found.append(part[np.array(np.nonzero(np.triu(apart < merge_px, 1)))])
    first, second = np.concatenate(found, 1)
    return first, second


def _add_false(rows: TruthRows, camera: Camera, n_frames: int, per_frame: float, rng: np.random.Generator) -> TruthRows:
    """Points from nowhere, of the sizes that true ones have."""
    frame = np.repeat(np.arange(n_frames), rng.poisson(per_frame, n_frames))
    n = len(frame)
    uv = rng.uniform(-0.5, camera.size - 0.5, (n, 2))
    area = rng.choice(rows.area, n) if len(rows.area) else np.full(n, 20.0)
    return TruthRows(
        np.concatenate([rows.frame, frame]),
        np.concatenate([rows.marker, np.full(n, -1)]),
        np.concatenate([rows.merged, np.zeros(n, np.int64)]),
        np.concatenate([rows.uv, uv]),
        np.concatenate([rows.area, area]),
    )


def _shuffle(rows: TruthRows, rng: np.random.Generator) -> TruthRows:
    """In order of frame, and in no order within it."""
    order = np.lexsort((rng.random(len(rows.frame)), rows.frame))
    return _take(rows, order)


def _take(rows: TruthRows, order: Ints) -> TruthRows:
    return TruthRows(rows.frame[order], rows.marker[order], rows.merged[order], rows.uv[order], rows.area[order])


def _collect(rig: Rig, subject: Subject, cameras: list[TruthRows], noise_px: float, sight: Sight) -> ObservedImages:
    counts = np.array([np.bincount(rows.frame, minlength=subject.n_frames) for rows in cameras]).reshape(len(rig), -1)
    _, marker, merged, uv, area = (np.concatenate(column) for column in zip(*cameras, strict=True))
    cov = np.broadcast_to(noise_px**2 * np.eye(2), (len(uv), 2, 2))
    across = 2 * np.sqrt(area / np.pi)
    detections = Detections.build(
        rig.names, subject.rate, counts, uv, cov, area=area, width=across, height=across, merged=merged > 1
    )
    return ObservedImages(detections, marker, merged, sight)
