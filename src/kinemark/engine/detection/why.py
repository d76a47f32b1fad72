"""Why a place in an image is, or is not, a marker: in words, with the figures that decided."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ...data import Validity
from ...data.array_types import Bools, Ints
from ...detect import Centroids
from ...detect.centroids_method import grey_scale
from ...geometry.camera import in_image
from .open_detection import InFrame

REACH = 6
"""px about a click within which a marker, or what is brightest, is meant; chosen: what a hand hits."""
OUT = 6.0
"""Standard deviations of noise that something is from the ground at least; chosen, as for relative thresholds."""
LEAST = 3.0
"""Grey levels of 8 bits that it is from the ground at least; chosen, likewise."""
TOUCHING = np.ones((3, 3))  # pixels that touch along a side or at a corner are one; by definition


class PlaceVerdict(NamedTuple):
    """Why a place is a marker, or none.

    Attributes:
        words: in a sentence or two. row: of the detection that is meant, −1 for none.
        parameter: of detection that decided, where one did; value: with which the place would be a marker.
    """

    words: str
    row: int = -1
    parameter: str = ""
    value: float | None = None


def why(found: InFrame, u: float, v: float, *, v_offset: float = 0.0) -> PlaceVerdict:
    """What decided at a pixel (u, v) of an image; `v_offset` is what its detections are lower.

    Raises:
        ValueError: the place is outside the image.
    """
    height, width = found.image.shape
    if not in_image((width, height), u, v):
        raise ValueError(f"({u:g}, {v:g}) is outside the image of {width} × {height} px")
    row = _row_at(found, u, v, v_offset)
    if row >= 0:
        return _of_row(found, row, v_offset)
    group = _group_at(found.white, u, v)
    return _dark(found, u, v) if group is None else _noise(found, group)


def _row_at(found: InFrame, u: float, v: float, v_offset: float) -> int:
    """The detection whose rectangle, a little wider, holds the place: the one with the nearest centre."""
    blobs = found.blobs
    if not len(blobs.uv):
        return -1
    distance = np.abs(blobs.uv - [u, v + v_offset])
    near = (distance <= np.stack([blobs.width, blobs.height], -1) / 2 + 1.5).all(1)
    away = np.where(near, np.hypot(*distance.T), np.inf)
    return int(away.argmin()) if near.any() else -1


def _of_row(found: InFrame, row: int, v_offset: float) -> PlaceVerdict:
    """Of a detection."""
    blobs, limits = found.blobs, _limits(found)
    u, v = blobs.uv[row] - [0.0, v_offset]
    group = _group_at(found.white, u, v)
    pixels = int(group.sum()) if group is not None and not blobs.merged[row] else round(float(blobs.area[row]))
    w, h = int(blobs.width[row]), int(blobs.height[row])
    size = f"{pixels} white px, {w} × {h} px"
    said = Validity(blobs.validity[row])
    if said == Validity.VALID:
        together = " Markers lie on each other here, and were told apart." if blobs.merged[row] else ""
        return PlaceVerdict(f"A marker: {size}, at ({u:.2f}, {v:.2f}), {_peak(found, row)}.{together}", row)
    if said == Validity.TOO_SMALL:
        return PlaceVerdict(f"Too small: {size}, and min_area is {limits['min_area']:g} px.", row, "min_area", pixels)
    if said == Validity.TOO_LARGE:
        return PlaceVerdict(f"Too large: {size}, and max_area is {limits['max_area']:g} px.", row, "max_area", pixels)
    if said == Validity.NOT_ROUND:
        ratio = max(w, h) / max(min(w, h), 1)
        words = f"Not round: {size}, {ratio:.1f} times as long as wide"
        most = limits.get("max_aspect")
        if most is None:
            return PlaceVerdict(f"{words}, as no marker is.", row)
        return PlaceVerdict(f"{words}, and max_aspect is {most:g}.", row, "max_aspect", np.ceil(10 * ratio) / 10)
    if said == Validity.AT_EDGE:
        return PlaceVerdict(f"At the edge of the image, so that a part may be missing: {size}.", row)
    return PlaceVerdict(f"Masked: most of it lies within a mask ({size}).", row)


def _peak(found: InFrame, row: int) -> str:
    peak = float(found.blobs.peak[row])
    return "of unknown brightness" if np.isnan(peak) else f"peak {peak / grey_scale(found.image.dtype):.0f} of 255"


def _noise(found: InFrame, group: Bools) -> PlaceVerdict:
    """White pixels that left no detection."""
    v, u = np.nonzero(group)
    w, h = int(np.ptp(u)) + 1, int(np.ptp(v)) + 1
    size = f"{int(group.sum())} white px, {w} × {h} px"
    least = _limits(found).get("min_width")
    if least is not None and min(w, h) < least:
        words = f"Noise: {size}, and what is narrower or lower than min_width, {least:g} px, leaves no detection."
        return PlaceVerdict(words, parameter="min_width", value=min(w, h))
    return PlaceVerdict(f"Noise: {size}, a speck without light round it, as a marker's image has.")


def _dark(found: InFrame, u: float, v: float) -> PlaceVerdict:
    """No white pixel near."""
    row, column = round(v), round(u)
    scale = grey_scale(found.image.dtype)
    rows, columns = _window(found.seen.shape, row, column)
    near = found.seen[rows, columns].astype(np.float64) / scale
    here = float(found.seen[row, column]) / scale
    best = float(near.min() if found.inverted else near.max())
    if found.method is None:
        return PlaceVerdict("Nothing stands out from the background in the whole recording of this camera.")
    level, sign = found.level / scale, "darker" if found.inverted else "brighter"
    words = f"Not white: grey level {here:.0f}{' above the static ground' if found.ground else ''} here"
    rule = f"only pixels {sign} than the threshold, {level:.0f}, are white"
    ground, noise = _ground(found)
    if abs(best - ground) <= max(OUT * noise, LEAST):
        return PlaceVerdict(f"{words}, as the ground of the whole image is, and {rule}.")
    most, act = ("least", "Raise it above") if found.inverted else ("most", "Lower it below")
    words = f"{words}, at {most} {best:.0f} within {REACH} px, and {rule}. {act} {best:.0f} to see what is here."
    return PlaceVerdict(words, parameter="threshold", value=round((ground + best) / 2, 1))


def _ground(found: InFrame) -> tuple[float, float]:
    """Median of the image without ground, and the standard deviation of its noise, grey levels of 8 bits."""
    scale = grey_scale(found.image.dtype)
    low, median = (float(np.quantile(found.seen, q)) / scale for q in (0.1587, 0.5))
    return median, median - low


def _group_at(white: Bools, u: float, v: float) -> Bools | None:
    """(H, W) the white pixels that touch each other at, or nearest to, a place; None where none is within reach."""
    rows, columns = _window(white.shape, round(v), round(u))
    y, x = np.nonzero(white[rows, columns])
    if not len(x):
        return None
    near = int(np.hypot(x + columns.start - u, y + rows.start - v).argmin())
    found: Ints = np.asarray(scipy.ndimage.label(white, TOUCHING)[0])
    return np.asarray(found == found[rows.start + y[near], columns.start + x[near]])


def _window(shape: tuple[int, ...], row: int, column: int) -> tuple[slice, slice]:
    return (
        slice(max(row - REACH, 0), min(row + REACH + 1, shape[0])),
        slice(max(column - REACH, 0), min(column + REACH + 1, shape[1])),
    )


def _limits(found: InFrame) -> dict[str, float]:
    """The limits of size that were used, by the names that they have in the file."""
    if isinstance(found.method, Centroids):
        return dict(found.method.limits._asdict())
    names = ("min_area", "max_area")
    return {name: float(getattr(found.method, name)) for name in names if hasattr(found.method, name)}
