"""What each camera saw and how well it agrees with the others.

The image of a reconstructed point X in camera c is compared with the detection (u, v) that it was made from:

    r = (u, v) − project_c(X)         px                                     (1)
    |r|                               reprojection residual of one view      (2)
    median r                          offset; not zero when the camera has moved since its calibration   (3)

One pixel at the depth Z of the point and focal length f spans

    s = Z / f                         mm/px                                  (4)
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import Camera, Cloud, Detections, Rig, Validity
from ..data.array_types import Floats
from ..geometry import project, to_camera
from .plain import mean, quantile, rms, share

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Those that the figure of residuals draws as whiskers, box and median line; chosen."""


def residuals(rig: Rig, detections: Detections, cloud: Cloud) -> list[Floats]:
    """For each camera (n, 2) px: used detection minus reprojection of its point, NaN behind the camera."""
    return [_residual(camera, c, detections, cloud) for c, camera in enumerate(rig)]


def _residual(camera: Camera, c: int, detections: Detections, cloud: Cloud) -> Floats:
    """(n, 2) px of one camera, its number c."""
    seen = _seen(cloud, c)
    return np.asarray(detections.uv[cloud.detection[seen, c]] - project(camera, cloud.xyz[seen]))  # (1)


class AsGiven(NamedTuple):
    """What a trial was reconstructed from: cameras as they were calibrated, detections when they were taken."""

    rig: Rig
    detections: Detections


def camera_figures(
    rig: Rig, detections: Detections, cloud: Cloud, offsets: list[Floats], given: AsGiven | None = None
) -> list[dict[str, Any]]:
    """The figures of every camera, in the order of `detections`."""
    before = as_calibrated(rig, detections, cloud, given)
    counts = detections.counts
    rows = detections.camera
    return [
        camera_description(camera)
        | {"calibration_residual_px": camera.residual}
        | _detected(counts[c], detections.validity[rows == c], cloud.detection[_seen(cloud, c), c])
        | {"separated": int((detections.merged & detections.valid & (rows == c)).sum())}
        | _reprojected(offsets[c])
        | {"residual_as_calibrated_px": before[c]}
        | {"pixel_at_subject_mm": _pixel(camera, cloud.xyz[_seen(cloud, c)])}
        for c, camera in enumerate(rig)
    ]


def as_calibrated(rig: Rig, detections: Detections, cloud: Cloud, given: AsGiven | None) -> list[float | None]:
    """(C) px, the median residual of each camera by what was given; None where that is what was reconstructed with."""
    if given is None:
        return [None] * len(rig)
    return [_as_calibrated(camera, c, detections, cloud, given) for c, camera in enumerate(rig)]


def _as_calibrated(camera: Camera, c: int, detections: Detections, cloud: Cloud, given: AsGiven) -> float | None:
    """`as_calibrated` of one camera, its number c."""
    before, own = given.rig[c], detections.camera == c
    uv, uv_before = detections.uv[own], given.detections.uv[own]
    if _alike(camera, before) and np.array_equal(uv, uv_before, equal_nan=True):
        return None
    return quantile(np.linalg.norm(_residual(before, c, given.detections, cloud), axis=1), 0.5)


def _alike(camera: Camera, other: Camera) -> bool:
    """Whether two cameras project alike."""
    return all(np.array_equal(getattr(camera, name), getattr(other, name)) for name in ("K", "distortion", "R", "t"))


def _seen(cloud: Cloud, c: int) -> NDArray[np.int64]:
    """Rows of the cloud that camera c sees; a cloud without points may have no columns."""
    return np.flatnonzero(cloud.detection[:, c] >= 0) if len(cloud) else np.zeros(0, np.int64)


def camera_description(camera: Camera) -> dict[str, Any]:
    """Name, image, place and focal lengths of a camera."""
    known = bool((camera.size > 0).all())
    return {
        "name": camera.name,
        "size_px": camera.size if known else None,
        "position_mm": camera.centre,
        "focal_px": [abs(camera.K[0, 0]), abs(camera.K[1, 1])],
    }


def _detected(counts: NDArray[np.int64], validity: NDArray[np.uint8], used: NDArray[np.int64]) -> dict[str, Any]:
    """From detections a frame (F), the validity of each detection (n) and those that points were made from."""
    n, valid = len(validity), int((validity == Validity.VALID).sum())
    taken = int(np.count_nonzero(np.bincount(used)))  # one image may be in several points
    return {
        "detections": n,
        "detections_per_frame": {
            "mean": mean(counts.astype(float)),
            "min": counts.min() if counts.size else None,
            "max": counts.max() if counts.size else None,
        },
        "frames_without_detection_share": share((counts == 0).sum(), counts.size),
        "used_share": share(taken, n),
        "used_of_valid_share": share(taken, valid),
        "invalid": {
            reason.name.lower(): int((validity == reason).sum()) for reason in Validity if reason != Validity.VALID
        },
        "invalid_share": {
            reason.name.lower(): share((validity == reason).sum(), n) for reason in Validity if reason != Validity.VALID
        },
    }


def _reprojected(offsets: Floats) -> dict[str, Any]:
    distance = np.linalg.norm(offsets, axis=1)  # (2)
    return {
        "residual_median_px": quantile(distance, 0.5),
        "residual_rms_px": rms(distance),
        "residual_95_px": quantile(distance, 0.95),
        "residual_quantiles_px": [quantile(distance, q) for q in QUANTILES],
        "offset_px": [quantile(offsets[:, 0], 0.5), quantile(offsets[:, 1], 0.5)],  # (3)
    }


def _pixel(camera: Camera, xyz: Floats) -> float:
    """Width of one pixel at the middle depth of the points, mm."""
    return quantile(to_camera(camera, xyz)[:, 2], 0.5) / abs(float(camera.K[0, 0]))  # (4)


def upwards(rig: Rig) -> int:
    """The world's axis that points up: that of the cameras' own upward sides on average; z where they do not agree."""
    if not len(rig):
        return 2
    mean = np.mean([-np.sign(camera.K[1, 1]) * camera.R[1] for camera in rig], axis=0)
    return int(mean.argmax()) if mean.max() > 0.3 else 2
