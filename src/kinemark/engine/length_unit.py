"""Whether the calibration may be in another unit of length, judged by the sizes of markers and subject.

Images tell no scale. What does is the size of things that is known: markers are sold from SMALLEST_MM to LARGEST_MM,
and a person's are metres from the cameras and from each other. The image of a marker of area A at the depth Z of a
camera of focal length f is

    2 √(A / π) Z / f                                                                                       (1)

wide, or less: images are blurred, the more so the fewer px they have.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..data import Cloud, Detections, Finding, Rig, make_finding
from ..data.array_types import Floats
from ..geometry import to_camera

SMALLEST_MM, LARGEST_MM = 1.5, 60.0
"""Width of markers; chosen: those of faces are 1.5 to 4 mm, of wands and large volumes up to 50."""
LARGE_PX, COARSE = 8.0, 2.0
"""px, the width of images that blur hardly widens; chosen. Markers of narrower ones may seem COARSE times LARGEST_MM
wide; chosen: in images of 5 px at 12 m they seem five times as wide as they are."""
SMALL_MM = 4.0
"""Width by the images from which markers are no person's in another unit; chosen: in cm, markers of 40 mm."""
NEAR_MM, TOGETHER_MM = 1000.0, 300.0
"""How near all is that may be a person in another unit; chosen: in cm, 10 m from the cameras, and 3 m of height."""
LEAST_MARKERS = 8
"""In a frame, from which on they may be a person's; chosen."""


def length_unit(detections: Detections, rig: Rig, cloud: Cloud) -> Iterator[Finding]:
    """About markers that are too small or too large, or all as near as a person in another unit; else nothing."""
    depth, scale, diameter = _images_of_points(detections, rig, cloud)
    if not len(depth):
        return
    known = np.isfinite(diameter)
    marker = float(np.median((diameter * scale)[known])) if known.any() else np.nan  # (1)
    largest = LARGEST_MM * (1.0 if known.any() and np.median(diameter[known]) >= LARGE_PX else COARSE)
    distance, (extent, markers) = float(np.median(depth)), _extent(cloud)
    odd = marker < SMALLEST_MM or marker > largest
    small = distance < NEAR_MM and extent < TOGETHER_MM and markers >= LEAST_MARKERS and not marker > SMALL_MM
    if odd or small:
        yield make_finding(
            "length_unit_doubtful",
            severity="amber" if odd else "info",
            marker_mm=marker,
            distance_mm=distance,
            extent_mm=extent,
        )


def _images_of_points(detections: Detections, rig: Rig, cloud: Cloud) -> tuple[Floats, Floats, Floats]:
    """Of all images of points: Z mm, Z / f in mm a px, and the width in px; NaN of images without area."""
    depth, scale, diameter = [np.zeros(0)], [np.zeros(0)], [np.zeros(0)]
    for c, camera in enumerate(rig):
        seen = np.flatnonzero(cloud.detection[:, c] >= 0) if len(cloud) else np.zeros(0, np.int64)
        z = to_camera(camera, cloud.xyz[seen])[:, 2]
        area = detections.area[cloud.detection[seen, c]]
        depth.append(z)
        scale.append(z / np.sqrt(abs(camera.K[0, 0] * camera.K[1, 1])))
        diameter.append(2 * np.sqrt(np.where(area > 0, area, np.nan) / np.pi))
    return np.concatenate(depth), np.concatenate(scale), np.concatenate(diameter)


def _extent(cloud: Cloud) -> tuple[float, float]:
    """mm, the longest side of the box of points in the median frame, and how many there are; of frames with some."""
    frames = [cloud.xyz[cloud.rows(f)] for f in range(0, cloud.n_frames, max(cloud.n_frames // 50, 1))]
    sides = [(float(np.ptp(xyz, axis=0).max()), len(xyz)) for xyz in frames if len(xyz)]
    extent, markers = np.median(np.array(sides or [(0.0, 0)]), axis=0)
    return float(extent), float(markers)
