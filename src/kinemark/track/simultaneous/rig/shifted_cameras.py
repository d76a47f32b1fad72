"""Cameras that stand otherwise than they are calibrated, as the parts of a recording show.

Each camera is compared with what all the others together say. From its images in the tracks, the median of image less
projection over a tenth of the recording shows a camera that stands otherwise than it is calibrated (1), and since when.
The share of the tracked points for which it has an image shows one whose images fit nothing any more (2), where its
images are in no tracks: a subject who leaves turns away from a camera that still sees some of the markers.
What is so in less than half of the parts from then on is of a place in the volume, as a lens fits less well at the edge
of the image, where subjects come and go (7); so is what comes little by little, as a subject walks along (8).
A camera that was touched stands out among the others, whose images lie beside by what the calibration leaves (9).
Where images in no track lie beside the points by the same in all parts, the camera was shifted by so much, however
little noise it was taken to have (11). Numbers are those of `diagnostics`.

With s the share of the offset that an image lies beside, from 0 to 1, it was touched before the frame f that has the
least sum of s − ½ over the images before it (12).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ....data import Finding, make_finding
from ....data.array_types import Bools, Floats, Ints
from ....numerics.finite import finite_median
from ..detection_index import EVERY, Images, Rows
from ..following.associate import places_in_image
from ..noise.measurement_noise import MAX_DISTANCE, MIN_FOUND_SHARE
from ..times.time_offsets import MIN_SHIFT
from ..tracker import TrackingResult

PARTS = 10
"""Into which a recording is cut; chosen (see benchmarks/tracking.py)."""

STANDS_OUT, LEAST_SHIFT = 3.0, 0.75
"""Times as far off as the others' median that the images of a camera are that was touched (9), and px at least; chosen
on 32 simulated recordings of 4 to 10 good cameras .3 to 1 px off: one has such a camera, 13 have one that is 2 times
and 0.5 px off. Of 19 that were touched by 2 px 12 are told, by 2 times 13."""

STEP = 0.4
"""Of what changed since before, the least that did so from one part of the recording to the next (8); chosen: a subject
who walks through the volume changes it by up to a third."""

ALONE = 2.0
"""px off, from which on one part of the recording is enough to tell a touched camera (1); chosen: merged images of a
few markers in a short part move its median by up to one."""

FEW = 30
"""Points from which a median is taken; chosen (see benchmarks/tracking.py)."""


class Parts(NamedTuple):
    """Of one camera and each part of the recording: off (n, 2) px where its images lie beside the others' points, NaN
    where hardly any lies near; share (n) of the points that have one in their track; first (n) frame of the part."""

    off: Floats
    share: Floats
    first: Ints

    @property
    def usual(self) -> float:
        """px, how far off in the median part; NaN where that is not known."""
        return finite_median(np.linalg.norm(self.off, axis=1))

    def change(self, since: int) -> float:
        """px, how far the median after a frame lies from the one before; NaN where either is not known."""
        after = min(int(np.searchsorted(self.first, since)), len(self.first) - 1)
        before = max(int(np.searchsorted(self.first, since, "right")) - 1, 0)
        was, now = (np.array([finite_median(axis) for axis in off.T]) for off in (self.off[:before], self.off[after:]))
        return float(np.linalg.norm(now - was))


class Beside(NamedTuple):
    """Of the points in view of a camera: how many, inside, and how many have an image of it in their track, tracked;
    frame (n) of those that its images lie near to, and off (n, 2) px by which these lie beside."""

    inside: int
    tracked: int
    frame: Ints
    off: Floats


def usual_offsets(result: TrackingResult, parts: Sequence[Parts]) -> Floats:
    """(C) px by which the images of each camera lie beside in the median part; NaN of those left out."""
    left_out = np.isin(np.arange(len(parts)), result.noise.inconsistent)
    return np.where(left_out, np.nan, [one.usual for one in parts])


def least_shifts(result: TrackingResult, parts: Sequence[Parts]) -> Floats:
    """(C) px by which the images of a camera that was touched lie beside at least, among the others' (9)."""
    usual = usual_offsets(result, parts)
    others = [finite_median(np.delete(usual, c), 0.0) for c in range(len(parts))]
    return np.maximum(LEAST_SHIFT, STANDS_OUT * np.array(others))


def shifted(result: TrackingResult, c: int, name: str, parts: Parts, most: float) -> list[Finding]:
    """About a camera whose images lie beside the others', by more than `most` px, or fit no longer."""
    if c in result.noise.inconsistent:
        return []
    return _lost(result, c, name, parts, most) or _beside_others(result, c, name, parts, most)


def _lost(result: TrackingResult, c: int, name: str, parts: Parts, most: float) -> list[Finding]:
    """About a camera whose images fit no longer (2), where they are then by the same beside the points (11)."""
    usual = np.nanmax(parts.share, initial=0.0)
    lost = parts.share < 0.1 * usual
    if not (usual > MIN_FOUND_SHARE and lost[-1]):
        return []
    k = len(lost) - int(np.argmin(lost[::-1]))
    if not images_fit_nothing(result, c, since := parts.first[k]):  # without images, nothing says so
        return []
    last = result.tracks.cloud.n_frames - 1
    if (beside := _beside(parts.off[k:], most)) is None:
        return [make_finding("camera_moved", cameras=[name], frames=[(since, last)])]
    return [_shifted(name, beside, [(_since(result, c, beside, parts, k), last)])]


def _beside_others(result: TrackingResult, c: int, name: str, parts: Parts, most: float) -> list[Finding]:
    """About a camera whose images lie beside the others' (1), from some part on or throughout."""
    far = np.linalg.norm(parts.off, axis=1)
    wrong = np.flatnonzero(far > most)
    if not len(wrong) or 2 * len(wrong) < np.isfinite(far[wrong[0] :]).sum():  # (7)
        return []
    if len(wrong) == 1 and far[wrong[0]] < ALONE:
        return []
    whole = len(wrong) >= np.isfinite(far).sum() - 1 or not np.isfinite(far[: wrong[0]]).any()
    if not whole and not _stepped(parts.off, wrong[0], most):
        return []
    offset = np.nanmedian(parts.off[wrong], axis=0)
    began = [] if whole else [(_since(result, c, offset, parts, wrong[0]), result.tracks.cloud.n_frames - 1)]
    return [_shifted(name, offset, began)]


def _since(result: TrackingResult, c: int, offset: Floats, parts: Parts, k: int) -> int:
    """The frame from which on images of camera c lie beside by an offset (2) px, in the part k that is the first to
    show it, or the one before (12)."""
    edges = np.append(parts.first, result.tracks.cloud.n_frames)
    first, stop = int(edges[max(k - 1, 0)]), int(edges[k + 1])
    beside = beside_points(result, c, first, stop)
    s = np.clip(beside.off @ offset / (offset @ offset), 0.0, 1.0)
    total = np.cumsum(np.bincount(beside.frame - first, s - 0.5, stop - first))
    return first + int(np.argmin(np.append(0.0, total[:-1])))


def _shifted(name: str, offset: Floats, frames: Sequence[tuple[int, int]]) -> Finding:
    """About a camera whose images lie beside by an offset (2) px, in all frames where none are given."""
    u, v = offset
    return make_finding("camera_shifted", cameras=[name], frames=frames, offset_u_px=u, offset_v_px=v, left_out=False)


def _beside(off: Floats, most: float) -> Floats | None:
    """(2) px by which images lie beside points, off (n, 2), in all of several parts by the same more than `most` (11);
    None where they do not."""
    if len(off) < 2 or not np.isfinite(off).all():
        return None
    middle = np.median(off, axis=0)
    spread = np.linalg.norm(off - middle, axis=1).max()
    return middle if spread < MIN_SHIFT and np.linalg.norm(middle) > most else None


def _stepped(off: Floats, k: int, most: float) -> bool:
    """Whether off (n, 2) changed by `most` px with part k, and at once (8)."""
    step = np.linalg.norm(np.nanmedian(off[k:], axis=0) - np.nanmedian(off[:k], axis=0))
    known = off[np.isfinite(off[:, 0])]
    at_once = np.linalg.norm(np.diff(known, axis=0), axis=1).max()
    return bool(step > most and at_once > STEP * step)


def images_fit_nothing(result: TrackingResult, c: int, since: int) -> bool:
    """Whether camera c has images from frame `since` on, and hardly any of them is in a track."""
    images, used = result.images, result.tracks.cloud.detection[:, c]
    own = np.flatnonzero(images.usable & (images.camera == c) & (images.frame >= since))
    return len(own) >= FEW and bool(np.isin(own, used).mean() < 0.1)


def parts_of_recording(result: TrackingResult, c: int) -> Parts:
    """What a camera has where the points of the tracks are, by parts of the recording."""
    cloud = result.tracks.cloud
    edges = np.unique(np.linspace(0, cloud.n_frames, PARTS + 1).astype(int))
    off, share = np.full((len(edges) - 1, 2), np.nan), np.full(len(edges) - 1, np.nan)
    for k, (first, stop) in enumerate(pairwise(edges)):
        beside = beside_points(result, c, first, stop)
        if len(beside.off) >= max(FEW, 2 * MIN_FOUND_SHARE * beside.inside):
            off[k] = np.median(beside.off, axis=0)
        if beside.inside >= FEW:
            share[k] = beside.tracked / beside.inside
    return Parts(off, share, edges[:-1])


def beside_points(result: TrackingResult, c: int, first: int, stop: int) -> Beside:
    """What camera c has beside the points of the tracks in frames `first` to `stop` − 1."""
    cloud, images = result.tracks.cloud, result.images
    rows = slice(cloud.start[first], cloud.start[stop])
    frame, own = cloud.frame[rows], cloud.detection[rows, c]
    uv = expected_places(result, c, rows)
    inside = in_view(result, c, uv, 2, rows)
    near = nearest_images(images, frame, c, uv)
    near[(near != own) & np.isin(near, own)] = -1  # another marker's says nothing of this one
    there = inside & (near >= 0)
    count, tracked = int(inside.sum()), int((own[inside] >= 0).sum())
    return Beside(count, tracked, frame[there], images.uv[near[there]] - uv[there])


def expected_places(result: TrackingResult, c: int, rows: Rows = EVERY) -> Floats:
    """(P) px where camera c should see the points of the tracks, some or all."""
    return places_in_image(result.images.P[c], result.tracks.cloud.xyz[rows])


def in_view(result: TrackingResult, c: int, uv: Floats, least: int, rows: Rows = EVERY) -> Bools:
    """(P) points of the tracks that lie in the image of camera c, at uv (P, 2), and that so many others see."""
    others = np.delete(result.tracks.cloud.detection[rows], c, axis=1) >= 0
    return np.asarray(((uv >= 0) & (uv < result.images.size[c])).all(1) & (others.sum(1) >= least))


def nearest_images(images: Images, frame: Ints, c: int, uv: Floats) -> Ints:
    """(P) rows of the images of camera c nearest to places uv (P, 2), −1 where none is within FAR."""
    own, detection = images.near(frame * len(images.P) + c, uv[:, 0], np.full(len(uv), MAX_DISTANCE))
    far = np.linalg.norm(images.uv[detection] - uv[own], axis=1)
    order = np.argsort(-far, kind="stable")
    order = order[far[order] < MAX_DISTANCE]
    out = np.full(len(uv), -1)
    out[own[order]] = detection[order]
    return out
