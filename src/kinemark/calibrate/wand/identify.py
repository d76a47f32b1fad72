"""The markers of a waved wand in the detections of all cameras: which blob is which marker, in all cameras alike.

1. Strobes and reflections that stand still: places in an image where a point is seen in more than `STILL` of the
   frames. Points there are dropped.
2. Frames in which a camera then sees more than `MOST` points are left out for that camera.
3. Each image alone: markers in a row with the wand's gaps (`rows`); of a wand with two markers, the images
   that have just two points.
4. Which end is which, across cameras (`ends`), where the gaps do not tell. What stays open is left out.

Rows that lack a marker, or have strays that look like one, are not read. Once there is a rig, they are
(`completion`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...data import Camera, Detections, KinemarkError
from ...data.array_types import Bools, Floats, Ints
from ...numerics.robust import SD_PER_MEDIAN
from .ends import FEWEST as FEWEST_SHARED
from .ends import agreed_ends, nearer_ends
from .rows import read_rows

STILL = 0.15  # of the frames in which a place shows a point that stands still; chosen (see benchmarks/bundle.py)
STILL_FRAMES = 10  # and at least so many; chosen (see benchmarks/bundle.py)
CELL = 6.0
"""px; a point that stands still stays within such a square; chosen (see benchmarks/bundle.py)."""
MOST = 12  # moving points in a frame above which the camera's frame is left out; chosen for speed
FEWEST = 12
"""Frames in which a camera must see the wand; chosen (see benchmarks/bundle.py)."""
CERTAIN = 9.0
"""Lead, as 2 ln of odds, from which an image's direction needs no other camera; chosen (see benchmarks/bundle.py)."""
CLEAR_ENDS = 2.0  # standard deviations of what depth does to ln (first gap / last gap); chosen: 95 % of images
WRONG_GAPS = 0.15
"""Of ln (first gap / last gap), on the median over all images; chosen (see benchmarks/bundle.py)."""


class Wanted(NamedTuple):
    """Detections that may be the wand, and how many frames each camera lost.

    use (D) are the rows to look at; crowded (C) counts frames with too many of them, still (C) rows that stand still.
    """

    use: Bools
    crowded: Ints
    still: Ints


def wand_points(detections: Detections, *, lengths: ArrayLike) -> tuple[Floats, Floats]:
    """The markers of a wand, as all cameras see it over F frames.

    Args:
        detections: of all cameras; invalid and merged ones are not looked at.
        lengths: (K − 1) gaps between the wand's K markers, mm; one to four gaps.

    Returns:
        uv (C, F, K, 2) px and their covariance cov (C, F, K, 2, 2) px²; NaN where not seen. Marker k is the same
        one in all cameras; of a wand that looks the same from both ends, in all cameras of one frame.

    Raises:
        ValueError: lengths are not one to four positive gaps.
        KinemarkError: a camera hardly ever sees the wand, or sees another one; the message says what it saw.
    """
    along = marker_places(lengths)
    rows = identify_wand(detections, wanted(detections), along)
    return at_rows(detections, rows)


def marker_places(lengths: ArrayLike) -> Floats:
    """(K) places of the markers along the wand, mm, from its gaps (K − 1), mm.

    Raises:
        ValueError: there are fewer than one or more than four gaps, or one is not above 0.
    """
    gaps = np.asarray(lengths, np.float64).reshape(-1)
    if not 1 <= len(gaps) <= 4 or not (np.isfinite(gaps).all() and (gaps > 0).all()):
        raise ValueError(f"lengths are {gaps.tolist()}, wanted one to four gaps between markers, mm, above 0")
    return np.concatenate([[0.0], np.cumsum(gaps)])


def at_rows(detections: Detections, rows: Ints) -> tuple[Floats, Floats]:
    """uv (…, 2) and cov (…, 2, 2) of rows (…), NaN where a row is −1."""
    seen = rows >= 0
    uv = np.where(seen[..., None], detections.uv[rows], np.nan)
    return uv, np.where(seen[..., None, None], detections.cov[rows], np.nan)


def wanted(detections: Detections) -> Wanted:
    """Steps 1 and 2."""
    use = detections.valid & ~detections.merged
    still = _still_points(detections, use)
    use &= ~still
    camera, frame = detections.camera, detections.frame
    counts = np.zeros((len(detections.cameras), detections.n_frames), np.int64)
    np.add.at(counts, (camera[use], frame[use]), 1)
    crowded = counts > MOST
    use &= ~crowded[camera, frame]
    return Wanted(use, crowded.sum(1), np.bincount(camera[still], minlength=len(counts)))


class WandReading(NamedTuple):
    """Step 3: the row of each marker (C, F, K), −1 where not seen; lead and ratio (C, F) as in `rows.Readings`."""

    rows: Ints
    lead: Floats
    ratio: Floats


def read_wand(detections: Detections, want: Wanted, along: Floats) -> WandReading:
    """Step 3; errors as in `wand_points`."""
    rows = np.full((len(detections.cameras), detections.n_frames, len(along)), -1, np.int64)
    lead, ratio = np.zeros(rows.shape[:2]), np.full(rows.shape[:2], np.nan)
    for c in range(len(rows)):
        rows[c], lead[c], ratio[c] = _read_camera(detections, want.use, c, along)
    reading = WandReading(rows, lead, ratio)
    _check_seen(detections, want, reading, along)
    return reading


def identify_wand(detections: Detections, want: Wanted, along: Floats, cameras: Sequence[Camera] | None = None) -> Ints:
    """Steps 3 and 4: the row of each marker (C, F, K), −1 where not seen, with the cameras (C) where they are known;
    errors as in `wand_points`."""
    rows, lead, _ = read_wand(detections, want, along)
    if (lead[rows[..., 0] >= 0] < CERTAIN).any():
        turned, undecided = agreed_ends(at_rows(detections, rows)[0], lead, cameras)
        read = rows[..., 0]
        rows = np.where(turned[..., None], rows[..., ::-1], rows)
        rows[undecided & (lead < CERTAIN)] = -1
        _check_decided(detections, rows, read)
    return rows


def with_open_ends(rows: Ints, read: Ints, detections: Detections, cameras: Sequence[Camera]) -> Ints:
    """Rows (C, F, K) with those that were `read` as well but whose ends nothing tells, by the ends that are nearer to
    what the cameras (C) expect: so also images that fit nothing, as those of a camera that was moved."""
    known: Bools = np.asarray((rows >= 0).all(2))
    turned = nearer_ends(at_rows(detections, np.where(known[..., None], rows, read))[0], known, cameras)
    return np.where(known[..., None], rows, np.where(turned[..., None], read[..., ::-1], read))


def _still_points(detections: Detections, use: Bools) -> Bools:
    """(D) points at a place of the image where one is seen in a large share of the frames.

    A square of `CELL` px may cut the place in two, so four grids are tried, shifted by half a square.
    """
    standing = np.zeros(len(detections), np.bool_)
    camera = detections.camera
    enough = max(STILL * detections.n_frames, STILL_FRAMES)
    at = np.flatnonzero(use & np.isfinite(detections.uv).all(1))
    for shift in ((0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5)):
        cell = np.floor(detections.uv[at] / CELL + shift).astype(np.int64)
        _, which, count = np.unique(
            np.column_stack([camera[at], cell]), axis=0, return_inverse=True, return_counts=True
        )
        standing[at] |= count[which.ravel()] > enough
    return standing


def _read_camera(detections: Detections, use: Bools, c: int, along: Floats) -> tuple[Ints, Floats, Floats]:
    """Rows (F, K), lead (F) and ratio (F) of one camera, all images with equally many points at once."""
    K, first, stop = len(along), detections.start[c, 0], detections.start[c, -1]
    mine = first + np.flatnonzero(use[first:stop])
    start = np.searchsorted(mine, detections.start[c])
    count = np.diff(start)
    rows = np.full((detections.n_frames, K), -1, np.int64)
    lead, ratio = np.zeros(len(rows)), np.full(len(rows), np.nan)
    for n in np.unique(count[count >= K]):
        frames = np.flatnonzero(count == n)
        points = mine[start[frames, None] + np.arange(n)]
        read = read_rows(detections.uv[points], along)
        rows[frames] = np.where(read.points >= 0, np.take_along_axis(points, read.points, 1), -1)
        lead[frames], ratio[frames] = read.lead, read.ratio
    return rows, lead, ratio


def wrong_gaps(ratio: Floats, along: Floats) -> str | None:
    """That the gaps in the images are not, on the median, in the proportion that they have on the wand; None where
    they are.

    An image shows the proportion times the ends' depths, and not from which end. A wand that is always held alike
    shows another one in all images, so this explains why there are no cameras; it does not keep any from being looked
    for. Once there are cameras, `stick_gaps` tells. Where depths outweigh how unequal the gaps are, as of equal ones,
    nothing follows.
    """
    seen = np.abs(ratio[np.isfinite(ratio)])
    gaps = np.diff(along)
    if len(gaps) < 2 or len(seen) < FEWEST:
        return None
    wanted_ratio = np.log(gaps[0] / gaps[-1])
    typical = float(np.median(seen))
    if abs(wanted_ratio) < CLEAR_ENDS * SD_PER_MEDIAN * np.median(np.abs(seen - typical)):
        return None
    if abs(typical - abs(wanted_ratio)) <= WRONG_GAPS:
        return None
    found = np.exp(np.copysign(typical, wanted_ratio))
    return (
        f"Rows of {len(along)} points are seen, but their first gap is {found:.2f} times their last one on the "
        f"median of {len(seen)} images, and the wand's lengths {', '.join(f'{mm:g}' for mm in gaps)} mm say "
        f"{np.exp(wanted_ratio):.2f}. Measure the wand again, from centre to centre, and give its gaps in order. "
        "If they are right, other points lie in a row: mask reflections, and wave longer where both its ends show."
    )


def _check_seen(detections: Detections, want: Wanted, reading: WandReading, along: Floats) -> None:
    """Every camera sees the wand often enough."""
    seen, K = (reading.rows[..., 0] >= 0).sum(1), len(along)
    if detections.n_frames < FEWEST:
        raise KinemarkError(
            f"The recording has {detections.n_frames} frames; {FEWEST} are needed. Wave the wand longer."
        )
    for c in np.flatnonzero(seen < FEWEST):
        raise KinemarkError(
            wrong_gaps(reading.ratio, along)
            or f"Camera {detections.cameras[c]} sees the wand's {K} markers in {seen[c]} of {detections.n_frames} "
            f"frames; {FEWEST} are needed. {_why_unseen(detections, want, int(c), K)}"
        )


def _why_unseen(detections: Detections, want: Wanted, c: int, K: int) -> str:
    mine = slice(detections.start[c, 0], detections.start[c, -1])
    count = np.bincount(detections.frame[mine][want.use[mine]], minlength=detections.n_frames)
    few, many = int((count < K).sum() - want.crowded[c]), int((count > K).sum() + want.crowded[c])
    if want.crowded[c] > detections.n_frames / 2:
        return (
            f"In {want.crowded[c]} frames it sees more than {MOST} points that move. Raise its threshold, mask "
            "reflections, or limit the size of markers."
        )
    if many > few:
        return (
            f"In {many} frames it sees more than {K} points. Mask reflections, take other markers out of the volume, "
            "or wave a wand with three markers in unequal gaps."
        )
    if want.still[c] >= few:
        return (
            f"In {few} frames it sees fewer than {K} points that move; {want.still[c]} points that stand still count "
            "as reflections. Wave the wand without rest, across this camera's image as well as towards it."
        )
    return (
        f"In {few} frames it sees fewer than {K} points. Wave the wand where this camera sees it, lower its threshold, "
        "set inverted = true in [detect] where markers are dark on bright ground, or leave the camera out."
    )


def _check_decided(detections: Detections, rows: Ints, read: Ints) -> None:
    """Every camera has frames in which the ends are told apart, of those where it `read` (C, F) a wand."""
    seen = (read >= 0).astype(np.int64)
    shared = seen @ seen.T
    np.fill_diagonal(shared, 0)
    for c in np.flatnonzero((rows[..., 0] >= 0).sum(1) < FEWEST):
        head = f"Camera {detections.cameras[c]} sees what may be the wand"
        if (most := int(shared[c].max())) < FEWEST_SHARED:
            raise KinemarkError(
                f"{head}, but in at most {most} frames together with another camera; {FEWEST_SHARED} are needed to "
                "tell which end is which. Wave the wand longer, where two cameras see it at once; one with two markers "
                "is read only where nothing else shines: mask reflections, also those of the floor."
            )
        raise KinemarkError(
            f"{head}, but no other camera's view tells which end is which. Wave the wand, turning it in all "
            "directions, where this camera and others see it at once; mask reflections, and take other markers out of "
            "the volume."
        )
