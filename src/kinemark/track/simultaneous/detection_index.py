"""What the cameras saw, as the tracker reads it: ideal pixels, their uncertainty, and which lie near a place.

Every image counts as seen by a pinhole camera, its lens undone once for the whole recording. The noise of an image is
that of its centroid plus what the calibration of its camera leaves open at a place in the middle of their views,

    C = C_centroid + J_θ C_θ J_θᵀ                                        (1)

taken as equal in both axes. Where markers run together, the image is no marker's own; it lies within the blob, so its
noise is that of a place somewhere in a disc of the blob's size, (r / 2)² in each axis (2). A marker half behind a limb
has its image beside its place by a part of its radius r. For the association (HIDDEN r)² is added; the positions are
solved by a method with heavy tails, which knows of that itself.

The images stand in one long list by frame, camera and u. Those near a place are a piece of it, found by bisection, so
that looking costs the same whether a camera sees ten markers or a thousand. Long recordings have many images: what
follows from the detections' own columns is worked out where it is needed, and numbers of rows have four bytes.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from ...data import Camera, Detections, Rig
from ...data.array_types import Bools, Floats, Ints
from ...data.detections import alike_in_all
from ...geometry import parameter_jacobian, undistort
from ...geometry.common_view import common_view_centre
from ...native import ImageIndex, index_images
from ...numerics.returned_memory import return_memory

USUAL_SD = 0.2
"""px, of centroids of which nobody knows the noise; chosen (see benchmarks/tracking.py)."""

LEAST_SD = 0.05
"""px; no calibration of a real camera is better, whatever it says of itself; chosen (see benchmarks/tracking.py)."""

SEEN = 0.8
"""p of `associate`, with which a camera sees a marker; it weighs little: between 0.5 and 0.95, the score of an image
changes by that of a distance of two standard deviations; chosen (see benchmarks/tracking.py)."""

HIDDEN = 0.1
"""Of the radius of an image: its usual shift where a limb hides a part of it; chosen (see benchmarks/tracking.py)."""

USUAL_AREA = 20.0
"""px², of images of which nobody knows the size; chosen (see benchmarks/tracking.py)."""

AT_ONCE = 20_000
"""Cells that are looked at in one go; chosen: more would take memory and no less time."""

Rows = slice | Ints | Bools
"""Some rows of a column."""

EVERY = slice(None)
"""All of them."""


class Images(NamedTuple):
    """All D detections of a recording of C cameras and F frames.

    Attributes:
        P: (C, 3, 4) projections, scaled so that the third row gives the depth in mm.
        uv: (D, 2) ideal pixels; variance: (D) px² of each axis.
        cov, area: (D, 2, 2) px² and (D) px², as `Detections` has them.
        camera, frame: (D); usable: (D) whether it is valid; merged: (D) whether it may be more markers than one.
        prior: (C) 2 ln(p / ((1 − p) 2π b)) of `associate`, b images per frame and px².
        calibration: (C) px², the second term of (1), which is in `variance`.
        timing: (D, 2) px along the motion of each image, the standard deviation that the time at which it was taken
        makes, whose square is in `variance`; None where all were taken in time.
        common: px², the part of `variance` of images that are merged though the file does not mark them
            (`merging_in_images`); 0 where there are none.
        widest: (F C) px², the greatest variance in each frame and camera.
        stated: whether any source says how noisy its images are; usual: px², of those of which none does.
        size: (C, 2) of the images, px.
        n_frames: F.
        by_cell: the usable rows by frame, camera and u; a cell is frame C + camera.
    """

    P: Floats
    uv: Floats
    variance: Floats
    cov: Floats
    area: Floats
    camera: Ints
    frame: Ints
    usable: Bools
    merged: Bools
    prior: Floats
    calibration: Floats
    timing: Floats | None
    widest: Floats
    stated: bool
    usual: float
    size: Floats
    n_frames: int
    by_cell: ImageIndex
    common: float = 0.0

    def near(self, cell: Ints, u: Floats, reach: Floats) -> tuple[Ints, Ints]:
        """Images whose u lies within reach (N) px of u (N), in cells frame C + camera (N): (places in N, rows)."""
        return self.by_cell.near(cell, u, reach)

    def radius(self, rows: Rows = EVERY) -> Floats:
        """px of some images."""
        return _radius(self.area[rows])

    def own(self, detection: Ints) -> Ints:
        """Detections (C, P) without merged images, −1 for these: they are of no marker alone."""
        return np.where((detection >= 0) & ~self.merged[detection], detection, np.int32(-1))

    def margin(self, rows: Rows = EVERY) -> Floats:
        """px² that `variance` of some images has for the association alone."""
        return _margin(_centroid_variance(self.cov[rows], self.usual), self.area[rows])

    def noisier(self, added: Floats) -> Images:
        """The same with more variance (C) px² in the images of each camera."""
        variance = np.empty_like(self.variance)
        for own, more in zip(self.of_cameras, added, strict=True):
            variance[own] = np.maximum(self.variance[own] + more, LEAST_SD**2)
        return self._replace(variance=variance, widest=_widest(variance, self.by_cell))

    def believed(self, share: float) -> Images:
        """The same with that share of the variance that the centroids state."""
        variance = self.variance + (share - 1) * _centroid_variance(self.cov, self.usual)
        variance = np.maximum(variance, LEAST_SD**2)
        return self._replace(variance=variance, widest=_widest(variance, self.by_cell))

    def with_merged(self, merged: Bools, common: float) -> Images:
        """The same with images (D) that are merged, though the file does not mark them, of more variance in px²."""
        variance = self.variance + np.where(merged & ~self.merged, common, 0.0)
        widest = _widest(variance, self.by_cell)
        return self._replace(merged=self.merged | merged, variance=variance, widest=widest, common=common)

    def without(self, cameras: Ints) -> Images:
        """The same without the images of some cameras."""
        if not len(cameras):
            return self
        return self.only(~np.isin(self.camera, cameras))

    def only(self, which: Bools) -> Images:
        """The same with only those images (D) that are usable so far."""
        usable = self.usable & which
        return self._replace(usable=usable, by_cell=self.by_cell.keep(usable))

    def laid_aside(self) -> Images:
        """The same without what is of its rig: places, variances and the index, while another rig's are looked at."""
        return self.unplaced()._replace(variance=np.broadcast_to(np.nan, self.variance.shape))

    def unplaced(self) -> Images:
        """The same without places and the index, which `placed` gives back."""
        nothing = index_images(np.zeros((0, 2)), np.zeros(0, np.int64), np.zeros(0, bool), n_cells=self.by_cell.n_cells)
        return self._replace(uv=np.broadcast_to(np.nan, self.uv.shape), by_cell=nothing)

    def seen_by(self, detections: Detections, rig: Rig, frames: list[int]) -> Images:
        """The same with the places that a rig's lenses give to images of some frames, and the index as it is."""
        rows, uv = np.concatenate(self.in_frames(frames)), self.uv.copy()
        for c, camera in enumerate(rig):
            own = rows[self.camera[rows] == c]
            uv[own] = undistort(camera, detections.uv[own])
        return self._replace(uv=uv)

    def placed(self, detections: Detections, rig: Rig, order: NDArray[np.int32], first: Ints) -> Images:
        """The same with the places of all images of a rig, and an index of this order and these first ones of cells."""
        uv = _ideal(detections, rig)
        return self._replace(uv=uv, by_cell=ImageIndex(uv, order, first))

    @property
    def of_cameras(self) -> list[slice]:
        """The rows of each camera."""
        return [slice(*pair) for pair in pairwise(np.searchsorted(self.camera, np.arange(len(self.P) + 1)).tolist())]

    def in_frames(self, frames: list[int]) -> list[Ints]:
        """Usable rows of each frame, camera by camera."""
        order, first, C = cast(Ints, self.by_cell.order), self.by_cell.first, len(self.P)
        return [order[first[f * C] : first[(f + 1) * C]] for f in frames]


def read_images(
    detections: Detections, rig: Rig, timing: Floats | None = None, *, other: Images | None = None
) -> Images:
    """The images of detections, seen by the cameras of a rig; `timing` (D, 2) px as that of `Images`.

    With those of an `other` rig they share the columns that are of no rig, as a long recording has many images, and
    what was inferred of merged ones.
    """
    of_camera, frame = _places(detections) if other is None else (other.camera, other.frame)
    uv = _ideal(detections, rig)
    usable = detections.valid & np.isfinite(uv[:, 0]) & np.isfinite(uv[:, 1])
    size = np.array([extent(camera, uv[_of_camera(detections, c)]) for c, camera in enumerate(rig)])
    clutter = np.maximum(detections.counts.sum(1) / max(detections.n_frames, 1), 1.0) / size.prod(1)
    middle = common_view_centre(rig)
    calibration = np.array([_open(camera, middle) for camera in rig])
    stated, usual = _usual_noise(detections)
    variance = _variance(detections, usual, calibration)
    variance = variance if timing is None else variance + (timing**2).sum(1)
    return_memory()
    index = _index(uv, frame, of_camera, usable, detections.n_frames, len(rig))
    return_memory()
    images = Images(
        P=rig.P / np.linalg.norm(rig.P[:, 2, :3], axis=1)[:, None, None],
        uv=uv,
        variance=variance,
        cov=detections.cov,
        area=detections.area,
        camera=of_camera,
        frame=frame,
        usable=usable,
        merged=detections.merged,
        prior=2 * np.log(SEEN / ((1 - SEEN) * 2 * np.pi * clutter)),
        calibration=calibration,
        timing=timing,
        widest=_widest(variance, index),
        stated=stated,
        usual=usual,
        size=size,
        n_frames=detections.n_frames,
        by_cell=index,
    )
    return images.with_merged(other.merged, other.common) if other is not None and other.common else images


def _ideal(detections: Detections, rig: Rig) -> Floats:
    """`Images.uv` of the cameras of a rig."""
    uv = np.empty((len(detections), 2))
    for c, camera in enumerate(rig):
        own = _of_camera(detections, c)
        uv[own] = undistort(camera, detections.uv[own])
    return uv


def _of_camera(detections: Detections, c: int) -> slice:
    """The rows of camera c."""
    return slice(int(detections.start[c, 0]), int(detections.start[c, -1]))


def _places(detections: Detections) -> tuple[Ints, Ints]:
    """Camera and frame (D) of each row, in half of the memory."""
    counts, C, F = detections.counts, len(detections.cameras), detections.n_frames
    camera = np.repeat(np.arange(C, dtype=np.int32), counts.sum(1))
    frame = np.repeat(np.tile(np.arange(F, dtype=np.int32), C), counts.reshape(-1))
    return cast(Ints, camera), cast(Ints, frame)


def _usual_noise(detections: Detections) -> tuple[bool, float]:
    """Whether any centroid states its noise, and the usual, px², which those have that do not."""
    cov = detections.cov[:1] if alike_in_all(detections.cov) else detections.cov
    centroid = np.trace(cov, axis1=1, axis2=2) / 2
    centroid = centroid[np.isfinite(centroid)]
    return bool(len(centroid)), float(np.median(centroid)) if len(centroid) else USUAL_SD**2


def _variance(detections: Detections, usual: float, calibration: Floats) -> Floats:
    """`Images.variance` (D) but for the times of the images, camera by camera."""
    out = np.empty(len(detections))
    for c, left_open in enumerate(calibration):
        own = _of_camera(detections, c)
        noise, area = _centroid_variance(detections.cov[own], usual), detections.area[own]
        variance = noise + _margin(noise, area) + left_open  # (1)
        out[own] = variance + np.where(detections.merged[own], _radius(area) ** 2 / 4, 0.0)  # (2)
    return out


def _centroid_variance(cov: Floats, usual: float) -> Floats:
    """(n) px² of centroids of covariances (n, 2, 2) px², `usual` px² of those that do not state it."""
    centroid = np.trace(cov, axis1=1, axis2=2) / 2
    return np.where(np.isfinite(centroid), centroid, usual)


def _radius(area: Floats) -> Floats:
    """(n) px of images of areas (n) px²."""
    return np.asarray(np.sqrt(np.where(np.isfinite(area), area, USUAL_AREA) / np.pi))


def _margin(noise: Floats, area: Floats) -> Floats:
    """`Images.margin` of images of noise (n) px² and areas (n) px²."""
    hidden = np.where(np.isfinite(area), (HIDDEN * _radius(area)) ** 2, 0.0)
    return np.asarray(np.maximum(LEAST_SD**2 - noise, 0.0) + hidden)


def _index(uv: Floats, frame: Ints, camera: Ints, usable: Bools, n_frames: int, C: int) -> ImageIndex:
    """`Images.by_cell`."""
    return index_images(uv, frame * C + camera, usable, n_cells=n_frames * C)


def _widest(variance: Floats, index: ImageIndex) -> Floats:
    """`Images.widest`."""
    widest, every = np.zeros(index.n_cells), np.flatnonzero(np.diff(index.first))
    for some in np.array_split(every, max(len(every) // AT_ONCE, 1)) if len(every) else ():
        first, end = index.first[some[0]], index.first[some[-1] + 1]
        greatest = np.maximum.reduceat(variance[index.order[first:end]], index.first[some] - first)
        widest[some] = np.maximum(greatest, 0.0)
    return widest


def extent(camera: Camera, uv: Floats) -> Floats:
    """(2) size of a camera's images, px; as far as images were seen where it is not known."""
    if camera.size.all():
        return np.asarray(camera.size, np.float64)
    seen = uv[np.isfinite(uv).all(1)]
    return np.maximum(seen.max(0, initial=1.0), 64.0)


def _open(camera: Camera, xyz: Floats | None) -> float:
    """px², the second term of (1) at a point (3) mm, the mean of both axes."""
    if xyz is None or not camera.cov.any() or (camera.R @ xyz + camera.t)[2] <= 0:
        return 0.0
    J = parameter_jacobian(camera, xyz[None])[0]
    return float(np.trace(J @ camera.cov @ J.T) / 2)
