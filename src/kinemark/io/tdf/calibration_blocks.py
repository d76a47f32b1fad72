"""What a TDF file says of its cameras: their calibration and what they saw."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data import Camera, Detections, Rig
from .cursor import Cursor

NO_DISTORTION, RADIAL = 0, 3  # codes of lens models; of the format
MOST_CAMERAS = 1024  # in a file; chosen, lest a broken file take memory
FARTHEST = 1e6  # m from the origin to a camera, at most; chosen
CAMERA = np.dtype(
    [
        ("R", "<f8", (3, 3)),
        ("T", "<f8", 3),
        ("f", "<f8", 2),
        ("c", "<f8", 2),
        ("radial", "<f8", 2),
        ("other", "<f8", 4),  # decentering, thin prism
        ("viewport", "<i4", 4),
    ]
)


def names_of(cursor: Cursor, channels: NDArray[Any]) -> tuple[str, ...]:
    """`cam1`, `cam2`, … after the physical channel of each camera."""
    names = tuple(f"cam{int(channel) + 1}" for channel in channels)
    if len(set(names)) != len(names):
        raise cursor.bad(f"maps two cameras to one channel: {channels.tolist()}")
    return names


def number_of_cameras(cursor: Cursor) -> int:
    """The next int32, within reason."""
    if not 0 < (n := cursor.integer()) <= MOST_CAMERAS:
        raise cursor.bad(f"states {n} cameras, wanted 1 … {MOST_CAMERAS}")
    return n


def rig(cursor: Cursor) -> Rig:
    """Block type 2.

    The file's model is x = R (X − T) with T the centre in metres, and pixel = c + f · (x, y)/z · (1 + k1 r² + k2 r⁴),
    which is OpenCV's with t = −R T and p1 = p2 = k3 = 0. How BTS signs and orders decentering and thin prism
    is not published; files in which they are used are refused rather than read wrongly.
    """
    cursor.wanted(1)
    n, model = number_of_cameras(cursor), cursor.integer()
    size, turn, corner = cursor.take("<f4", 3), cursor.take("<f4", 9), cursor.take("<f4", 3)
    names = names_of(cursor, cursor.take("<i2", n))
    rows = cursor.take(CAMERA, n)
    if model not in (NO_DISTORTION, RADIAL) or (model == RADIAL and rows["other"].any()):
        raise cursor.bad(f"uses lens model {model} with terms that are not published; only radial terms are read")
    cameras = tuple(camera(cursor, name, row, model) for name, row in zip(names, rows, strict=True))
    low = corner.astype(np.float64) * 1000
    volume = np.stack([low, low + size.astype(np.float64) * 1000])
    upright = np.allclose(turn.reshape(3, 3), np.eye(3), atol=1e-6) and np.isfinite(volume).all()
    return Rig(cameras, "BTS calibration", volume if upright else np.full((2, 3), np.nan))


def camera(cursor: Cursor, name: str, row: np.void, model: int) -> Camera:
    """One record of the calibration block."""
    R, (fx, fy), (cx, cy) = row["R"], row["f"], row["c"]
    distortion = np.zeros(5)
    if model == RADIAL:
        distortion[:2] = row["radial"]
    if not ((np.abs(R) < 2).all() and (np.abs(row["T"]) < FARTHEST).all() and np.isfinite(distortion).all()):
        raise cursor.bad(f"has a position, rotation or lens of {name} that cannot be")
    try:
        return Camera(
            name=name,
            size=row["viewport"][2:],
            K=np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]),
            R=R,
            t=-R @ row["T"] * 1000,
            distortion=distortion,
        )
    except ValueError as error:
        raise cursor.bad(f"has an impossible camera ({error})") from error


def detections(cursor: Cursor) -> Detections:
    """Block type 4: the counts come frame by frame, camera by camera, and so do the points."""
    cursor.wanted(2)
    n, n_frames = number_of_cameras(cursor), cursor.integer()
    rate = cursor.rate()
    cursor.real()  # the start; frame 0 is the first
    if flags := int(cursor.take("<u4")[0]):
        raise cursor.bad(f"has flags {flags}: its points are already undistorted, wanted as the lens drew them")
    cameras = names_of(cursor, cursor.take("<u2", n))
    if n_frames < 0:
        raise cursor.bad(f"states {n_frames} frames")
    counts = cursor.take("<u2", n_frames * n).reshape(n_frames, n).astype(np.int64)
    uv = cursor.take("<f4", 2 * int(counts.sum())).reshape(-1, 2).astype(np.float64)
    if not np.isfinite(uv).all():
        raise cursor.bad("has points that are not finite")
    of_camera = np.repeat(np.tile(np.arange(n), n_frames), counts.reshape(-1))
    return Detections.build(cameras, rate, counts.T, uv[np.argsort(of_camera, kind="stable")])
