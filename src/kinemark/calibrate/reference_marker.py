"""Fixed marks that tell how far an image has shifted since the calibration (UM²AS 2.3, 3.4: the files *.rf).

Film lies a little otherwise in the digitiser each time, tape is grabbed a line earlier or later, and a camera's foot is
touched. A mark that does not move in the laboratory shows it: of K marks seen at b_k when the camera was calibrated
and at n_k now,

    n_k = b_k + s,    s = mean over k of n_k − b_k                       (1)

and s is taken from all that the camera sees (2). A mark that is further than twice the tolerance from the median of
n_k − b_k in a frame, another thing taken for it, does not count there, nor does its place. A camera that turned about
its own axis or was zoomed does not shift its image, and the marks say so by how far they are from a common shift,

    spread² = Σ |n_k − b_k − s|² / (K − 1),                              (3)

and the similarity n ≈ a b + c, in complex numbers, says what happened: |a| − 1 is the zoom and arg a the turn (4).
One mark alone cannot tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy

from ..data import Detections, KinemarkError
from ..data.array_types import Floats
from ..data.arrays import check_positive
from ..numerics.evenly import evenly

TOLERANCE = 3.0  # px within which a mark has not moved; chosen
REACH = 20.0  # px within which a mark that moved is looked for; chosen
MOST_FRAMES = 400  # frames that are looked at, spread evenly; chosen for speed
NEARLY_AS_MANY = 0.8  # of the most marks that agree on a shift; chosen
OFTEN = 0.5  # of the frames in which a mark must be seen; chosen
FAR = 2.0  # times the tolerance, beyond which an image is another thing; chosen


class MarkShift(NamedTuple):
    """Shifts (C, 2) or (C, F, 2) px; spread (C) px of (3), over all frames, NaN where one mark is all there is."""

    shift: Floats
    spread: Floats


def reference_shift(
    before: Floats, now: Floats, *, tolerance: float = TOLERANCE, names: Sequence[str] | None = None
) -> Floats:
    """How far the images have shifted, (C, 2) px; one shift a frame, (C, F, 2), where `now` has frames.

    Args:
        before: (C, K, 2) the fixed marks when the cameras were calibrated, px; NaN where not seen.
        now: (C, K, 2), or (C, F, K, 2), the same marks in the recording, px; NaN where not seen. A frame in
            which a camera sees none takes its shift from the frames around it.
        tolerance: the greatest `spread`, px, at which marks still agree.
        names: (C) of the cameras for messages; their numbers from 1 without.

    Raises:
        ValueError: the arrays do not fit each other.
        KinemarkError: a camera sees no mark, or its marks moved differently.
    """
    return mark_shift(before, now, tolerance=tolerance, names=names).shift


def mark_shift(
    before: Floats, now: Floats, *, tolerance: float = TOLERANCE, names: Sequence[str] | None = None
) -> MarkShift:
    """As `reference_shift`, with the marks' spread about it; arguments and errors as there."""
    check_positive(tolerance=tolerance)
    if before.ndim != 3 or before.shape[2] != 2 or now.ndim not in (3, 4) or now.shape[-2:] != before.shape[1:]:
        raise ValueError(f"before has shape {before.shape} and now {now.shape}, wanted (C, K, 2) and (C, [F,] K, 2)")
    if len(before) != len(now):
        raise ValueError(f"before has {len(before)} cameras and now {len(now)}, wanted the same")
    films = now if now.ndim == 4 else now[:, None]
    moved = films - before[:, None]
    called = names if names is not None else [str(c + 1) for c in range(len(now))]
    shift = (
        np.stack([_shift_of(called[c], film, tolerance) for c, film in enumerate(moved)])
        if len(moved)
        else np.zeros((0, 1, 2))
    )
    spread = np.array([_spread(film, s) for film, s in zip(moved, shift, strict=True)])
    for c, s in enumerate(spread):
        if s > tolerance:
            raise KinemarkError(_disagreement(called[c], before[c], films[c], float(s), tolerance))
    return MarkShift(shift if now.ndim == 4 else shift[:, 0], spread)


def corrected(detections: Detections, shift: Floats) -> Detections:
    """The detections where they would have been seen without the shift, (C, 2) or (C, F, 2) px.

    Raises:
        ValueError: the shift is of other cameras or frames, or not finite.
    """
    c, f = len(detections.cameras), detections.n_frames
    if shift.shape not in ((c, 2), (c, f, 2)) or not np.isfinite(shift).all():
        raise ValueError(f"shift has shape {shift.shape}, wanted ({c}, 2) or ({c}, {f}, 2), all finite")
    moved = shift[detections.camera] if shift.ndim == 2 else shift[detections.camera, detections.frame]
    return replace(detections, uv=detections.uv - moved)


def find_marks(detections: Detections, before: Floats, *, reach: float = REACH, still: float = TOLERANCE) -> Floats:
    """Where the fixed marks are in a recording: (C, F, K, 2) px, NaN where a mark is not seen.

    Args:
        detections: F frames of all cameras.
        before: (C, K, 2) where the marks were seen, px; NaN for a mark that a camera does not see.
        reach: no image shifts further, px.
        still: marks stay this near their place, px, during the recording.

    All marks of a camera shift alike and stay, so the true shift is the one at which most detections of all frames and
    marks lie; of two places as good, the nearer one.

    Raises:
        ValueError: `before` is of other cameras.
        KinemarkError: a mark is seen in less than half of the frames.
    """
    check_positive(reach=reach, still=still)
    if before.ndim != 3 or before.shape[::2] != (len(detections.cameras), 2):
        raise ValueError(f"before has shape {before.shape}, wanted ({len(detections.cameras)}, K, 2)")
    found = np.full((len(before), detections.n_frames, before.shape[1], 2), np.nan)
    for c, places in enumerate(before):
        shift = _common_shift(detections, c, places, reach, still)
        for f in range(detections.n_frames if shift is not None else 0):
            uv = detections[c, f]
            distance = np.linalg.norm(uv[:, None] - (places + shift), axis=-1)  # (n, K)
            for k in np.flatnonzero(distance.min(0, initial=np.inf) <= still):
                found[c, f, k] = uv[distance[:, k].argmin()]
        seen = np.isfinite(found[c, :, :, 0]).mean(0)
        for k in np.flatnonzero(np.isfinite(places[:, 0]) & (seen <= OFTEN)):
            raise KinemarkError(
                f"Camera {detections.cameras[c]}: its fixed mark {k + 1} is seen within {reach:g} px of where it was "
                f"in {100 * seen[k]:.0f} % of the frames only. Is it covered, or has the camera been turned? Point at "
                "it again, or leave this mark out."
            )
    return found


def _common_shift(detections: Detections, c: int, places: Floats, reach: float, still: float) -> Floats | None:
    """(2,) px; the densest place among differences of detections from all marks, if there is any."""
    frames = evenly(detections.n_frames, MOST_FRAMES)
    uv = np.concatenate([detections[c, f] for f in frames if f >= 0] or [np.zeros((0, 2))])
    offset = (uv[:, None] - places[np.isfinite(places[:, 0])]).reshape(-1, 2)
    offset = offset[np.linalg.norm(offset, axis=1) <= reach]
    if len(offset) == 0:
        return None
    tree = scipy.spatial.KDTree(offset)
    many = tree.query_ball_point(offset, still, return_length=True)
    good = offset[many >= NEARLY_AS_MANY * many.max()]
    nearest = good[np.linalg.norm(good, axis=1).argmin()]
    return np.asarray(np.median(offset[tree.query_ball_point(nearest, still)], axis=0))


def _shift_of(name: str, moved: Floats, tolerance: float) -> Floats:
    """(F, 2) from the marks' own displacements (F, K, 2), by (1)."""
    seen = np.isfinite(moved[..., 0]) & np.isfinite(moved[..., 1])
    known = seen.any(1)
    if not known.any():
        raise KinemarkError(f"Camera {name} sees none of the fixed marks. Place or find one that it sees.")
    shift = np.full((len(moved), 2), np.nan)
    there = np.where(seen[..., None], moved, np.nan)[known]
    median = np.nanmedian(there, axis=1, keepdims=True)
    near = np.linalg.norm(there - median, axis=-1, keepdims=True) <= FAR * tolerance
    none = ~near.any(1, keepdims=True)  # two marks that disagree are both counted, and refused by their spread
    shift[known] = np.nanmean(np.where(near | none, there, np.nan), axis=1)  # (1)
    frames = np.arange(len(moved))
    return np.stack([np.interp(frames, frames[known], shift[known, k]) for k in (0, 1)], 1)


def _spread(moved: Floats, shift: Floats) -> float:
    """(3) over all frames (F, K, 2); NaN where no frame has two marks."""
    residual = moved - shift[:, None]
    seen = np.isfinite(residual[..., 0]) & np.isfinite(residual[..., 1])
    both = seen.sum(1) >= 2
    freedom = int((seen[both].sum(1) - 1).sum())
    return float(np.sqrt(np.nansum(residual[both] ** 2) / freedom)) if freedom else float("nan")


def _disagreement(name: str, before: Floats, films: Floats, spread: float, tolerance: float) -> str:
    """What the marks (K, 2) and (F, K, 2) of a camera tell instead of a shift, by (4)."""
    at = np.array([np.nanmedian(p) if np.isfinite(p).any() else np.nan for p in films.reshape(-1, before.size).T])
    both = np.isfinite(at.reshape(-1, 2)).all(1) & np.isfinite(before).all(1)
    b, n = (p[both, 0] + 1j * p[both, 1] for p in (before, at.reshape(-1, 2)))
    b, n = b - b.mean(), n - n.mean()
    a = (b.conj() @ n) / (b.conj() @ b) if len(b) > 1 and np.abs(b).max() > 0 else 1.0 + 0j
    left = float(np.sqrt((np.abs(n - a * b) ** 2).sum() / max(len(b) - 1, 1)))
    what = (
        f"A turn of {np.degrees(np.angle(a)):.2f}° about its axis and a zoom by {abs(a):.4f} would explain it: the "
        "camera was moved. Calibrate it again."
        if left < spread / 5 and len(b) > 2
        else "Was the camera turned or zoomed, or a mark moved? Leave the wrong mark out, or calibrate again."
    )
    return (
        f"Camera {name}: its {len(b)} fixed marks did not shift alike but differ by {spread:.1f} px, and "
        f"{tolerance:g} px are allowed. {what}"
    )
