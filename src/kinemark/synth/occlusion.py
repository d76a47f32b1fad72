"""Lines of sight and the limbs in their way.

A line of sight runs from the camera's centre o along d to the marker, o + s d with 0 ≤ s ≤ 1; the axis of a
capsule from a along e = b − a, a + t e with 0 ≤ t ≤ 1. With w = o − a the nearest points of the two endless
lines have

    s = [(d·e)(e·w) − (e·e)(d·w)] / [(d·d)(e·e) − (d·e)²]                          (1)
    t = [(e·w) + s (d·e)] / (e·e)                                                  (2)

If t falls outside [0, 1] it is clamped, and s follows from s = [t (d·e) − (d·w)] / (d·d), clamped too (3)
(Ericson 2005, Real-Time Collision Detection, 5.1.9). The limb hides what is on the line when the distance of the
nearest points is less than its radius.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats


def line_distance(o: Floats, d: Floats, a: Floats, b: Floats) -> Floats:
    """Distance (…) mm between the lines of sight from o (…, 3) to o + d and the axes from a to b (…, 3)."""
    w, e = o - a, b - a
    dd, ee, de, dw, ew = _dot(d, d), _dot(e, e), _dot(d, e), _dot(d, w), _dot(e, w)
    tiny = np.finfo(np.float64).tiny
    below = dd * ee - de * de
    s = np.where(below > 1e-12 * dd * ee, (de * ew - ee * dw) / np.maximum(below, tiny), 0.0)  # (1)
    s = np.clip(s, 0, 1)
    t = np.clip((ew + s * de) / np.maximum(ee, tiny), 0, 1)  # (2)
    s = np.clip((t * de - dw) / np.maximum(dd, tiny), 0, 1)  # (3)
    gap = w + s[..., None] * d - t[..., None] * e
    return np.sqrt(_dot(gap, gap))


def _dot(x: Floats, y: Floats) -> Floats:
    return x[..., 0] * y[..., 0] + x[..., 1] * y[..., 1] + x[..., 2] * y[..., 2]


def visible_fraction(centre: Floats, xyz: Floats, radius: Floats, a: Floats, b: Floats, limb: Floats) -> Floats:
    """How much of each marker the limbs leave in sight, as the share of seven lines of sight that are free.

    One line goes to the marker's centre and six to points at 0.75 of its radius around it, perpendicular to the line.

    Args:
        centre: (3) of the camera, mm.
        xyz: (M, F, 3) markers, mm.
        radius: (M) of the markers, mm.
        a: (L, F, 3) and b: ends of the limbs' axes, mm.
        b: see a.
        limb: (L) radius of the limbs, mm.

    Returns:
        (M, F) from 0, hidden, to 1; NaN where the marker is not there.
    """
    free = np.ones((7, *xyz.shape[:2]), bool)
    sight = _sight_lines(centre, xyz, radius)
    for k in range(len(limb)):
        near = line_distance(centre, xyz - centre, a[k], b[k]) < limb[k] + radius[:, None]
        m, f = np.nonzero(near)
        free[:, m, f] &= line_distance(centre, sight[:, m, f], a[k, f], b[k, f]) >= limb[k]
    return np.where(np.isfinite(xyz).all(-1), free.mean(0), np.nan)


def _sight_lines(centre: Floats, xyz: Floats, radius: Floats) -> Floats:
    """(7, M, F, 3) from the camera to the centre of each marker and to six points around it."""
    line = xyz - centre
    forward = line / np.linalg.norm(line, axis=-1, keepdims=True)
    side = perpendicular(forward)
    up = np.cross(forward, side)
    turn = np.arange(6)[:, None, None, None] * np.pi / 3
    around = 0.75 * radius[:, None, None] * (np.cos(turn) * side + np.sin(turn) * up)
    return np.concatenate([line[None], line + around])


def perpendicular(forward: Floats) -> Floats:
    """A unit vector (…, 3) perpendicular to each unit vector (…, 3)."""
    other = np.where(np.abs(forward[..., 2:]) < 0.9, np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]))
    side = np.cross(other, forward)
    return side / np.linalg.norm(side, axis=-1, keepdims=True)
