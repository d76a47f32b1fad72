"""Segments from points: axes of unit length, and joint centres from a wand and a width."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..data.array_types import Floats
from ..data.laboratory_axes import unit as unit

Z_UP: Floats = np.array([0.0, 0.0, 1.0])
"""Where up is in all of this package: `standard_trial` turns what comes from files; conventional."""
ROUNDS = 8
"""Of turning a wand about its segment; chosen, the sixth changes nothing at double precision."""


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A body segment over frames (…).

    Attributes:
        R: (…, 3, 3) its axes as columns in the laboratory: x forward, y to the left, z up the segment.
        origin: (…, 3) mm.
    """

    R: Floats
    origin: Floats

    def at(self, local: Floats) -> Floats:
        """(…, 3) mm of points (…, 3) mm in the segment's axes."""
        return self.origin + np.einsum("...ij,...j->...i", self.R, local)

    def turned_about_z(self, deg: float) -> Segment:
        """The same segment, turned about its own z."""
        c, s = np.cos(np.radians(deg)), np.sin(np.radians(deg))
        return Segment(self.R @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), self.origin)


def along_floor(v: Floats) -> Floats:
    """(…, 3) v without its vertical part."""
    return np.asarray(v - (v @ Z_UP)[..., None] * Z_UP)


def perpendicular(v: Floats, u: Floats) -> Floats:
    """(…, 3) the direction of v without its part along u, of length 1."""
    return unit(v - (v * u).sum(-1, keepdims=True) * u)


def upright(origin: Floats, up: Floats, left: Floats) -> Segment:
    """A segment with z along `up` and y as near to `left` as that allows, (…, 3) each."""
    z = unit(up)
    y = perpendicular(left, z)
    return Segment(np.stack([np.cross(y, z), y, z], -1), origin)


def joint_centre(
    above: Floats, lateral: Floats, wand: Floats, *, half_width_mm: float, wand_deg: float = 0.0, outwards: float = 1.0
) -> Floats:
    """(…, 3) mm the centre K of a joint, by the chord of Plug-in Gait.

    K is in the plane of the joint above, the lateral marker and the wand, away from the wand, at half the width from
    the lateral marker and with a right angle between both lines (Davis et al. 1991):

        |K − lateral| = h,   (K − lateral) · (K − above) = 0                                              (1)

    A wand that is turned by `wand_deg` outwards about the segment is first turned back.

    Args:
        above: (…, 3) mm centre of the joint above. lateral, wand: (…, 3) mm markers.
        half_width_mm: of the joint and the marker together. outwards: 1 on the left, −1 on the right.
    """
    K = _chord(above, lateral, wand, half_width_mm)
    for _ in range(ROUNDS if wand_deg else 0):
        axis = unit(above - K)
        K = _chord(above, lateral, _turned(wand, K, axis, -outwards * wand_deg), half_width_mm)
    return K


def _chord(above: Floats, lateral: Floats, wand: Floats, h: float) -> Floats:
    along = lateral - above
    length = np.linalg.norm(along, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        u, c = along / length, h / length
        sine = np.sqrt(1 - c * c)
    return lateral - h * (c * u + sine * perpendicular(wand - above, u))  # (1)


def _turned(point: Floats, about: Floats, axis: Floats, deg: float) -> Floats:
    """(…, 3) a point turned about an axis through another (Rodrigues)."""
    v, a = point - about, np.radians(deg)
    return (
        about + np.cos(a) * v + np.sin(a) * np.cross(axis, v)
        + (1 - np.cos(a)) * (axis * v).sum(-1, keepdims=True) * axis
    )  # fmt: skip


def mean_length(v: Floats) -> float:
    """Of vectors (…, 3), of those that are known; NaN where none is."""
    length = np.linalg.norm(v, axis=-1)
    known = np.isfinite(length)
    return float(length[known].mean()) if known.any() else np.nan


def relative(parent: Floats, child: Floats) -> Floats:
    """(…, 3, 3) the axes of a child in those of its parent."""
    return np.asarray(np.swapaxes(parent, -1, -2) @ child)


def within_half_turn(deg: Floats) -> Floats:
    """Angles from −180 up to 180 deg."""
    return np.asarray(np.remainder(deg + 180.0, 360.0) - 180.0)
