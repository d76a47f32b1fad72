"""Helical axes: the line about and along which a body has moved (Swamidas 1997, 2.16; Spoor and Veldpaus 1980).

A body that goes from (R₀, t₀) to (R₁, t₁) turns by R = R₁ R₀ᵀ, by the angle θ about the unit vector n. It moves along
n by d, and the line goes through s, its point nearest to p:

    d = n · (t₁ − R t₀),   s = p + ½ [v + cot(θ/2) n × v],   v = (R − I) p + t₁ − R t₀ − d n              (1)

A marker's error of σ along each axis moves the line by σ_s ≈ σ / (√K · sin(θ/2)) · √½ for K markers (Woltring et al.
1985) (2), so that small turns tell an axis badly: those below a least turn are NaN.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ..data.array_types import Floats

LEAST_TURN_DEG = 1.0
"""Below which no axis is told; chosen: by (2) a marker that is off by 0.5 mm moves it by 20 mm there."""


class HelicalAxis(NamedTuple):
    """Of frames (…).

    Attributes:
        direction: (…, 3) unit vector. point: (…, 3) mm of the line, nearest to where it was asked.
        turn_deg: (…) about it, 0 to 180. along_mm: (…) shift along it.
    """

    direction: Floats
    point: Floats
    turn_deg: Floats
    along_mm: Floats


def helical_axis(
    R0: Floats, t0: Floats, R1: Floats, t1: Floats, *, near: Floats | None = None,
    least_turn_deg: float = LEAST_TURN_DEG,
) -> HelicalAxis:  # fmt: skip
    """The axis (1) from one pose to another.

    Of a joint, give the poses of the distal body in the proximal one; the axis is in its axes then.

    Args:
        R0, R1: (…, 3, 3) axes as columns. t0, t1: (…, 3) mm origins.
        near: (…, 3) mm, where the point of the line is wanted; the first origin where none is given.
        least_turn_deg: below which direction and point are NaN.

    Raises:
        ValueError: a shape is another.
    """
    if R0.shape[-2:] != (3, 3) or R1.shape != R0.shape or t0.shape != R0.shape[:-1] or t1.shape != t0.shape:
        raise ValueError(f"R0, t0, R1, t1 are {R0.shape}, {t0.shape}, {R1.shape}, {t1.shape}, wanted (…, 3, 3), (…, 3)")
    p = t0 if near is None else np.broadcast_to(near, t0.shape)
    R = R1 @ np.swapaxes(R0, -1, -2)
    vector = _rotation_vector(R)
    angle = np.linalg.norm(vector, axis=-1)
    turned = angle >= np.radians(least_turn_deg)
    with np.errstate(invalid="ignore", divide="ignore"):
        n = np.where(turned[..., None], vector / angle[..., None], np.nan)
        moved = np.einsum("...ij,...j->...i", R, p - t0) + t1 - p  # the body's point at p
        along = (n * moved).sum(-1)
        v = moved - along[..., None] * n
        s = p + (v + np.cross(n, v) / np.tan(angle / 2)[..., None]) / 2  # (1)
    return HelicalAxis(n, s, np.degrees(angle), along)


def helical_axes(
    R: Floats, t: Floats, *, step: int, near: Floats | None = None, least_turn_deg: float = LEAST_TURN_DEG
) -> HelicalAxis:
    """Of each frame the axis from `step` frames before to `step` after, NaN at both ends.

    Args:
        R: (F, 3, 3), t: (F, 3) mm of one body in another. step: frames; longer ones tell axes better and later.
        near: (3) or (F, 3) mm, where the point of the line is wanted. least_turn_deg: below which there is no axis.

    Raises:
        ValueError: the step is none.
    """
    if not 1 <= step <= (len(R) - 1) // 2:
        raise ValueError(f"step is {step}, wanted 1 to {(len(R) - 1) // 2} for {len(R)} frames")
    inner = slice(step, len(R) - step)
    at = near if near is None or near.ndim == 1 else near[inner]
    found = helical_axis(
        R[: -2 * step], t[: -2 * step], R[2 * step :], t[2 * step :], near=at, least_turn_deg=least_turn_deg
    )
    out = [np.full((len(R), *part.shape[1:]), np.nan) for part in found]
    for whole, part in zip(out, found, strict=True):
        whole[inner] = part
    return HelicalAxis(*out)


def _rotation_vector(R: Floats) -> Floats:
    """(…, 3) rad; NaN where R is."""
    flat = R.reshape(-1, 3, 3)
    out = np.full((len(flat), 3), np.nan)
    known = np.isfinite(flat).all((1, 2))
    if known.any():
        out[known] = scipy.spatial.transform.Rotation.from_matrix(flat[known]).as_rotvec()
    return out.reshape(R.shape[:-1])
