"""Whether both halves of a film show the same cameras.

A camera that lost images, or was moved, within the film makes cameras that please both sides a little: their covariance
takes what they miss for noise, and two cameras alone hardly miss anything. So the bundle is adjusted again to each half
h of the frames alone. With the residuals r of all n images' cameras, and r' of the half's own,

    (Σ_h r² / (ν n_h / n)) / (Σ_h r'² / ν_h)                              (1)

is 1 of a film that is one (Chow 1960): what no camera model explains is in both, and does not count.
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Floats
from ..bundle import Bundle, BundleFit
from .wand import refitted, seen_by

FEWEST_POSES, LEAST_FREEDOM = 24, 100
"""Poses in a half, chosen: twice as many as cameras can be found from; ν_h of (1), chosen: with less, a half's cameras
please the errors of one smooth path. Half of 56 published places, all of one throw, had 2.15 by 46."""
EXACT = 1e-3
"""px of residual, below which images are simulated ones and what is left is rounding; chosen."""


def halves_ratio(fit: BundleFit, along: Floats, *, method: Bundle, lens_held: bool = False) -> Floats:
    """(1) of the first half of the frames and of the second (2); NaN where too few tell.

    Args:
        fit: of all poses of a stick, or of a single marker, in any world.
        along: (K) mm where the markers are along the stick; (1) for a single marker.
        method: by which it was found.
        lens_held: whether lenses were known beforehand.
    """
    seen = np.isfinite(seen_by(fit, len(along))).all((-1, -2))
    frames = np.flatnonzero(seen.sum(0) >= 2)
    squares = np.where(fit.kept, (fit.residual**2).sum(-1), 0.0).sum(0).reshape(seen.shape[1], -1).sum(1)
    images = fit.kept.sum(0).reshape(seen.shape[1], -1).sum(1)
    ratio = np.full(2, np.nan)
    for h, half in enumerate(np.array_split(frames, 2)):
        known = np.isin(np.arange(seen.shape[1]), half)
        own = refitted(fit, along, known, method, lens_held) if len(half) >= FEWEST_POSES else None
        if own is not None and own.freedom >= LEAST_FREEDOM:
            by_all = squares[half].sum() / (fit.freedom * images[half].sum() / images[frames].sum())
            by_own = (own.residual[own.kept] ** 2).sum() / own.freedom
            ratio[h] = max(by_all, EXACT**2) / max(by_own, EXACT**2)  # (1)
    return ratio
