"""Shapes fitted to the grey levels of small patches, many patches at once.

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

The shape, w, A and b are found together by Levenberg–Marquardt (`numerics.levenberg_marquardt`, many patches at once)
on Σ (grey − I)² weighted by 1 / variance of the pixel. Where the sensor is at its white, the model is held at white as
well and such a pixel says nothing unless the model disagrees (8).

A marker brighter on one side has the light A (1 + a x + b y) U (9), found from the fit without a and b by one linear
step for all parameters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data.array_types import Floats
from ..numerics.levenberg_marquardt import Damping, Iterates, minimise_many

STEPS = 10  # tries of each fit at most; chosen; speed and errors are those of studies/overlapping_markers.py
DAMPING = Damping(1e-3, fixed=(0.2, 10.0))
"""Without unit; in ten tries `studies/kiss_proposed.py --no-videos` finds 99 % of pairs of discs, 96 to 97 % without
`fixed`."""
SMALL_STEP = 1e-3  # px; a tenth of what any noise leaves; chosen (see studies/overlapping_markers.py)
SMALL_GAIN = 0.01
"""Of χ² a pixel; a tenth of a standard deviation of one parameter; chosen (see studies/overlapping_markers.py)."""
HOPELESS = 0.03
"""Of χ²; a step that gains less leads nowhere near a χ² that is far below; chosen (see
studies/overlapping_markers.py)."""
NODES, NODE_WEIGHTS = (half / 2 for half in np.polynomial.legendre.leggauss(7))
"""Of Gauss and Legendre's rule over the shutter's time, exact to degree 13; chosen."""
CORNER = 3.5  # w; farther from one of two outlines the other is alone; chosen (see studies/overlapping_markers.py)
NODES_CORNER, WEIGHTS_CORNER = (
    (np.polynomial.legendre.leggauss(6)[0] + 1) / 2,
    np.polynomial.legendre.leggauss(6)[1] / 2,
)
"""Of the same rule over the integral of (2), exact to degree 11; chosen (see studies/overlapping_markers.py)."""
FLOOR = 0.02**2 * np.pi / 4
"""px² · px²; 0.02 px of error for a disc of 1 px, less for larger ones, which square pixels of a sharp image leave;
chosen (see studies/overlapping_markers.py)."""
MOST_CONDITION = 1e12  # of a normal matrix that is inverted, without unit; conventional: four digits are then left
WIDTHS = (0.25, 3.0)  # px; of the blur w; chosen (see studies/overlapping_markers.py)
INVERSE_ROOT_2PI = 0.3989422804014327  # 1 / √(2π), the height of the normal density; by definition
_TINY = 1e-9  # px; keeps a distance of zero from dividing; conventional


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


class DiscFit(NamedTuple):
    """What fits best: p parameters of the shape, then w, A and b.

    Attributes:
        parameters: (n, p + 3).
        cov: (n, p + 3, p + 3) by the weights; NaN where the pixels do not determine them, or the fit was given up.
        chi2: (n) weighted sum of squares.
        model: (n, N) grey levels.
    """

    parameters: Floats
    cov: Floats
    chi2: Floats
    model: Floats


Shape = Callable[[Floats, Floats, Patches, Floats], Floats]
"""U (n, N) from parameters (n, p) and w (n) over patches; its derivatives by these are written to (n, p + 1, N)."""


def fit(
    shape: Shape, start: Floats, patches: Patches, *, wanted: Floats | None = None, enough: Floats | float = 0.0
) -> DiscFit:
    """The shape's parameters that explain each patch best, from start (n, p + 3).

    A fit that is above the χ² `wanted` (n) and hardly gets better is given up; one below `enough` (n) is good enough.
    """
    wanted = np.full(len(start), np.inf) if wanted is None else wanted
    used = np.maximum((patches.weight > 0).sum(1), 1)
    problems = _Shapes(shape, patches, wanted, np.broadcast_to(enough, len(start)), used)
    found = minimise_many(problems, problems.at(start.copy(), patches), steps=STEPS, damping=DAMPING)
    model, J = found.equations
    return DiscFit(found.parameters, _covariance(J, patches, found.cost <= wanted), found.cost, model)


@dataclass(frozen=True, slots=True)
class _Shapes:
    """The problems of `fit` for `minimise_many`; `used` (n) pixels have weight."""

    shape: Shape
    patches: Patches
    wanted: Floats
    enough: Floats
    used: NDArray[np.int64]

    def at(self, p: Floats, patches: Patches) -> Iterates:
        """Parameters with the patches' models and derivatives."""
        model, J = _image(self.shape, p, patches)
        return Iterates(p, _chi2(model, patches), (model, J))

    def step(self, which: NDArray[np.int64], now: Iterates, damping: Floats) -> tuple[Iterates, Floats]:
        """After the step, w within its bounds and A above 1."""
        part = self.patches if len(which) == len(self.patches.x) else self.patches.take(which)
        model, J = now.equations
        step, predicted = _step(J, model, part, damping)
        return self.at(_held(now.parameters + step), part), predicted

    def converged(self, which: NDArray[np.int64], now: Iterates, tried: Iterates) -> NDArray[np.bool_]:
        """Whether the step was small, or brought little, or the fit is good enough."""
        chi2, wanted = tried.cost, self.wanted[which]
        small = np.where(chi2 > wanted, HOPELESS * chi2, SMALL_GAIN * np.maximum(1.0, chi2 / self.used[which]))
        moved = np.abs(tried.parameters - now.parameters)[:, :-2].max(1)
        return np.asarray((moved < SMALL_STEP) | (now.cost - chi2 < small) | (chi2 < self.enough[which]))


def _covariance(J: Floats, patches: Patches, some: NDArray[np.bool_]) -> Floats:
    """(n, p, p) the inverse of the normal matrix, NaN where that is singular and for all but some (n)."""
    cov = np.full((len(J), J.shape[1], J.shape[1]), np.nan)
    some = some & np.isfinite(J).all((1, 2))
    H, d = _scaled(_normal(J[some], patches.take(some)))
    inverse = np.linalg.inv(H + 1e-14 * np.eye(H.shape[1]))
    known = np.linalg.norm(H, axis=(1, 2)) * np.linalg.norm(inverse, axis=(1, 2)) < MOST_CONDITION
    cov[some] = np.where(known[:, None, None], inverse / (d[:, :, None] * d[:, None]), np.nan)
    return cov


def lit_from_a_side(shape: Shape, found: DiscFit, patches: Patches) -> DiscFit:
    """The fit with brightness that also rises along x and along y, by one linear step (9); no covariance."""
    model, J = _image(shape, found.parameters, patches)
    bright = model - found.parameters[:, -1, None]
    rising = [bright * (at - at.mean(1, keepdims=True)) for at in (patches.x, patches.y)]
    J = np.concatenate([J, np.stack(rising, 1)], 1)
    change = np.einsum("np,npk->nk", _step(J, model, patches, np.zeros(len(J)))[0], J)
    better = _chi2(model + change, patches) < found.chi2
    model = model + np.where(better[:, None], change, 0.0)
    return DiscFit(found.parameters, np.full_like(found.cov, np.nan), _chi2(model, patches), model)


def discs(p: Floats, w: Floats, patches: Patches, J: Floats) -> Floats:
    """(4): p (n, 3k) holds x, y and r of each disc."""
    k = p.shape[1] // 3
    x, y, r = (p[:, i::3, None] for i in range(3))
    dx, dy = patches.x[:, None] - x, patches.y[:, None] - y
    far = np.sqrt(dx * dx + dy * dy) + _TINY
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
    q = np.sqrt(mx * mx + my * my) + _TINY
    qx, qy = (xx * mx + xy * my) / q, (xy * mx + yy * my) / q
    steepness = np.sqrt(qx * qx + qy * qy) + _TINY
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
    far = np.sqrt(dx * dx + dy * dy) + _TINY
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
    rho = np.clip(rho, -0.999, 0.999)
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


def _image(shape: Shape, p: Floats, patches: Patches) -> tuple[Floats, Floats]:
    """Grey levels (n, N) by (1), and their derivatives (n, p + 3, N)."""
    p = p.astype(patches.x.dtype, copy=False)
    A, b = p[:, -2, None], p[:, -1, None]
    J = np.empty((*p.shape, patches.x.shape[1]), p.dtype)
    cover = shape(p[:, :-3], p[:, -3], patches, J[:, :-2])
    J[:, :-2] *= A[:, None]
    J[:, -2], J[:, -1] = cover, 1.0
    model = b + A * cover
    white = patches.white[:, None]
    if np.isfinite(white).any():
        J *= (model < white)[:, None]  # (8)
        model = np.minimum(model, white)
    return model, J


def _chi2(model: Floats, patches: Patches) -> Floats:
    off = patches.grey - model
    return np.asarray((patches.weight * off * off).sum(1))


def _normal(J: Floats, patches: Patches) -> Floats:
    return np.asarray((J * patches.weight[:, None]) @ J.transpose(0, 2, 1))


def _scaled(H: Floats) -> tuple[Floats, Floats]:
    """H with ones along its diagonal, and the roots of what it was."""
    d = np.sqrt(np.maximum(np.einsum("nii->ni", H), 1e-12))
    return H / (d[:, :, None] * d[:, None]), d


def _step(J: Floats, model: Floats, patches: Patches, damping: Floats) -> tuple[Floats, Floats]:
    """Levenberg–Marquardt's step (n, p + 3), and by how much (n) it predicts to lower χ²."""
    H, d = _scaled(_normal(J, patches))
    pull = np.einsum("npk,nk->np", J, patches.weight * (patches.grey - model)) / d
    H = H + (damping[:, None, None] + 1e-9) * np.eye(H.shape[1])
    step = np.linalg.solve(H, pull[..., None])[..., 0]
    predicted = np.einsum("np,np->n", step, pull + damping[:, None] * step)
    return np.asarray(np.clip(step / d, -50, 50)), predicted


def _held(p: Floats) -> Floats:
    """The parameters with w within its bounds and A above 1."""
    p[:, -3] = np.clip(p[:, -3], *WIDTHS)
    p[:, -2] = np.maximum(p[:, -2], 1.0)
    return p
