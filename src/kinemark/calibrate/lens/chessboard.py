"""The inner corners of a chessboard in a grey picture, to a fraction of a pixel.

A corner where four squares meet is a saddle of the grey levels: with the second derivatives of the picture blurred by
a Gaussian of σ px,

    S = σ⁴ (I_xy² − I_xx I_yy)                                           (1)

is positive at saddles, and at no edge. Round a corner at the radius r, the grey level g(θ) is the same on opposite
sides, and changes between dark and light four times (Bennett & Lasenby 2014 build a detector on this), so of its
circular harmonics c_m = mean g(θ) e^(−imθ) the second outweighs the odd ones (2). From one corner to the next, the
dark squares change places with the light ones, so c_2 changes sign (3).

The corners' lattice is grown from these points, reflections and clutter or not (`grid`). Then each is refined: at a
pixel p near the corner q the gradient ∇I is zero (inside a square) or at right angles to the edge, which passes
through q, hence ∇I · (p − q) = 0 and, over a window with weights w,

    (Σ w ∇I ∇Iᵀ) q = Σ w ∇I ∇Iᵀ p                                        (4)  Förstner & Gülch 1987

is solved again from the new q until it rests. The window reaches less than half way to the next corner.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import scipy
from numpy.typing import NDArray

from ...data import KinemarkError
from ...data.array_types import Bools, Floats, Ints
from .dot_grid import order_grid

SCALES = (2.0, 3.5, 1.2)
"""px, σ of the blur, tried one after the other; chosen for boards near and far (see studies/linearisation.py)."""
STRONGEST = 0.05  # of a strong corner's response; weaker ones are none; chosen (see studies/linearisation.py)
SHARES = (1.3, 2.0, 6.0)  # times the corners of the board, taken as candidates; chosen
ANGLES = 32  # directions round a corner at which grey levels are read; chosen (see studies/linearisation.py)
EVEN = 1.5  # times as strong the even harmonic as the odd ones; chosen
STEPS = 20  # of refining a corner at most; chosen (see studies/linearisation.py)
WINDOW = (2.0, 9.0)  # px, least and greatest half width about a corner; chosen (see studies/linearisation.py)


def find_corners(image: NDArray[np.number], *, columns: int, rows: int) -> Floats:
    """The inner corners (rows, columns, 2) px of a chessboard in a picture (H, W) of grey levels.

    As seen, rows run to the right and follow each other downwards (as `order_grid`). A corner that is not found
    is NaN.

    Args:
        image: (H, W) grey levels of any numeric type.
        columns: inner corners in a row: one less than the squares.
        rows: inner corners in a column.

    Raises:
        ValueError: the picture is not (H, W) of at least 16 px each way, or `columns` or `rows` is below 3.
        KinemarkError: no such board is found; the message says how many corners were.
    """
    if image.ndim != 2 or min(image.shape) < 16:
        raise ValueError(f"image has shape {image.shape}, wanted (height, width) of at least 16 px each")
    grey = image.astype(np.float64)
    slopes, found = _slopes(grey), dict[float, tuple[Floats, NDArray[np.complex128]]]()
    best, trouble = None, None
    for share, scale in product(SHARES, SCALES):
        if scale not in found:
            found[scale] = saddles(grey, scale=scale, most=round(max(SHARES) * columns * rows))
        most, (uv, second) = round(share * columns * rows), found[scale]
        try:
            corners = _corners(slopes, uv[:most], second[:most], columns, rows)
        except KinemarkError as error:
            trouble = trouble or error
            continue
        if best is None or np.isnan(corners).sum() < np.isnan(best).sum():
            best = corners
        if not np.isnan(best).any():
            break
    if best is None:
        raise KinemarkError(f"No chessboard of {rows} × {columns} inner corners is found. {trouble}")
    return best


def saddles(grey: Floats, *, scale: float, most: int) -> tuple[Floats, NDArray[np.complex128]]:
    """At most `most` places (n, 2) px that look like corners, the strongest first, and their c_2 (n)."""
    xx, yy, xy = (scipy.ndimage.gaussian_filter(grey, scale, order=order) for order in ((0, 2), (2, 0), (1, 1)))
    strength = scale**4 * (xy**2 - xx * yy)  # (1)
    reach = round(2 * scale)
    peak = strength == scipy.ndimage.maximum_filter(strength, size=2 * reach + 1)
    peak[:reach] = peak[-reach:] = peak[:, :reach] = peak[:, -reach:] = False
    v, u = np.nonzero(peak & (strength > 0))
    order = np.argsort(-strength[v, u])
    order = order[: 4 * most][strength[v, u][order[: 4 * most]] > _floor(strength[v, u])]
    uv = np.column_stack([u, v])[order].astype(np.float64)
    second, alike = _ring(scipy.ndimage.gaussian_filter(grey, scale / 2), uv, 2.5 * scale)
    return uv[alike][:most], second[alike][:most]


def _slopes(grey: Floats) -> list[Floats]:
    """∂I/∂u and ∂I/∂v (H, W), as coefficients of cubic splines."""
    return [
        np.asarray(scipy.ndimage.spline_filter(part, order=3))
        for part in np.gradient(scipy.ndimage.gaussian_filter(grey, 0.7))[::-1]
    ]


def _refined(slopes: list[Floats], uv: Floats, *, radius: Floats) -> Floats:
    """Corners (n, 2) px by (4), from places within a pixel or two, in windows of `radius` (n) px; NaN where lost."""
    q = uv.copy()
    reach = np.arange(-np.ceil(radius.max(initial=1.0)), np.ceil(radius.max(initial=1.0)) + 1)
    offset = np.stack(np.meshgrid(reach, reach), -1).reshape(-1, 2)
    weight = np.exp(-2 * (offset**2).sum(1) / radius[:, None] ** 2)
    for _ in range(STEPS):
        p = q[:, None] + offset
        at = [p[..., 1], p[..., 0]]
        g = np.stack(
            [scipy.ndimage.map_coordinates(s, at, order=3, prefilter=False, mode="nearest") for s in slopes], -1
        )
        G = np.einsum("nk,nki,nkj->nij", weight, g, g)
        right = np.einsum("nk,nki,nkj,kj->ni", weight, g, g, offset)
        step = np.linalg.solve(G + 1e-9 * np.eye(2), right[..., None])[..., 0]  # (4)
        step *= np.minimum(1.0, 1.0 / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-12))
        q = q + step
        if np.abs(step).max(initial=0.0) < 1e-4:
            break
    lost = np.linalg.norm(q - uv, axis=1) > np.maximum(2.0, radius)
    return np.where(lost[:, None], np.nan, q)


def _corners(slopes: list[Floats], uv: Floats, second: NDArray[np.complex128], columns: int, rows: int) -> Floats:
    """Those of saddles (n, 2) px, with their c_2 (n), that are the board's corners, refined; NaN for the others."""
    index = order_grid(uv, columns=columns, rows=rows)
    seen = index >= 0
    parity = np.where(np.indices(index.shape).sum(0) % 2, -1.0, 1.0)
    turn = np.where(seen, parity * second[index], 0.0)
    agrees = (turn * np.conj(turn.sum())).real > 0  # (3)
    if (seen & ~agrees).sum() > 0.1 * seen.sum():
        raise KinemarkError(
            f"{seen.sum()} corners form a grid of {rows} × {columns}, but dark and light squares do not alternate."
        )
    seen &= agrees
    corners = np.full((rows, columns, 2), np.nan)
    corners[seen] = _refined(slopes, uv[index[seen]], radius=_radius(index, uv)[seen])
    return corners


def _radius(index: Ints, uv: Floats) -> Floats:
    """(rows, columns) radius of windows, px, that keep off the neighbouring corners."""
    place = np.where(index[..., None] >= 0, uv[index], np.nan)
    nearest = np.full(index.shape, np.inf)
    for axis in (0, 1):
        gap = np.linalg.norm(np.diff(place, axis=axis), axis=-1)
        gap = np.where(np.isnan(gap), np.inf, gap)
        ends = [(1, 0) if k == axis else (0, 0) for k in (0, 1)], [(0, 1) if k == axis else (0, 0) for k in (0, 1)]
        for end in ends:
            nearest = np.minimum(nearest, np.pad(gap, end, constant_values=np.inf))
    return np.clip(0.45 * np.where(np.isfinite(nearest), nearest, 0.0), *WINDOW)


def _floor(strength: Floats) -> float:
    """Below this a saddle is noise: a small share of what the strongest have."""
    return float(STRONGEST * np.quantile(strength, 1 - min(1.0, 20 / max(len(strength), 1)))) if len(strength) else 0.0


def _ring(grey: Floats, uv: Floats, radius: float) -> tuple[NDArray[np.complex128], Bools]:
    """c_2 (n) at places (n, 2), and whether (2) holds there (n)."""
    theta = 2 * np.pi * np.arange(ANGLES) / ANGLES
    u = uv[:, :1] + radius * np.cos(theta)
    v = uv[:, 1:] + radius * np.sin(theta)
    c = np.fft.fft(scipy.ndimage.map_coordinates(grey, [v, u], order=1, mode="nearest"), axis=1)
    odd = np.sqrt(np.abs(c[:, 1]) ** 2 + np.abs(c[:, 3]) ** 2)
    return c[:, 2], np.abs(c[:, 2]) > EVEN * odd  # (2)
