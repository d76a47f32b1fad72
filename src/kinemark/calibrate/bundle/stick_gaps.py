"""Where the markers of a stick are along it, by the images: a ruler is read wrong by a millimetre, images see it.

Each marker is placed on its own, by the cameras that see it. Gap k of a pose is g_k, and its share of the stick

    p_k = g_k / Σ g                                                      (1)

needs no scale. The median of p_k over n poses, times the stick's stated length L, is the gap seen, with the standard
deviation √(π / 2) s / √n of a median (2). Where stated gaps differ from these by more than chance, those seen
are taken: the length as a whole stays as stated, as nothing in the images tells it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...data import Camera, KinemarkError
from ...data.array_types import Floats
from ...numerics.robust import SD_PER_MEDIAN
from .robust_points import robust_points

FAR_OFF = 0.01
"""Of the image's diagonal; what a first guess, by wrong lengths too, is off at most; chosen (see
benchmarks/bundle.py)."""
FEWEST = 12  # sticks of which all markers are seen, to judge the gaps by; chosen (see benchmarks/bundle.py)
CERTAIN = 4.0
"""Standard deviations by which a gap must differ to be taken from the images; chosen (see benchmarks/bundle.py)."""
PLAUSIBLE = 0.03
"""Of the stick's length; a ruler is not read wrong by more: the markers are others, or in another order; chosen."""


class SeenGaps(NamedTuple):
    """Gaps (K − 1) between markers in order, mm, their standard deviations, and those stated."""

    gaps: Floats
    sd: Floats
    stated: Floats


def seen_gaps(cameras: Sequence[Camera], uv: Floats, along: Floats) -> SeenGaps | None:
    """The gaps of a stick with markers at `along` (K) mm, seen at uv (C, N, 2) px; None where too few poses tell."""
    order = np.argsort(along)
    limit = [FAR_OFF * np.hypot(*camera.size) for camera in cameras]
    xyz = robust_points(cameras, uv, limit=limit).reshape(-1, len(along), 3)[:, order]
    gap = np.linalg.norm(np.diff(xyz, axis=1), axis=2)
    gap = gap[np.isfinite(gap).all(1)]
    if len(gap) < FEWEST:
        return None
    share = gap / gap.sum(1, keepdims=True)  # (1)
    median = np.median(share, axis=0)
    spread = SD_PER_MEDIAN * np.median(np.abs(share - median), axis=0)
    length = float(np.ptp(along))
    return SeenGaps(median / median.sum() * length, 1.2533 * spread / np.sqrt(len(gap)) * length, np.diff(along[order]))


def seen_places(cameras: Sequence[Camera], uv: Floats, along: Floats, *, least: float) -> Floats:
    """Where the markers are along the stick (K) mm: as stated, or as seen where that differs by more than chance.

    Args:
        cameras: (C) that see it, as well as they are known.
        uv: (C, N, 2) px, N = F K.
        along: (K) as stated, mm.
        least: of the stick's length; smaller differences are the cameras' own.

    Raises:
        KinemarkError: the gaps differ by more than a ruler is read wrong.
    """
    seen = seen_gaps(cameras, uv, along)
    if seen is None:
        return along
    length = float(np.ptp(along))
    difference = np.abs(seen.gaps - seen.stated)
    if difference.max() > PLAUSIBLE * length:
        observed, stated = (" + ".join(f"{mm:.1f}" for mm in gaps) for gaps in (seen.gaps, seen.stated))
        raise KinemarkError(
            f"The gaps between the markers come out as {observed} mm, if they are {length:g} mm in all, and they are "
            f"given as {stated} mm. Measure them again, from centre to centre, and give them in order."
        )
    if (difference <= np.maximum(CERTAIN * seen.sd, least * length)).all():
        return along
    order = np.argsort(along)
    places = np.empty_like(along)
    places[order] = along[order[0]] + np.concatenate([[0.0], np.cumsum(seen.gaps)])
    return places


def places_of(xyz: Floats) -> Floats:
    """Where the markers of fitted sticks (F, K, 3) are along them (K) mm, from the first; NaN without a whole one."""
    whole = xyz[np.isfinite(xyz).all((1, 2))]
    if not len(whole):
        return np.full(xyz.shape[1], np.nan)
    return np.asarray(np.linalg.norm(whole[0] - whole[0, :1], axis=1))
