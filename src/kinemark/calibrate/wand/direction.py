"""From which end a wand of three markers or more is seen, frame by frame, where its gaps are nearly alike from both.

What an image shows of gaps is their proportion times that of the ends' depths. Where the gaps differ by less than the
depths do, an image reads the wand from either end, and cameras on one side all mistake the same frames. Cameras that
are calibrated by the wand's ends alone, whose length is the same from both, see the gaps g_k in space: with the shares
p_k = g_k / Σ g of a frame, those stated, p⁰_k, and the same from the other end, p¹_k, a frame is turned where

    Σ (p_k − p¹_k)² < Σ (p_k − p⁰_k)²                                    (1)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...data import Camera
from ...data.array_types import Bools, Floats
from ..bundle.robust_points import robust_points
from ..bundle.stick_gaps import FAR_OFF

DEPTHS = 0.3
"""Of |ln (first gap / last gap)|, without unit; wands below are read from either end; chosen: three times the standard
deviation of what depths do (`rows.TILT`)."""
ROUNDING = 1e-9  # share by which equal gaps differ for rounding; chosen


def looks_alike(along: Floats) -> bool:
    """Whether depths may outweigh what a wand with markers at `along` (K) mm looks like from its other end.

    Not where both are the same: nothing needs to be told apart there.
    """
    gaps = np.diff(along)
    return not np.allclose(gaps, gaps[::-1], rtol=ROUNDING) and abs(float(np.log(gaps[0] / gaps[-1]))) < DEPTHS


def from_other_end(cameras: Sequence[Camera], uv: Floats, along: Floats) -> Bools:
    """The frames (F) that (1) turns; not those in which a marker is seen by fewer than two cameras.

    Args:
        cameras: (C) in any world, of any scale.
        uv: (C, F, K, 2) px, NaN where not seen.
        along: (K) places of the markers, mm.
    """
    limit = [FAR_OFF * np.hypot(*camera.size) for camera in cameras]
    xyz = robust_points(cameras, uv.reshape(len(uv), -1, 2), limit=limit).reshape(*uv.shape[1:3], 3)
    gaps = np.linalg.norm(np.diff(xyz, axis=1), axis=2)
    share, stated = gaps / gaps.sum(1, keepdims=True), np.diff(along) / np.ptp(along)
    with np.errstate(invalid="ignore"):
        return np.asarray(((share - stated[::-1]) ** 2).sum(1) < ((share - stated) ** 2).sum(1))  # (1)
