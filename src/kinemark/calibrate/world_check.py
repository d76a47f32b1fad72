"""Whether what shows the world, an L-frame or surveyed points, fits the rig that a wand gave before.

It is recorded apart from the wand: a camera may have been touched between, or its file be another camera's, and a point
may be surveyed or typed wrongly. Each moves the whole world, and no image of the wand knows of it.

Points are seen at (C, M) pixels and found from some cameras by triangulation. Of these cameras each is off by

    d_c = median over points of |seen − projected|, px                  (1)

and the worst of them says how well they agree. Where that is too much, the camera without which the others agree best
is the odd one; where they then agree, and without no other, it is known (2).

A camera that sees more markers than there are points may see reflections and no point: its images count where they lie
off by the same (2a).

Of points that were seen and surveyed the residual of laying the ones on the others is r mm RMS. Where that is too much,
the point without which it is least is left out, as long as that halves it (3). Too much is what neither the survey nor
the images explain: far from the cameras, and in a wide field, more is well.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import Detections, Rig
from ..data.array_types import Bools, Floats
from ..geometry import project, refine, triangulate, undistort
from ..geometry.camera import in_image
from ..numerics.evenly import evenly
from ..numerics.finite import finite_median
from .world_frame import laid_on

OFF_PX, OFF_RATIO = 2.0, 4.0
"""How far images may lie beside, px, and times the median residual of the calibration; chosen (see
tests/calibrate/test_world_check.py): untouched ones are up to 0.7 px off, and the lens is extrapolated on the floor."""
OFF_MM = 5.0
"""RMS by which surveyed points may differ from those seen; chosen: balls are surveyed to 1 or 2 mm."""
OFF_SHARE = 0.005
"""The same, as a share of the points' RMS distance from their middle; chosen: a tape is good to 0.2 %."""
OFF_SDS = 3.0
"""The same, in standard uncertainties of the points seen; by definition."""
ALIKE = 0.2
"""Share of their median by which the images of a camera may lie off differently; chosen: a camera that was turned
shifts all images of an L-frame by like amounts, and reflections lie anywhere."""
HALVED = 0.5
"""Share of the residual that is left without a point that is wrong; chosen."""
FEWEST_POINTS = 4
"""That are kept: with three, of known size, one of them cannot be told from the others; by definition."""
LEAST_PX = 0.01
"""Noise of an image at least; by definition: none is seen better."""
MOST_FRAMES = 50
"""Frames whose images are looked at, spread evenly; chosen for speed."""


class OddCamera(NamedTuple):
    """Cameras that do not agree on points: the one (index) that is odd, None where nobody knows; how far off, px."""

    camera: int | None
    px: float


class WrongPoints(NamedTuple):
    """Surveyed points: which (M) are kept; RMS residual of these, mm; how far each (M) lies from where they say, mm;
    and the residual, mm, up to which they agree."""

    kept: Bools
    rms_mm: float
    off_mm: Floats
    limit_mm: float


def odd_camera(rig: Rig, uv: Floats) -> OddCamera | None:
    """Which camera does not see points where the others do, by (1) and (2); None where all agree.

    Args:
        rig: C cameras.
        uv: (C, M, 2) px where points are seen, as the lens draws them; NaN where they are not.
    """
    everyone = np.isfinite(_off(rig, uv, np.ones(len(rig), np.bool_)))
    if not everyone.any():  # no point is seen by two
        return None
    residual = np.array([camera.residual for camera in rig])
    limit = max(OFF_PX, OFF_RATIO * finite_median(residual, 0.0))
    px = _worst(rig, uv, everyone)
    if not px > limit:
        return None
    without = {int(c): _worst(rig, uv, everyone & (np.arange(len(rig)) != c)) for c in np.flatnonzero(everyone)}
    odd, *others = sorted(without, key=without.__getitem__)
    if without[odd] > limit or any(without[c] <= limit for c in others):  # of three, two may agree by chance
        return OddCamera(None, px)
    apart = float(_off(rig, uv, everyone & (np.arange(len(rig)) != odd))[odd])
    return OddCamera(odd, apart if np.isfinite(apart) else px)


def _worst(rig: Rig, uv: Floats, used: Bools) -> float:
    """The greatest (1) of the cameras used (C), of points that two of them see; infinite where there are none."""
    off = _off(rig, uv, used)[used]
    return float(np.nanmax(off)) if np.isfinite(off).any() else np.inf


def _off(rig: Rig, uv: Floats, used: Bools) -> Floats:
    """(1) of each camera (C), of points that follow from those used (C); NaN where it sees none of them."""
    seen = np.where(used[:, None, None], uv, np.nan)
    ideal = np.stack([undistort(camera, at) for camera, at in zip(rig, seen, strict=True)], 1)
    xyz = triangulate(ideal, rig.P)
    apart = np.stack([np.linalg.norm(at - project(camera, xyz), axis=1) for camera, at in zip(rig, uv, strict=True)])
    return np.array([finite_median(row) for row in apart])


def images_of_resting(rig: Rig, detections: Detections, xyz: Floats) -> Floats:
    """Where cameras see points (M, 3) that rest over the recording: (C, M, 2) px, the median of the nearest detections.

    NaN for points outside an image, and for a camera that sees fewer than M markers in most frames, or more of which
    the nearest lie off in no common way (2a).
    """
    uv = np.full((len(rig), len(xyz), 2), np.nan)
    frames = evenly(detections.n_frames, MOST_FRAMES)
    for c, camera in enumerate(rig):
        there = [detections.uv[_valid(detections, c, int(f))] for f in frames]
        full = [seen for seen in there if len(seen) >= len(xyz)]
        if 2 * len(full) <= len(there):
            continue
        expected = project(camera, xyz)
        for m, at in enumerate(expected):
            if np.isfinite(at).all() and in_image(camera.size.tolist(), *at.tolist()):
                near = [seen[np.linalg.norm(seen - at, axis=1).argmin()] for seen in full]
                uv[c, m] = np.median(near, axis=0)
        if np.median([len(seen) for seen in full]) > len(xyz) and not _alike(uv[c] - expected):
            uv[c] = np.nan
    return uv


def _alike(off: Floats) -> bool:
    """Whether images are off (M, 2) px by about the same, NaN aside (2a)."""
    off = off[np.isfinite(off).all(1)]
    if not len(off):
        return True
    middle = np.median(off, axis=0)
    apart = np.linalg.norm(off - middle, axis=1)
    return bool(apart.max() <= max(OFF_PX, ALIKE * float(np.linalg.norm(middle))))


def _valid(detections: Detections, c: int, f: int) -> slice | Bools:
    """Rows of camera c in frame f that may be markers."""
    first, stop = detections.start[c, f], detections.start[c, f + 1]
    rows = np.zeros(len(detections.uv), np.bool_)
    rows[first:stop] = detections.valid[first:stop]
    return rows


def seen_within(rig: Rig, xyz: Floats, uv: Floats) -> float:
    """RMS uncertainty of points seen at (C, M, 2) px and found at xyz (M, 3), mm, if images are as good as they agree.

    NaN where no two cameras see a point.
    """
    beside = uv - np.stack([project(camera, xyz) for camera in rig])
    there: Bools = np.isfinite(beside[..., 0])
    freedom = int((2 * there.sum(0) - 3).clip(0).sum())
    if not freedom:
        return np.nan
    variance = float((beside[there] ** 2).sum()) / freedom
    cov = np.broadcast_to(max(variance, LEAST_PX**2) * np.eye(2), (len(xyz), len(rig), 2, 2))
    found = refine(rig, xyz, np.where(there[..., None], uv, np.nan).transpose(1, 0, 2), cov, steps=0)
    return float(np.sqrt(np.nanmean(np.trace(found.cov, axis1=1, axis2=2))))


def wrong_points(seen: Floats, known: Floats, *, scale: bool = False, within: float = 0.0) -> WrongPoints:
    """Which surveyed points (M, 3) mm are not where they are seen (M, 3), by (3).

    Args:
        seen: in the rig's world, no NaN.
        known: in the world that is wanted.
        scale: whether lengths may change.
        within: RMS uncertainty of where they are seen, mm.

    Raises:
        ValueError: the shapes differ.
        KinemarkError: as `similarity`, fewer than three points or points on a line.
    """
    kept: Bools = np.ones(len(seen), np.bool_)
    rms = _rms(seen, known, kept, scale)
    size = float(np.sqrt(((known - known.mean(0)) ** 2).sum(1).mean()))
    limit = max(OFF_MM, OFF_SHARE * size, OFF_SDS * np.nan_to_num(within))
    while rms > limit and kept.sum() > FEWEST_POINTS:
        without = {int(i): _rms(seen, known, kept & (np.arange(len(seen)) != i), scale) for i in np.flatnonzero(kept)}
        odd = min(without, key=without.__getitem__)
        if without[odd] > HALVED * rms:
            break
        kept[odd], rms = False, without[odd]
    A, b, s = laid_on(seen[kept], known[kept], scale=scale)
    return WrongPoints(kept, rms, np.linalg.norm(s * seen @ A.T + b - known, axis=1), limit)


def _rms(seen: Floats, known: Floats, kept: Bools, scale: bool) -> float:
    """The residual of the points kept (M), RMS mm, for one degree of freedom each."""
    A, b, s = laid_on(seen[kept], known[kept], scale=scale)
    squares = float(((s * seen[kept] @ A.T + b - known[kept]) ** 2).sum())
    return float(np.sqrt(3 * squares / (3 * int(kept.sum()) - 6 - scale)))
