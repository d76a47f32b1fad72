"""Cameras whose images fit no other's in the whole recording: bumped, of another calibration, or of other times.

With n of the pairs of images of one marker and # of those that there might be (`unfitting_stretches` (1)), camera c is
suspected where

    Q_c = Σ_s n_cs / Σ_s #_cs  is less than MISFIT of what it is of the other cameras among themselves     (1)

Who sees a side of the subject that no other camera sees has a small Q_c as well. So all is tracked without the camera.
Then S(d) is the share of the points in its view that have an image at d px from where they should, within a box. Images
of these markers make a peak of S where they lie, those of others a floor all over. With S' the highest of S farther
than BESIDE from 0, and S'' the next that is as far from that, the camera lies beside by the d of S', or nowhere, where

    S' > STANDS_OUT · max(S'', S(0)),   or   S(0) < S' < STANDS_OUT · S''                                  (2)

and is left out where the others agree: where the whole calibration is off, each of them seems to lie beside. With σ
the noise of the others by epipolar lines (`epipolar_noise`), in the median camera,

    |d| > APART · σ,   or, where it lies nowhere,   σ < AGREEING                                          (3)

About a subject who hides the cameras from each other few points have a third image, and S tells of chance: another
marker of who stands in one place keeps beside a point. Of tracks with h points each that have such an image, S' counts
where

    (Σ h)² / Σ h²,  how many tracks make it,  is MARKERS and more                                         (4)

A camera lies nowhere only if no camera of the tracks is its partner (`epipolar_noise` (7)), two of the others are
partners, and one of these has SHARED of its images in the tracks and more (5): cameras that see hardly a marker
together do not tell of a third.

As images that are up to a frame late or early are where the points were or will be, S(0) is the highest at such times:
delays are learned. A camera that was bumped along the lines of the others has a high Q_c, and is suspected where it
lies beside by (2) of the tracks that its own images have led astray.

What is suspected and not left out stays in doubt where it has no partner, and hardly a point of it has images of two
others (6): two images nearly meet wherever cameras stand.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ....data import Tracks
from ....data.array_types import Bools, Floats, Ints
from ..detection_index import Images
from ..following.associate import places_in_image
from ..following.candidate_points import fundamentals
from ..noise.epipolar_noise import camera_noise, mixture, pair_of, partners, residuals
from ..noise.measurement_noise import sampled_frames

MISFIT = 0.45
"""Of (1); chosen on scenes 160000 to 160059 of the second generator: 26 good rigs had 0.59 and more, of cameras that
were bumped by 12 px 23 had -0.15 to 0.32, those bumped along the lines of others 0.6 to 0.8."""
SURE = 5.0
"""Standard deviations of chance that n of the other cameras must be; chosen."""
STEP, MIDDLE = 2.0, 30
"""px between the d that are looked at, chosen: a box of three by three holds the images of one marker; and how many
there are to either side, chosen: by a turn of some 3°."""
BESIDE = 5.0
"""px in either axis, up to which boxes are one peak; chosen: boxes that overlap less than a third."""
STANDS_OUT = 2.0
"""Of (2); chosen on scenes 160000 to 160029: S(0) of good cameras was 2.8 to 98 times S', of bumped ones 0.0 to 0.2."""
APART, AGREEING = 20.0, 0.8
"""Of (3), and px; chosen on scenes 177000 to 178004: of cameras bumped by 12 px |d| / σ was 27 and more with σ of 0.28
to 0.37 px, of calibrations that were 2.5 to 4 px off it was 16 or less, with σ of 0.73 to 1.81 px. Before three
cameras all round with files .1 to .6 px off, one of them wrong, the two others have σ up to 0.76, and files 1 to 2 px
off mostly 0.8 and more."""
TIMES = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Frames, at which S(0) is looked for; chosen: what `learned_delays` can learn."""
MARKERS = 2.5
"""Of (4); chosen on three-second walks and stands before three to six cameras, each marker hidden by the body from
those behind it: one marker's neighbours made 1.0 to 1.6 of good cameras, bumped and moved ones had 3.3 to 10.9."""
CONFIRMED = 0.15
"""Of (6), the share of a camera's points that is enough; chosen on three-second walks and stands before three cameras:
cameras turned by 1 to 3° or of other files had 0.0 to 0.1, mostly; right ones that were suspected 0.2 to 0.8, or 0.0
where nothing is in view of three."""
SHARED = 0.2
"""Of (5); chosen on stands of 20 to 60 markers before three cameras all round, files 0.3 to 1 px off: two good cameras
were left out by two others with 0.10 and 0.14; nine wrong ones by 0.24 to 0.74, and six by 0.10 to 0.14."""
LEAST_POINTS, LEAST_MARKERS, MOST_POINTS = 100, 5, 5000
"""Points in view, and tracks, from which on S tells, chosen: of one marker that hides, another's image is beside; and
points that are looked at, chosen: more say the same."""


def misfitting(n: Floats, chance: Floats, possible: Floats, left: Ints) -> list[int]:
    """Of cameras that are left those by (1), each time the one without which the others agree best.

    Args:
        n, chance, possible: (C, C) n, its variance by chance and # in the whole recording.
    """
    found = list[int]()
    while len(left) > 2:
        agreeing = {c: _agreement(c, left[left != c].tolist(), n, chance, possible) for c in left.tolist()}
        suspected = [c for c, (own, others) in agreeing.items() if own < MISFIT * others]
        if not suspected:
            break
        found.append(max(suspected, key=lambda c: agreeing[c][1]))
        left = left[left != found[-1]]
    return found


def _agreement(c: int, others: list[int], n: Floats, chance: Floats, possible: Floats) -> tuple[float, float]:
    """Q_c, and that of the others; 0 for both where these agree no better than by chance, or c sees nothing."""
    own, rest = possible[c, others].sum(), np.ix_(others, others)
    if not own or n[rest].sum() <= SURE * np.sqrt(chance[rest].sum()):
        return 0.0, 0.0
    return float(n[c, others].sum() / own), float(n[rest].sum() / possible[rest].sum())


class Peaks(NamedTuple):
    """Of a camera S(0), and S' of (2); whether S' is clear of S'' and of enough tracks; the d of S' (2) px."""

    here: float
    beside: float
    clear: bool
    offset: Floats


def beside_tracks(tracks: Tracks, images: Images) -> list[int]:
    """Cameras whose images, many, lie beside the points of tracks that were made with them, the most of them first.

    A camera that was turned takes others' images along, so that these may lie beside as well.
    """
    C = len(images.P)
    found = [(c, peaks) for c in range(C) if (peaks := _peaks(c, tracks, images)) is not None] if C > 2 else []
    beside = [(peaks.beside, c) for c, peaks in found if peaks.clear and peaks.beside > STANDS_OUT * peaks.here]
    return [c for _, c in sorted(beside, reverse=True)]


def image_offset(c: int, tracks: Tracks, images: Images) -> Floats | None:
    """(2) px by which a camera's images lie beside the points; NaN where they lie nowhere; None where they fit, by (2).

    Args:
        c: the camera. tracks: of the other cameras. images: of all cameras.
    """
    peaks = _peaks(c, tracks, images)
    if peaks is None:
        return None
    if peaks.clear:
        return peaks.offset if peaks.beside > STANDS_OUT * peaks.here else None
    if peaks.here >= peaks.beside:
        return None
    together = _partners(images)
    seen = (np.delete(tracks.cloud.detection, c, axis=1) >= 0).any(0)  # two cameras that are exchanged may be partners
    with_c, among = np.delete(together[c], c), np.delete(np.delete(together, c, 0), c, 1)
    if (with_c & seen).any() or not among.any() or _share_in_tracks(c, tracks, images) < SHARED:
        return None
    return np.full(2, np.nan)


def _share_in_tracks(c: int, tracks: Tracks, images: Images) -> float:
    """How many of its images the camera beside c has in the tracks that has the most of them there."""
    seen, n = (tracks.cloud.detection >= 0).sum(0), np.bincount(images.camera[images.usable], minlength=len(images.P))
    return float(np.delete(seen / np.maximum(n, 1), c).max(initial=0.0))


def stands_apart(offset: Floats | None, others: Images) -> bool:
    """Whether a camera that lies beside does so by far more than the others disagree (3).

    Args:
        offset: of `image_offset`. others: the images of the cameras that are not left out.
    """
    if offset is None:
        return False
    some, C = residuals(others, fundamentals(others.P), sampled_frames(others)), len(others.P)
    variance = camera_noise(some, mixture(some.off, pair_of(some, C), C * C, some.window), C).variance
    sd = np.sqrt(np.median(variance[np.isfinite(variance)])) if np.isfinite(variance).any() else np.inf
    far = float(np.linalg.norm(offset))
    return bool(sd < AGREEING if np.isnan(far) else far > APART * sd)


def is_confirmed(c: int, tracks: Tracks, images: Images) -> bool:
    """Whether enough of the points of a camera have images of two others, by (6), or one of these is its partner."""
    own = tracks.cloud.detection[tracks.cloud.detection[:, c] >= 0]
    confirmed = not len(own) or ((own >= 0).sum(1) > 2).mean() > CONFIRMED
    return bool(confirmed or _partners(images)[c].any())


def _partners(images: Images) -> Bools:
    """(C, C) `partners` of the cameras of these images."""
    frames = sampled_frames(images)
    return partners(residuals(images, fundamentals(images.P), frames), len(images.P), len(frames))


def _peaks(c: int, tracks: Tracks, images: Images) -> Peaks | None:
    """S of a camera; None where too few points are in its view."""
    cloud = tracks.cloud
    uv, has = places_in_image(images.P[c], cloud.xyz), cloud.detection >= 0
    inside = ((uv >= 0) & (uv < images.size[c])).all(1) & (has.sum(1) - has[:, c] >= 2)
    if inside.sum() < LEAST_POINTS or len(np.unique(tracks.id[inside])) < LEAST_MARKERS:
        return None
    rows = np.flatnonzero(inside)
    rows = rows[:: -(-len(rows) // MOST_POINTS)]
    step, cell = _steps(tracks, uv)[rows], cloud.frame[rows] * len(images.P) + c
    shares = _shares(images, cell, uv[rows])
    here = max(float(_shares(images, cell, uv[rows] + t * step, 2 * STEP)[MIDDLE, MIDDLE]) for t in TIMES)
    beside = np.where(_around(shares, MIDDLE, MIDDLE), 0.0, shares)
    u, v = (int(k) for k in np.unravel_index(int(beside.argmax()), shares.shape))
    d = STEP * (np.array([u, v]) - MIDDLE)
    many = _tracks_beside(images, cell, uv[rows] + d, tracks.id[rows]) >= MARKERS
    clear = many and beside[u, v] > STANDS_OUT * np.where(_around(beside, u, v), 0.0, beside).max()
    return Peaks(here, float(beside[u, v]), bool(clear), d)


def _tracks_beside(images: Images, cell: Ints, uv: Floats, id: Ints) -> float:
    """(4) of points (P) of tracks with an image at uv (P, 2) px."""
    own, row = images.near(cell, uv[:, 0], np.full(len(uv), 1.5 * STEP))
    there = np.unique(own[np.abs(images.uv[row, 1] - uv[own, 1]) < 1.5 * STEP])
    h = np.bincount(id[there]).astype(float)
    return float(h.sum() ** 2 / max((h**2).sum(), 1.0))


def _steps(tracks: Tracks, uv: Floats) -> Floats:
    """(P, 2) px by which the points at uv (P, 2) go on to the next frame; 0 where a track ends."""
    order = np.lexsort([tracks.cloud.frame, tracks.id])
    a, b = order[:-1], order[1:]
    on = (tracks.id[a] == tracks.id[b]) & (tracks.cloud.frame[a] + 1 == tracks.cloud.frame[b])
    step = np.zeros_like(uv)
    step[a[on]] = uv[b[on]] - uv[a[on]]
    return step


def _around(shares: Floats, u: int, v: int) -> Bools:
    """Where in S (n, n) d is within BESIDE of a row and column, in both axes."""
    place = STEP * np.arange(len(shares))
    return np.asarray((np.abs(place - place[u]) <= BESIDE)[:, None] & (np.abs(place - place[v]) <= BESIDE))


def _shares(images: Images, cell: Ints, uv: Floats, reach: float = STEP * MIDDLE) -> Floats:
    """S (n, n) of points at uv (P, 2) px in cells (P) of `Images`, d by rows u and columns v, 0 at MIDDLE; of images
    that lie as far as `reach` px in u."""
    own, row = images.near(cell, uv[:, 0], np.full(len(uv), reach))
    n = 2 * MIDDLE + 3  # with an edge of nothing
    u, v = np.floor((images.uv[row] - uv[own]).T / STEP + (MIDDLE + 1.5)).astype(np.int64)
    within = (u > 0) & (v > 0) & (u < n - 1) & (v < n - 1)
    count = np.bincount(u[within] * n + v[within], minlength=n * n).reshape(n, n)
    return np.asarray(sliding_window_view(count, (3, 3)).sum((2, 3)) / max(len(uv), 1))
