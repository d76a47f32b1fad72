"""Whether the images of a trial count their pixels otherwise than the calibration does.

Some programs count v from the bottom of an image or both from its middle, others name the row before the column or
give shares of the width and the height, and images may be recorded, or saved, at half or twice the size that was
calibrated. Nothing then agrees: rays pass each other, and what meets,
meets by chance. Where little of what the cameras saw became part of a point on three of them, the other ways to count
are tried on some frames, and the way is named by which most then does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...data import Cloud, Detections, Finding, Rig, make_finding
from ...data.array_types import Floats
from ...data.method import Method
from ...geometry.common_view import image_size
from ...match import match
from ...reconstruct import reconstruct
from .swapped_cameras import confirmed_shares, some_frames

LITTLE = 0.2
"""Share of the detections on points of three cameras, in the median camera, below which other ways are tried. Of
pixels counted otherwise 0 to 0.1 are there by chance; chosen."""

BETTER = 3.0
"""Times as many that must be there by another way, and more than LITTLE; chosen."""

WHOLE = 1.0
"""Of a width or height: images of which no coordinate is greater are counted in shares; by definition."""

WAYS: dict[str, Callable[[Floats, Floats], Floats]] = {
    "v_up": lambda uv, size: np.stack([uv[:, 0], size[1] - 1 - uv[:, 1]], -1),
    "u_left": lambda uv, size: np.stack([size[0] - 1 - uv[:, 0], uv[:, 1]], -1),
    "turned": lambda uv, size: size - 1 - uv,
    "exchanged": lambda uv, size: uv[:, ::-1],
    "half_size": lambda uv, size: 2 * uv + 0.5,
    "double_size": lambda uv, size: uv / 2 - 0.25,
    "centre": lambda uv, size: uv + (size - 1) / 2,
    "centre_v_up": lambda uv, size: uv * [1, -1] + (size - 1) / 2,
    "share": lambda uv, size: uv * size - 0.5,
    "share_v_up": lambda uv, size: np.stack([uv[:, 0], 1 - uv[:, 1]], -1) * size - 0.5,
}
"""Pixels (n, 2) as the calibration counts them, in an image of size (2) px, by how they are counted; by definition."""


def pixel_axes(
    detections: Detections, rig: Rig, cloud: Cloud, *, matching: Method, placing: Method
) -> tuple[Finding, ...]:
    """By which other way of counting pixels the cameras agree, if so; nothing where all is well.

    Two cameras tell nothing, as any two rays that nearly meet are a point.
    """
    as_is = float(np.median(confirmed_shares(detections, cloud)))
    if len(rig) < 3 or as_is > LITTLE or not detections.valid.any():
        return ()
    few = some_frames(detections)
    shares = {}
    in_shares = float(np.abs(detections.uv[detections.valid]).max()) <= WHOLE  # whose middle would fit by any other way
    for way in (way for way in WAYS if way.startswith("share") == in_shares):
        other = counted(few, rig, way)
        points = reconstruct(match(other, rig, method=matching), other, rig, method=placing)
        shares[way] = float(np.median(confirmed_shares(other, points)))
    best = max(shares, key=lambda way: shares[way])
    if shares[best] <= max(LITTLE, BETTER * as_is):
        return ()
    return (make_finding("pixel_axes_differ", way=best, other_share=shares[best], as_is_share=as_is),)


def counted(detections: Detections, rig: Rig, way: str) -> Detections:
    """The detections if their pixels are counted by one of WAYS."""
    uv = np.array(detections.uv)
    for c, camera in enumerate(rig):
        own = detections.camera == c
        uv[own] = WAYS[way](uv[own], image_size(camera))
    return replace(detections, uv=uv)
