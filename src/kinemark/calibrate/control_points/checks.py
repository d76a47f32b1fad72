"""Control points that determine no camera are refused before any camera is sought, with the reason.

Of the points' distances from their mean the singular values s1 ≥ s2 ≥ s3, divided by √N, are their RMS extents along
three directions at right angles. Points with s2 small against s1 lie on a line (1), with s3 small in a plane (2): then
many cameras see them alike. Flat are points of s3 < `FLAT` s1, as the error of any survey is thinner than that
only in a small part of cases, and the camera's place would follow from that error alone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...data import KinemarkError
from ...data.array_types import Floats

FEWEST = 6  # points that the eleven parameters of a DLT need; by definition
FLAT = 0.01
"""Of the greatest extent; thinner than this, points lie in a plane; chosen (see studies/calibration_quality.py)."""
LEAST_EXTENT = 10.0  # mm that control points span; less is another unit; chosen
MOST_EXTENT = 1e5  # mm that control points span; more is another unit; chosen
SAME = 1e-6  # of the extent, or px; closer points are one; conventional: rounding of a file
APART = 0.01
"""Of the extent; one point may not be seen, or stand, so far from itself; chosen (see
studies/calibration_quality.py)."""
UPRIGHT = 0.98
"""Cosine, about 11 degrees, within which a plane's normal is called an axis; chosen (see
studies/calibration_quality.py)."""


def labels(points: Sequence[str] | None, n: int) -> tuple[str, ...]:
    """(N) names of the points: as given, or their numbers from 1.

    Raises:
        ValueError: there are more or fewer names than points.
    """
    if points is not None and len(points) != n:
        raise ValueError(f"points has {len(points)} names, wanted {n}")
    return tuple(points) if points is not None else tuple(str(i + 1) for i in range(n))


def check_extent(xyz: Floats) -> None:
    """The places (N, 3) must be lengths in mm, of a laboratory.

    Raises:
        KinemarkError: they are so near or far from each other that the unit must be another one.
    """
    known = xyz[np.isfinite(xyz).all(1)]
    if len(known) < 2:
        return
    extent = float(np.ptp(known, axis=0).max())
    if 0 < extent < LEAST_EXTENT:
        raise KinemarkError(
            f"The control points lie within {extent:.3g} mm of each other. Are their coordinates in metres or "
            "centimetres? Give them in mm."
        )
    if extent > MOST_EXTENT:
        raise KinemarkError(
            f"The control points spread over {extent / 1000:.4g} m. Are their coordinates in thousandths of a "
            "millimetre, or is one of them wrong? Give them in mm."
        )


def check_points(xyz: Floats, uv: Floats, names: Sequence[str]) -> None:
    """Points at (N, 3) mm with these names, all seen by one camera at (N, 2) px, must determine it.

    Raises:
        KinemarkError: they are too few, repeat, or lie on a line or in a plane; the message says which.
    """
    if len(xyz) < FEWEST:
        raise KinemarkError(f"{len(xyz)} control points are seen, and a camera needs six. Place or find more of them.")
    _check_places(xyz, uv, names)
    _check_images(xyz, uv, names)
    distinct = len(np.unique(np.round(xyz / (SAME * _extent(xyz) + 1e-300)), axis=0))
    if distinct < FEWEST:
        raise KinemarkError(
            f"The {len(xyz)} control points repeat: they are at {distinct} different places, and with fewer than six "
            "all cameras through a plane or line fit. Place or find more of them."
        )
    _check_thickness(xyz)


def _extent(points: Floats) -> float:
    return float(np.ptp(points, axis=0).max(initial=0.0))


def _check_places(xyz: Floats, uv: Floats, names: Sequence[str]) -> None:
    """One place has one image."""
    for i, j in _coincident(xyz, SAME * _extent(xyz)):
        apart = float(np.linalg.norm(uv[i] - uv[j]))
        if apart > APART * _extent(uv):
            raise KinemarkError(
                f"Control points {names[i]} and {names[j]} have the same place in the survey, {_place(xyz[i])} mm, and "
                f"are seen {apart:.0f} px apart. Correct the coordinates of one of them."
            )


def _check_images(xyz: Floats, uv: Floats, names: Sequence[str]) -> None:
    """One image is of one place: markers exactly behind one another are not seen as two."""
    for i, j in _coincident(uv, SAME):
        apart = float(np.linalg.norm(xyz[i] - xyz[j]))
        if apart > APART * _extent(xyz):
            raise KinemarkError(
                f"Control points {names[i]} and {names[j]}, {apart:.0f} mm apart, have the same image at "
                f"{_place(uv[i])} px: one marker was taken for both. Leave out the one that is not seen."
            )


def _coincident(points: Floats, near: float) -> list[tuple[int, int]]:
    """Pairs (i, j) of neighbours in sorted order that coincide."""
    order = np.lexsort(points.T)
    same = np.abs(np.diff(points[order], axis=0)).max(1, initial=0.0) <= near
    return [(int(min(i, j)), int(max(i, j))) for i, j in zip(order[:-1][same], order[1:][same], strict=True)]


def _check_thickness(xyz: Floats) -> None:
    """(1), (2)."""
    centred = xyz - xyz.mean(0)
    _, s, Vt = np.linalg.svd(centred, full_matrices=False)
    if s[1] < FLAT * s[0]:  # (1)
        distance = float(np.linalg.norm(centred - np.outer(centred @ Vt[0], Vt[0]), axis=1).max())
        raise KinemarkError(
            f"The {len(xyz)} control points all lie within {_length(distance)} of a line, and no camera follows from "
            "that. Use points spread through the whole volume."
        )
    if s[2] < FLAT * s[0]:  # (2)
        distance = float(np.abs(centred @ Vt[2]).max())
        raise KinemarkError(
            f"The {len(xyz)} control points all lie within {_length(distance)} of a plane, "
            f"{_plane(Vt[2], xyz.mean(0))}, and spread over {_length(_extent(xyz))} in it; no camera follows "
            "from that. Use points spread through the whole volume."
        )


def _plane(normal: Floats, centre: Floats) -> str:
    """A plane in words: x = 3 mm, where it is at right angles to an axis."""
    k = int(np.abs(normal).argmax())
    if abs(normal[k]) > UPRIGHT:
        return f"about {'xyz'[k]} = {centre[k]:.0f} mm"
    normal = np.round(normal * np.sign(normal[k]), 2) + 0.0  # no -0.00
    return f"at right angles to ({', '.join(f'{x:.2f}' for x in normal)}) through ({_place(centre)}) mm"


def _place(point: Floats) -> str:
    return ", ".join(f"{x:.0f}" for x in point)


def _length(mm: float) -> str:
    return f"{mm:.1f} mm" if mm >= 0.05 else "0.1 mm"
