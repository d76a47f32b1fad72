"""Whether one camera's images are given for two: one file twice in a trial, where another's should be."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from ...data import Detections, Finding, make_finding
from ...data.finding import red_if
from .camera_order import FITS_NOTHING, IN_PLACE_OF
from .swapped_cameras import some_frames

SAME = 0.5
"""Share of the detections of either camera that the other one has at the same place to the last digit; chosen: two
images of whole pixels have a few so by chance."""


def same_images(detections: Detections, diagnosed: Sequence[Finding]) -> Iterator[Finding]:
    """Cameras two by two that have the same images; red unless tracking left one of them out.

    Args:
        detections: all, or of one trial. diagnosed: what tracking found.
    """
    few = some_frames(detections)
    seen = [_places(few, c) for c in range(len(few.cameras))]
    unlike = {one.cameras[0] for one in diagnosed if one.kind in (FITS_NOTHING, IN_PLACE_OF)}
    for (a, own), (b, other) in combinations(zip(few.cameras, seen, strict=True), 2):
        if len(own & other) > SAME * max(len(own), len(other)):
            yield make_finding("cameras_with_same_images", severity=red_if(not {a, b} & unlike), cameras=[a, b])


def _places(detections: Detections, c: int) -> set[tuple[float, ...]]:
    """Frame, u and v of a camera's valid detections."""
    own = detections.valid & (detections.camera == c)
    return set(map(tuple, np.column_stack([detections.frame[own], detections.uv[own]]).tolist()))
