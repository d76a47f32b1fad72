"""Images that stand still, and points of them: what many frames together tell of where rays meet.

Where a person stands still, images of two markers that lie on each other's lines in one frame lie there in all frames:
no motion ever parts them. But the noise of an image is new in each frame, so that the mean of n images has the variance

    l + w / n,   w = median of (y_{t+1} − y_t)² / 2                                        (1)

with l what the calibration leaves in all of them, and far fewer chance meetings lie within the gate. l is learned from
the means themselves (`standing_noise`). A common sway does no harm: the images of all cameras are of the same frames,
and the mean of a marker's images is that of its mean place, as far as it moves little.

An image at y stands still where each of the frames up to HALF_S before it and after it, of which STEPS are looked at on
either side, has one image alone within the gate of y, or some of them none, and FEWEST have one. Points of the means
are found as by `candidate_points`, and placed by the images of their own frame.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ....native import index_images
from ....numerics.evenly import evenly
from ..detection_index import Images
from .candidate_points import CandidatePoints, find_candidate_points, intersect

HALF_S, STEPS = 0.48, 24
"""Time before an image and after it that it stands still in, s, and how many frames of either side are looked at at the
most; chosen: the mean of such images has a seventh of the noise of one, and a foot of somebody who walks does not stand
so long."""

MOST_MISSING = 0.25
"""Of these frames, the share that may have no image; chosen: drop-outs are fewer."""

FEWEST = 12
"""Images of a mean, a number; chosen: of fewer, w of (1) is not known to a third."""


class Standing(NamedTuple):
    """N images that stand still: their rows; the means uv (N, 2) px of so many, number (N); w of (1), white (C) px²."""

    row: Ints
    uv: Floats
    number: Ints
    white: Floats


def find_standing_points(
    images: Images, free: Bools, F: Floats, frames: list[int], T: float, gate: float, lasting: Floats
) -> CandidatePoints:
    """As `find_candidate_points`, of those of the free images that stand still; `lasting` (C) px² is l of (1)."""
    standing = standing_still(images, free_rows(images, free, frames), T, gate)
    means = means_of(images, standing, np.array(frames, np.int64), lasting)
    found = find_candidate_points(means, means.usable, F, [*range(len(frames))], gate)
    row = np.append(standing.row, -1)
    found = found._replace(frame=np.array(frames, np.int64)[found.frame], detection=row[found.detection])
    point = intersect(images, found.detection)
    squared = np.where(found.detection >= 0, point.squared, 0.0).sum(0)
    found = found._replace(xyz=point.xyz, cov=point.cov, squared=squared)
    return found.take(np.asarray(np.isfinite(point.xyz).all(0) & np.isfinite(point.cov).all((0, 1))))


def free_rows(images: Images, free: Bools, frames: list[int]) -> Ints:
    """The free rows of some frames that are not merged, which rise."""
    rows = np.sort(np.concatenate([np.zeros(0, np.int64), *images.in_frames(frames)]))
    return np.asarray(rows[free[rows] & ~images.merged[rows]])


def standing_still(images: Images, rows: Ints, T: float, gate: float) -> Standing:
    """Those of some rows that stand still."""
    half = max(round(HALF_S / T), 1)
    after = 1 + evenly(half, STEPS)
    steps = np.concatenate([-after[::-1], [0], after])
    around = np.full((len(steps), len(rows)), -1)
    around[len(after)] = rows
    missing = np.zeros(len(rows), np.int64)
    for k in np.argsort(-np.abs(steps), kind="stable")[:-1].tolist():  # most images that move fail at the first
        around[k], several = _only_one(images, rows, int(steps[k]), gate)
        missing += around[k] == -1
        on = ~several & (missing <= MOST_MISSING * len(steps))
        rows, around, missing = rows[on], around[:, on], missing[on]
        if not len(rows):
            break
    many = (around >= 0).sum(0) >= FEWEST
    rows, around = rows[many], around[:, many]
    there = around >= 0
    uv = np.where(there[..., None], images.uv[around], 0.0)
    number, both = there.sum(0), there[1:] & there[:-1]
    squared = np.where(both, (np.diff(uv, axis=0) ** 2).sum(-1) / 4, 0.0).sum(0) / np.maximum(both.sum(0), 1)
    camera = images.camera[rows]
    white = [float(np.median(squared[camera == c])) if (camera == c).any() else 0.0 for c in range(len(images.P))]
    return Standing(rows, uv.sum(0) / number[:, None], number, np.array(white))


def _only_one(images: Images, rows: Ints, step: int, gate: float) -> tuple[Ints, Bools]:
    """(N) the image `step` frames later within the gate of each of some rows, −1 for none, −2 outside of the recording;
    and whether there are several."""
    frame = images.frame[rows].astype(np.int64) + step
    inside = (frame >= 0) & (frame < images.n_frames)
    reach = gate * np.sqrt(2 * images.variance[rows])
    cell = np.where(inside, frame, 0) * len(images.P) + images.camera[rows]
    query, row = images.near(cell, images.uv[rows, 0], reach)
    near = inside[query] & (np.hypot(*(images.uv[row] - images.uv[rows[query]]).T) < reach[query])
    out = np.where(inside, -1, -2)
    out[query[near]] = row[near]
    return out, np.bincount(query[near], minlength=len(rows)) > 1


def means_of(images: Images, standing: Standing, frames: Ints, lasting: Floats) -> Images:
    """The means as images of their own, of frames by their number in `frames`."""
    row, uv, number, w = standing
    camera, frame = images.camera[row], np.searchsorted(frames, images.frame[row])
    variance = lasting[camera] + w[camera] / number  # (1)
    cell, n = frame * len(images.P) + camera, len(frames) * len(images.P)
    usable, widest = np.ones(len(row), bool), np.zeros(n)
    np.maximum.at(widest, cell, variance)
    return images._replace(
        uv=uv,
        variance=variance,
        camera=camera,
        frame=frame,
        usable=usable,
        merged=~usable,
        widest=widest,
        n_frames=len(frames),
        by_cell=index_images(uv, cell, usable, n_cells=n),
    )
