"""What shapes look like: their light in small patches, many patches at once, and its derivatives.

A shape is an outline with a signed distance s(x), positive inside, in px. Blurred by a Gaussian of standard deviation w
(the lens's blur, and 1/12 px² of the pixel), its light at a pixel is, where the outline is nearly straight over w,

    U(x) = Φ(s(x) / w),    I(x) = b + A U(x)                              (1)

with Φ the normal distribution function. Two outlines with unit gradients g₁, g₂ that both must hold (an intersection)
are two half planes near the corner where they cross; their blurred light is the chance that two normal variables with
correlation ρ = g₁ · g₂ both hold (Plackett 1954), with h = s₁ / w and k = s₂ / w

    Φ₂(h, k; ρ) = Φ(h) Φ(k) + (1/2π) ∫ exp(−(h² + k² − 2 h k sin θ) / (2 cos² θ)) dθ,   0 ≤ θ ≤ asin ρ
    ∂Φ₂ / ∂h = φ(h) Φ((k − ρ h) / √(1 − ρ²))                              (2)

where the integral matters only near the corner. A union is what is not outside of all: 1 − Φ₂(−h, −k; ρ) of the two
outlines that are nearest or deepest there (3).

    discs     s = rᵢ − |x − cᵢ|, by (3)                                                   (4)
    ellipse   q = |M (x − c)| with M symmetric, s = (1 − q) / |∇q|                        (5)
    motion    a disc that moves by v while the shutter is open: the mean of (1) over c + t v, −½ ≤ t ≤ ½   (6)
    cut       a disc and the half plane x cos θ + y sin θ < h, by (2)                      (7)

Where the sensor is at its white, the model is held at white as well and such a pixel says nothing unless the model
disagrees (8).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data.array_types import Floats

NODES, NODE_WEIGHTS = (half / 2 for half in np.polynomial.legendre.leggauss(7))
"""Of Gauss and Legendre's rule over the shutter's time, exact to degree 13; chosen."""
CORNER = 3.5  # w; farther from one of two outlines the other is alone; chosen (see studies/overlapping_markers.py)
NODES_CORNER, WEIGHTS_CORNER = (
    (np.polynomial.legendre.leggauss(6)[0] + 1) / 2,
    np.polynomial.legendre.leggauss(6)[1] / 2,
)
"""Of the same rule over the integral of (2), exact to degree 11; chosen (see studies/overlapping_markers.py)."""
MOST_CORRELATION = 0.999  # ρ; nearer to 1 the two outlines are one and (2) divides by zero; chosen
INVERSE_ROOT_2PI = 0.3989422804014327  # 1 / √(2π), the height of the normal density; by definition
TINY = 1e-9  # px; keeps a distance of zero from dividing; conventional


class Patches(NamedTuple):
    """n patches of N pixels each, filled up with pixels of weight 0.

    Attributes:
        x, y: (n, N) places, px, such that discs are round.
        grey: (n, N) grey levels.
        weight: (n, N) 1 / variance of each pixel; 0 where it belongs to something else or lies outside the image.
        white: (n) level at which the sensor is saturated; inf where it is not.
    """

    x: Floats
    y: Floats
    grey: Floats
    weight: Floats
    white: Floats

    def take(self, index: NDArray[np.integer] | NDArray[np.bool_]) -> Patches:
        """Some of the patches."""
        return Patches(*(column[index] for column in self))


Shape = Callable[[Floats, Floats, Patches, Floats], Floats]
"""U (n, N) from parameters (n, p) and w (n) over patches; its derivatives by these are written to (n, p + 1, N)."""


def discs(p: Floats, w: Floats, patches: Patches, J: Floats) -> Floats:
    """(4): p (n, 3k) holds x, y and r of each disc."""
    k = p.shape[1] // 3
    x, y, r = (p[:, i::3, None] for i in range(3))
    dx, dy = patches.x[:, None] - x, patches.y[:, None] - y
    far = np.sqrt(dx * dx + dy * dy) + TINY
    s, gx, gy = r - far, dx / far, dy / far
    rim, width = w[:, None, None], w[:, None]
    slope = _bell(s / rim) / rim
    if k == 1:
        cover = scipy.special.ndtr(s[:, 0] / width)
    else:
        two = np.argsort(-s, axis=1)[:, :2] if k > 2 else None
        (a, b), (ax, bx), (ay, by) = (
            (g if two is None else np.take_along_axis(g, two, 1)).transpose(1, 0, 2) for g in (s, gx, gy)
        )
        outside, of_a, of_b = _both(-a / width, -b / width, ax * bx + ay * by)  # (3)
        if two is None:
            slope[:, 0] *= of_a
            slope[:, 1] *= of_b
        else:
            share = np.zeros_like(s)
            np.put_along_axis(share, two, np.stack([of_a, of_b], 1), 1)
            slope *= share
        cover = 1 - outside
    np.multiply(slope, gx, out=J[:, 0:-1:3])
    np.multiply(slope, gy, out=J[:, 1:-1:3])
    J[:, 2:-1:3] = slope
    J[:, -1] = -(slope * s).sum(1) / width
    return np.asarray(cover)


def ellipse(p: Floats, w: Floats, patches: Patches, J: Floats) -> Floats:
    """(5): p (n, 5) holds x, y and M's xx, xy and yy."""
    x, y, xx, xy, yy = (column[:, None] for column in p.T)
    dx, dy = patches.x - x, patches.y - y
    mx, my = xx * dx + xy * dy, xy * dx + yy * dy
    q = np.sqrt(mx * mx + my * my) + TINY
    qx, qy = (xx * mx + xy * my) / q, (xy * mx + yy * my) / q
    steepness = np.sqrt(qx * qx + qy * qy) + TINY
    z = (1 - q) / (steepness * w[:, None])
    slope = _bell(z) / w[:, None]
    by_q = slope / steepness
    np.multiply(by_q, qx, out=J[:, 0])
    np.multiply(by_q, qy, out=J[:, 1])
    by_q /= -q
    J[:, 2], J[:, 3], J[:, 4] = by_q * (mx * dx), by_q * (mx * dy + my * dx), by_q * (my * dy)
    np.multiply(slope, -z, out=J[:, 5])
    return np.asarray(scipy.special.ndtr(z))


def motion(p: Floats, w: Floats, patches: Patches, J: Floats) -> Floats:
    """(6): p (n, 5) holds x, y, r and the two parts of v."""
    cover, part = np.zeros_like(patches.x), np.empty_like(J[:, :4])
    J[:] = 0.0
    for t, weight in zip(NODES, NODE_WEIGHTS, strict=True):
        moved = np.stack([p[:, 0] + t * p[:, 3], p[:, 1] + t * p[:, 4], p[:, 2]], 1)
        cover += weight * discs(moved, w, patches, part)
        part *= weight
        J[:, :3] += part[:, :3]
        J[:, 3:5] += t * part[:, :2]
        J[:, 5] += part[:, 3]
    return cover


def cut(p: Floats, w: Floats, patches: Patches, J: Floats) -> Floats:
    """(7): p (n, 5) holds x, y, r, θ and h."""
    x, y, r, turn, h = (column[:, None] for column in p.T)
    dx, dy = patches.x - x, patches.y - y
    far = np.sqrt(dx * dx + dy * dy) + TINY
    c, s = np.cos(turn), np.sin(turn)
    s1, s2 = r - far, h - (patches.x * c + patches.y * s)
    rim = w[:, None]
    U, of_1, of_2 = _both(s1 / rim, s2 / rim, (dx * c + dy * s) / far)  # (2)
    k1, k2 = of_1 * _bell(s1 / rim) / rim, of_2 * _bell(s2 / rim) / rim
    J[:, 0], J[:, 1], J[:, 2] = k1 * dx / far, k1 * dy / far, k1
    J[:, 3], J[:, 4] = k2 * (patches.x * s - patches.y * c), k2
    J[:, 5] = -(k1 * s1 + k2 * s2) / rim
    return U


def _both(h: Floats, k: Floats, rho: Floats) -> tuple[Floats, Floats, Floats]:
    """(2) and its derivatives by h and k, ρ held, both without the factor φ."""
    rho = np.clip(rho, -MOST_CORRELATION, MOST_CORRELATION)
    a, b = scipy.special.ndtr(h), scipy.special.ndtr(k)
    of_h, of_k = b.copy(), a.copy()
    both = a * b
    near = np.flatnonzero((np.abs(h) < CORNER) & (np.abs(k) < CORNER))
    x, y, r = h.reshape(-1)[near], k.reshape(-1)[near], rho.reshape(-1)[near]
    root = np.sqrt(1 - r * r)
    of_h.reshape(-1)[near], of_k.reshape(-1)[near] = (
        scipy.special.ndtr((y - r * x) / root),
        scipy.special.ndtr((x - r * y) / root),
    )
    end = np.arcsin(r)
    theta = end * NODES_CORNER[:, None]
    sine = np.sin(theta)
    kernel = np.exp((x * y * sine - (x * x + y * y) / 2) / (1 - sine * sine))
    both.reshape(-1)[near] += end / (2 * np.pi) * (WEIGHTS_CORNER @ kernel)
    return both, of_h, of_k


def _bell(z: Floats) -> Floats:
    """The normal density."""
    return np.asarray(INVERSE_ROOT_2PI * np.exp(-0.5 * z * z))


def image(shape: Shape, p: Floats, patches: Patches) -> tuple[Floats, Floats]:
    """Grey levels (n, N) by (1), and their derivatives (n, p + 3, N)."""
    p = p.astype(patches.x.dtype, copy=False)
    A, b = p[:, -2, None], p[:, -1, None]
    J = np.empty((*p.shape, patches.x.shape[1]), p.dtype)
    cover = shape(p[:, :-3], p[:, -3], patches, J[:, :-2])
    J[:, :-2] *= A[:, None]
    J[:, -2], J[:, -1] = cover, 1.0
    model = b + A * cover
    white = patches.white[:, None]
    if (white < np.inf).any():
        over = ~(model < white) & (white < np.inf)  # (8)
        J *= ~over[:, None]
        model = np.where(over, np.minimum(model, white), model)
    return model, J
