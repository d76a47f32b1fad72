"""Where a marker is in a gap, by its body and by where it lay on the body before and after.

What the figure of `body_places` is off by in one frame it is off by in the next: soft tissue and joints move slowly. In
the frame's own axes a marker lies r_f = Rᵀ (p − b) off its foretold place. How much that changes in a time τ the trial
shows,

    v(τ) = var (r_{f+τ} − r_f) in each axis,                                                                      (1)

so with the offsets r₁ and r₂ of the last frame before and the first after a gap, and their own variance s² about 0,

    r = (r₁ / v(τ₁) + r₂ / v(τ₂)) σ²,   1 / σ² = 1 / v(τ₁) + 1 / v(τ₂) + 1 / s²                                   (2)

is the best that is linear, if what comes between is a random walk, and the place is b + R r with the covariance
B σ² / s². All three frames are foretold by the neighbours that are seen in each of them, as another neighbour foretells
another place.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from .body_places import LEAST_MM, QUANTILES, Figure, turned

LONGEST_S = 0.5
"""s, the longest τ of which v is measured; chosen: by then offsets have little to do with each other."""
LEAST_PAIRS = 20
"""Of frames by which v of a τ is known; chosen."""


class Places(NamedTuple):
    """N places of markers in frames: marker, frame (N), xyz (N, 3) mm, cov (N, 3, 3) mm²."""

    marker: Ints
    frame: Ints
    xyz: Floats
    cov: Floats


def carried_places(figures: list[Figure], xyz: Floats, wanted: Bools, rate: float) -> Places:
    """The places of markers in the frames that are wanted (M, F), as far as they are known.

    Args:
        xyz: (M, F, 3) mm where markers are, NaN where that is not known, or not well; a wanted frame says nothing.
        rate: Hz.
    """
    xyz = np.where(wanted[..., None], np.nan, xyz)
    parts = [_of_figure(figure, xyz, np.flatnonzero(wanted[figure.marker]), rate) for figure in figures]
    parts = [part for part in parts if len(part.marker)]
    none = np.zeros(0, np.int64)
    if not parts:
        return Places(none, none, np.zeros((0, 3)), np.zeros((0, 3, 3)))
    return Places(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _of_figure(figure: Figure, xyz: Floats, frame: Ints, rate: float) -> Places:
    """The same of one marker."""
    own, y = xyz[figure.marker], xyz[figure.near]
    known = np.flatnonzero(np.isfinite(own[:, 0]))
    at = np.searchsorted(known, frame)
    sides = np.stack([np.r_[-1, known][at], np.r_[known, -1][at]])
    place, cov = carried(figure, own, y, frame, sides, np.arange(float(len(own))), changes(figure, own, y, rate))
    ok = np.isfinite(place).all(1)
    return Places(np.full(int(ok.sum()), figure.marker), frame[ok], place[ok], cov[ok])


def carried(
    figure: Figure,
    own: Floats,
    y: Floats,
    frame: Ints,
    sides: Ints,
    time: Floats,
    v: tuple[Floats, Floats],
) -> tuple[Floats, Floats]:
    """(N, 3) places by (2), NaN where the neighbours do not tell them, and their covariances (N, 3, 3).

    Args:
        own, y: (F, 3) of the marker and (n, F, 3) of its neighbours, mm, NaN where not seen. frame: (N) which frames.
        sides: (S, N) frames from which offsets are carried, −1 for none. time: (F) of frames, in the unit of v.
        v: see `changes`.
    """
    there = np.isfinite(y[:, frame, 0])
    for side in sides:
        both = there & np.isfinite(y[:, side, 0])
        there = np.where((side >= 0) & (both.sum(0) >= 3), both, there)
    place, G, R = turned(figure, np.where(there[..., None], y[:, frame], np.nan))
    r, precision = np.zeros((len(frame), 3)), np.full(len(frame), 1 / figure.spread**2)
    for side in sides:
        b, _, turn = turned(figure, np.where(there[..., None], y[:, side], np.nan))
        offset = np.einsum("fi,fji->fj", own[side] - b, turn)
        good = (side >= 0) & np.isfinite(offset).all(1)
        weight = np.where(good, 1 / np.interp(np.abs(time[frame] - time[side]), *v), 0.0)
        r += np.where(good[:, None], offset, 0.0) * weight[:, None]
        precision += weight
    place = place + np.einsum("fj,fji->fi", r / precision[:, None], R)
    return place, G * (1 / precision)[:, None, None]


def changes(figure: Figure, own: Floats, y: Floats, rate: float) -> tuple[Floats, Floats]:
    """τ in frames and v(τ) mm² by (1), no less than the τ before; beyond the last it is 2 s².

    Args:
        own, y: (F, 3) of the marker and (n, F, 3) of its neighbours, mm, NaN where not seen. rate: Hz.
    """
    b, _, R = turned(figure, y)
    r = np.einsum("fi,fji->fj", own - b, R)
    lags, found = [0.0], [LEAST_MM**2]
    lag = 1
    while lag <= max(LONGEST_S * rate, 1):
        square = ((r[lag:] - r[:-lag]) ** 2).sum(1)
        square = square[np.isfinite(square)]
        if len(square) < LEAST_PAIRS:
            break
        v = float((np.quantile(square, list(QUANTILES)) / list(QUANTILES.values())).max())
        lags.append(lag)
        found.append(max(v, found[-1]))
        lag *= 2
    lags.append(max(lags[-1] + 1, LONGEST_S * rate * 2))
    found.append(max(2 * figure.spread**2, found[-1]))
    return np.array(lags), np.array(found)
