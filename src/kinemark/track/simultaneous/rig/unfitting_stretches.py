"""Stretches of a recording in which a camera does not fit the others: it was bumped, or its images are of other times.

Of images of cameras r and s near each other's epipolar lines (`epipolar_noise`) those that meet by chance are as many
at any distance e, those of one marker lie at 0. So

    n = #{|e| < A} − A / (W − B) #{B < |e| < W}                                                            (1)

counts pairs of one marker, and q = n / #, with # the pairs that there might be, says how well two cameras fit. In parts
of the recording camera c does not fit in which

    Q_c = Σ_s n / Σ_s #  is less than LOST of what it is in its best parts,  while of the others among themselves it
    is KEPT of theirs and more                                                                              (2)

Who leaves the view of two cameras by two sides takes their pairs along. So all is tracked without the camera, and it is
lost where it has no image near the points that the others then show, though elsewhere it has of so many that this is no
chance (3). Where a calibration is off, images of who comes to the side of the volume lie as far beside. But there
tracks go on that are made with the camera, which they hardly do where it was bumped (5).

Who does not fit in the whole recording has no best parts (`misfitting_cameras`). Of three cameras one that fits none
takes the pairs of both others along. So a camera is lost in parts only where two of the others are partners
(`epipolar_noise` (7)), and it is suspected in all where these are and it has no partner itself (4).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from itertools import chain, pairwise
from typing import NamedTuple

import numpy as np

from ....data import Detections, Rig, Tracks
from ....data.array_types import Bools, Floats, Ints
from ....data.detections import Validity
from ....numerics.evenly import scattered
from ....numerics.runs import true_runs, true_runs_of_rows
from ..detection_index import Images, read_images
from ..following.associate import places_in_image
from ..following.candidate_points import fundamentals
from ..noise.epipolar_noise import WINDOW, pair_of, partners, residuals
from ..noise.measurement_noise import sampled_frames
from .adjusted_rig import adjusted_rig
from .misfitting_cameras import image_offset, misfitting, stands_apart

PARTS = 20
"""Into which a recording is cut; chosen: what is left of a part in which a camera was bumped is a twentieth."""
LEAST_FRAMES = 5
"""Of a part; chosen."""
SAMPLED_IMAGES = 500
"""Images that are looked at in a part, about; chosen: (1) of fifteen markers is known to a tenth."""
NEAR, APART = 2.0, 4.0
"""A and B of (1), px; chosen: images of one marker lie within 1 px, of a calibration 1 px off within 3."""
LOST, KEPT = 0.4, 0.6
"""Of (2); chosen on scenes 160000 to 160059 of the second generator: of 26 cameras that were bumped by 12 px 23
kept −0.2 to 0.25, those bumped along the lines of others 0.5 to 0.7; good ones mostly had 0.5 and more in all parts."""
SEEN = 0.6
"""Of the usual #, from which on a part tells: who leaves the view takes the images along; chosen."""
LEAST_PARTS = 2
"""In which a camera does not fit, chosen: one alone is chance."""
BEST, DOUBTFUL = 0.9, 0.7
"""Quantile of the parts that are a camera's best, and what of it is at least good; chosen."""
LEAST_CAMERAS = 4
"""That are left, from which on a second one is looked for; chosen: of three nobody tells which."""
FITTING = 0.4
"""Of how well the others fit, what a camera must in its best parts, chosen: images that are late in the whole recording
fit for moments; good cameras had 0.5 and more."""
LEFT = 0.3
"""Of the share of points with an image in the camera, what is left where it is lost, at most (3); chosen: other markers
lie near by chance, of 0.0 to 0.03 of the points in 24 scenes; a camera that sees the back of a subject, and of that
markers that the others hardly see, kept 0.36; cameras bumped for a seventh of the recording up to 0.27."""
CHANCE = 0.05
"""That a camera in place has no image of any of the markers that the others show, as it hides many (3); chosen."""
FOLLOWED = 0.45
"""Of the share of a camera's images that are in tracks in other frames, what is exceeded in a stretch in which it is
not lost (5); chosen on walks and runs of files 1 px off (seeds 2149 and 440000 to 440119 of
benchmarks/tracking_scenes.py) and cameras bumped by 12 px (430008 to 430054): three good ones had 0.5 to 0.9, bumped
ones 0.0 to 0.4."""
EDGE = 0.1
"""Of the image's size, at its edges, where images are not missed (3); chosen: lenses bend markers out of it."""
LEAST_POINTS = 30
"""From which a share is taken; chosen."""
CLEAR = 5.0
"""Standard deviations of chance that n of a camera's good parts must be; chosen."""


class Stretch(NamedTuple):
    """Frames first to stop − 1 in which a camera, a number, does not fit the others."""

    camera: int
    first: int
    stop: int

    def whole(self, n_frames: int) -> bool:
        """Whether it is all of a recording of so many frames."""
        return self.first == 0 and self.stop == n_frames


def unfitting_stretches(detections: Detections, rig: Rig, kept: Collection[int] = ()) -> tuple[Stretch, ...]:
    """Where cameras fit the others no more, by camera and time.

    Args:
        detections: what they saw. rig: the cameras. kept: those that are lost in no part by (2), as is known, though
            they may fit nowhere.
    """
    detections = detections.keep(detections.valid)
    C, n = len(rig), detections.n_frames
    parts = min(PARTS, n // LEAST_FRAMES)
    if C < 3 or parts < 2 or not len(detections):
        return ()
    edges = np.linspace(0, n, parts + 1).astype(int)
    counts = detections.counts
    looked_at = [_sampled(range(a, b), counts) for a, b in pairwise(edges)]
    frames = list(chain(*looked_at))
    images = read_images(detections.keep(np.isin(detections.frame, frames)), rig)
    F = fundamentals(images.P)
    found = [_fit(images, F, counts[:, part], part) for part in looked_at]
    by_part = [np.stack(each) for each in zip(*found, strict=True)]
    lost = _lost(*by_part)
    lost[[*kept]] = False
    together = partners(residuals(images, F, frames), C, len(frames))
    others_do = np.array([np.delete(np.delete(together, c, 0), c, 1).any() for c in range(C)])
    lost[~others_do] = False  # (4)
    runs = [Stretch(int(c), int(edges[a]), int(edges[b])) for c, a, b in true_runs_of_rows(lost)]
    in_all, chance, possible = (each.sum(0) for each in by_part)
    fitting = np.flatnonzero(~lost.any(1))
    alone = fitting[(others_do & ~together.any(1) & (counts.sum(1) > 0))[fitting]]
    whole = {*misfitting(in_all, chance, possible, fitting), *alone.tolist()}
    return tuple(sorted([*runs, *(Stretch(c, 0, n) for c in whole)]))


def without_stretches(detections: Detections, stretches: tuple[Stretch, ...]) -> Detections:
    """The same, their detections not valid in these."""
    if not stretches:
        return detections
    validity = detections.validity.copy()
    for one in stretches:
        validity[detections.start[one.camera, one.first] : detections.start[one.camera, one.stop]] = Validity.MASKED
    return replace(detections, validity=validity)


def is_lost(stretch: Stretch, tracks: Tracks, others: Images, detections: Detections, rig: Rig) -> bool:
    """Whether the camera lacks images in a stretch where points of the others are, more than in other frames (3).

    Args:
        stretch: in question. tracks, others: without it, and the images that they are of.
        detections, rig: of all cameras.
    """
    images, c, cloud = read_images(detections, rig), stretch.camera, tracks.cloud
    if stretch.whole(detections.n_frames):
        offset = image_offset(c, tracks, images)
        nowhere = offset is not None and np.isnan(offset).any()
        return stands_apart(offset, others) and not (nowhere and _fits_adjusted(c, images, detections, rig))
    uv = places_in_image(images.P[c], cloud.xyz)
    middle = np.abs(uv / images.size[c] - 0.5) < 0.5 - EDGE
    inside = middle.all(1) & ((np.delete(cloud.detection, c, axis=1) >= 0).sum(1) >= 2)
    own, row = images.near(cloud.frame * len(images.P) + c, uv[:, 0], np.full(len(uv), APART))
    there = np.zeros(len(uv), bool)
    there[own[np.linalg.norm(images.uv[row] - uv[own], axis=1) < APART]] = True
    during = (cloud.frame >= stretch.first) & (cloud.frame < stretch.stop)
    shares = [there[inside & when].mean() if (inside & when).sum() >= LEAST_POINTS else np.nan
              for when in (during, ~during)]  # fmt: skip
    markers = (inside & during).sum() / (stretch.stop - stretch.first)
    return bool(shares[0] < LEFT * shares[1] and (1 - shares[1]) ** markers < CHANCE)


def _fits_adjusted(c: int, images: Images, detections: Detections, rig: Rig) -> bool:
    """Whether a camera fits the others where the rig is adjusted to the lines of all: a file that is off by little has
    images nowhere where points of other cameras want them."""
    adjusted = adjusted_rig(images, rig, sampled_frames(images))
    return not any(one.camera == c for one in unfitting_stretches(detections, adjusted))


def is_followed(stretch: Stretch, tracks: Tracks, detections: Detections) -> bool:
    """Whether tracks that were made with the camera hold nearly as many of its images as in other frames (5)."""
    c, cloud = stretch.camera, tracks.cloud
    during = np.zeros(detections.n_frames, bool)
    during[stretch.first : stretch.stop] = True
    tracked = np.bincount(cloud.frame[cloud.detection[:, c] >= 0], minlength=detections.n_frames)
    seen = detections.keep(detections.valid).counts[c]
    inside, outside = (tracked[when].sum() / max(seen[when].sum(), 1) for when in (during, ~during))
    return bool(inside > FOLLOWED * outside)


def _sampled(frames: range, counts: Ints) -> list[int]:
    """Some of these frames, of no period, by the counts (C, F) of their images."""
    step = max(1, int(counts[:, frames.start : frames.stop].sum() // SAMPLED_IMAGES))
    return (frames.start + scattered(len(frames), max(len(frames) // step, 1))).tolist()


def _fit(images: Images, F: Floats, counts: Ints, frames: list[int]) -> tuple[Floats, Floats, Floats]:
    """n of (1), its variance by chance, and #, (C, C) each, in frames (n) with counts (C, n) of images."""
    C, some = len(images.P), residuals(images, F, frames)
    number, off = pair_of(some, C), np.abs(some.off)
    share = NEAR / (WINDOW - APART)
    near, far = (np.bincount(number[own], minlength=C * C).reshape(C, C) for own in (off < NEAR, off > APART))
    possible = np.minimum(counts[:, None], counts[None]).sum(-1) * (1.0 - np.eye(C))
    n, chance = near - share * far, near + share**2 * far
    return n + n.T, chance + chance.T, possible


def _lost(n: Floats, chance: Floats, possible: Floats) -> Bools:
    """(C, parts) by (2), of (parts, C, C): the camera that fits worst first, the others then without it."""
    parts, C = n.shape[:2]
    out, left = np.zeros((C, parts), bool), np.arange(C)
    while len(left) >= min(C, LEAST_CAMERAS):
        each = [_lost_of(c, left, n, chance, possible) for c in left.tolist()]
        worst = int(np.argmax([loss for _, loss in each]))
        if not each[worst][0].any():
            break
        out[left[worst]] = each[worst][0]
        left = np.delete(left, worst)
    return out


def _lost_of(c: int, left: Ints, n: Floats, chance: Floats, possible: Floats) -> tuple[Bools, float]:
    """(parts) in which camera c of those that are left is lost, and how many pairs of one marker that makes."""
    others = left[left != c]
    own, seen = n[:, c, others].sum(-1), possible[:, c, others].sum(-1)
    q = own / np.maximum(seen, 1.0)
    rest = (each[:, others][:, :, others].sum((1, 2)) for each in (n, possible))
    q_rest = np.divide(*(np.maximum(each, low) for each, low in zip(rest, (0.0, 1.0), strict=True)))
    if not seen.any():
        return np.zeros(len(n), bool), 0.0
    enough = seen >= SEEN * np.median(seen[seen > 0])
    best, best_rest = max(np.quantile(q[enough], BEST), 0.0), np.quantile(q_rest[enough], BEST)
    good = q > DOUBTFUL * best
    if best < FITTING * best_rest or not own[good].sum() > CLEAR * np.sqrt(chance[good][:, c, others].sum()):
        return np.zeros(len(n), bool), 0.0
    lost = _closed(enough & (q < LOST * best) & (q_rest >= KEPT * best_rest), ~good)
    return lost, float(((best - q) * seen)[lost].sum())


def _closed(lost: Bools, doubtful: Bools) -> Bools:
    """Parts (n) that are lost, with the doubtful ones between them and up to the ends; none that stand alone."""
    out = np.zeros(len(lost), bool)
    for a, b in true_runs(lost | doubtful):
        own = np.flatnonzero(lost[a:b])
        if len(own) >= LEAST_PARTS:
            out[a if a == 0 else a + own[0] : b if b == len(lost) else a + own[-1] + 1] = True
    return out
