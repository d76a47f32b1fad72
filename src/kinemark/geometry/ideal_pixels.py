"""What all methods begin with: the same cameras in detections and rig, and images without lens distortion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data import Detections, KinemarkError, Rig
from ..data.array_types import Floats
from . import undistort

MOST = 1000  # images of one camera and frame; more are noise, and their pairs would take hours; chosen


def check_cameras(detections: Detections, rig: Rig) -> None:
    """Two cameras or more, the same in both.

    Raises:
        KinemarkError: they are not.
    """
    if len(rig) < 2:
        raise KinemarkError(f"{len(rig)} camera is calibrated, and a point in space needs two. Add a camera.")
    if detections.cameras != rig.names:
        raise KinemarkError(
            f"The detections are of cameras {', '.join(detections.cameras)} and the calibration of "
            f"{', '.join(rig.names)}. "
            "Name the same cameras in the same order in both."
        )


def ideal_pixels(detections: Detections, rig: Rig, *, cameras: Sequence[int] | None = None) -> Floats:
    """(D, 2) the valid detections without lens distortion, NaN for the others and those of cameras not asked for.

    Args:
        detections: what the cameras saw.
        rig: the same cameras.
        cameras: places of those that are looked at; None: all.

    Raises:
        KinemarkError: a frame of one of them has so many that they must be noise.
    """
    chosen = range(len(rig)) if cameras is None else cameras
    uv = np.full((len(detections), 2), np.nan)
    for c in chosen:
        counts = detections.counts[c]
        if counts.max(initial=0) > MOST:
            raise KinemarkError(
                f"Camera {rig.names[c]} has {counts.max()} points in frame {counts.argmax()}, wanted at most {MOST}: "
                "they are noise. Raise the threshold, or leave that frame out."
            )
        own = slice(detections.start[c, 0], detections.start[c, -1])
        uv[own] = undistort(rig[c], detections.uv[own])
    uv[~detections.valid] = np.nan
    return uv
