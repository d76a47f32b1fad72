"""Whether a lens term is missing: residuals that go with the place in the image.

The residuals r of a camera's n images, px, are at right angles to what was fitted: to the columns A of dr / d
parameters that were free. A term that was held, though the lens has it, leaves what the free ones cannot imitate.
With B the columns of held terms, without what A explains of them, the terms that explain most are those of
the least squares

    c = B⁺ r,    trend = B c,    gain = |trend|² / s²,    s² = |r − trend|² / 2 n        (1)

and gain is χ² of as many degrees of freedom as B has columns where nothing is missing. Points that were fitted too have
taken a part of r and of the trend: the true one is greater.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

from ...data import PARAMETERS, Camera
from ...data.array_types import Bools, Floats
from ...geometry import parameter_jacobian

RADIAL = np.isin(PARAMETERS, ("k1", "k2", "k3"))  # by definition
SIDEWAYS = np.isin(PARAMETERS, ("cx", "cy", "p1", "p2"))  # by definition
FEWEST = 100
"""Images of points from which residuals are looked at; chosen (see benchmarks/room.py)."""
CHANCE = 1e-6
"""Of a trend as large as this without a missing term; chosen, as a session has many cameras and noise is not white."""


class LensTrend(NamedTuple):
    """px RMS by which residuals go with the place in the image, as a share of their own noise too; which terms."""

    px: float
    ratio: float
    terms: str


NONE = LensTrend(0.0, 0.0, "")


def lens_trend(camera: Camera, xyz: Floats, residual: Floats) -> LensTrend | None:
    """The trend (1) beyond chance in residuals (N, 2) px of points (N, 3) mm, zero where there is none.

    None where fewer than `FEWEST` are finite, or no lens term was held. `terms` is "radial", "sideways" (tangential
    terms, or the principal point), or "radial, sideways" where neither makes four fifths of it.
    """
    there = np.isfinite(residual).all(1) & np.isfinite(xyz).all(1)
    free = camera.cov.diagonal() > 0
    groups = [group & ~free for group in (RADIAL, SIDEWAYS)]
    if there.sum() < FEWEST or not (groups[0] | groups[1]).any():
        return None
    T, r = parameter_jacobian(camera, xyz[there]).reshape(-1, len(free)), residual[there].ravel()
    T = T / np.maximum(np.linalg.norm(T, axis=0), 1e-300)
    both = _trend(T, free, groups, r)
    noise = float(((r - both) ** 2).mean())
    size = float((both**2).mean())
    if scipy.stats.chi2.sf(size * len(r) / noise, int(np.sum(groups))) > CHANCE:
        return NONE
    alone = [float((_trend(T, free, [group], r) ** 2).mean()) if group.any() else 0.0 for group in groups]
    named = zip(("radial", "sideways"), alone, alone[::-1], strict=True)
    words = [word for word, part, other in named if part >= other / 4]
    return LensTrend(float(np.sqrt(2 * size)), float(np.sqrt(size / noise)), ", ".join(words))


def _trend(T: Floats, free: Bools, held: Sequence[Bools], r: Floats) -> Floats:
    """B c of (1)."""
    A, B = np.linalg.qr(T[:, free])[0], T[:, np.any(held, axis=0)]
    B = B - A @ (A.T @ B)
    return np.asarray(B @ np.linalg.lstsq(B, r, rcond=1e-9)[0])
