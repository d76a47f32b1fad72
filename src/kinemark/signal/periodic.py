"""How long the cycle of a periodic motion is (recommended by Swamidas 1997, 5.2).

For sequences y_j(t), NaN where missing, the mean squared difference of samples τ frames apart is

    D(τ) = mean over j and t of [y_j(t + τ) − y_j(t)]² / (2 · mean over j of var y_j)             (1)

over the pairs of which both are there, so that what moves most counts most (the sequences have one unit): about 1 for
what is unrelated and near 0 where τ is a cycle. Its minima lie at the cycle and at its multiples. The cycle is the
first minimum nearly as low as the lowest, D ≤ D_min + 0.1 (D_max − D_min) (2), refined by the parabola through three
values. It is one only if D there is below a limit: a motion that does not come back has none. Walking has two steps a
stride; sequences of both legs differ by a half cycle, so that a stride is found, no step. The sums of (1) are
correlations of the samples and of their masks, done by FFT.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data.array_types import Bools, Floats

FEWEST_PAIRS = 0.25
"""Share of the samples that must have a partner, for (1) to be known; chosen."""
REPEATS = 0.3
"""D below which a motion repeats: 0 where it does so exactly, 1 where it never does; chosen."""
TOLERANCE = 0.1
"""Of the way from the shallowest to the deepest D, the tolerance of (2); chosen."""


def mean_differences(y: Floats, most: int | None = None) -> Floats:
    """D (W,) of (1) for sequences y (K, W) and τ = 0 … W − 1, or below `most`; NaN where too few samples have a
    partner."""
    n = y.shape[1]
    most = n if most is None else min(most, n)
    seen: Bools = ~np.isnan(y)
    y = np.where(seen, y, 0.0)
    scale = float((y**2).mean()) if y.size else 0.0
    y = np.where(seen, y - (y.sum(1) / np.maximum(seen.sum(1), 1))[:, None], 0.0)
    total = float((y**2).sum() / max(seen.sum(), 1))
    if not total > 1e-18 * scale:  # constant but for rounding
        return np.full(most, np.nan)
    y /= np.sqrt(total)
    keys = [row.tobytes() for row in seen]
    masks = dict(zip(keys, seen.astype(float), strict=True))  # few: the axes of a marker have the same
    same = np.array([[float(key == mask) for key in keys] for mask in masks])
    size = scipy.fft.next_fast_len(n + most, real=True)  # so that the ends of τ < most do not meet
    one, square, mask = (scipy.fft.rfft(a, size) for a in (y, same @ y**2, np.array(list(masks.values()))))
    pairs, squares, products = (
        scipy.fft.irfft(spectrum, size)[:most]
        for spectrum in (same.sum(1) @ _power(mask), (square * mask.conj()).real.sum(0), _power(one).sum(0))
    )
    enough = pairs > FEWEST_PAIRS * seen.sum()
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(enough, np.maximum(squares - products, 0.0) / pairs, np.nan)


def _power(spectrum: NDArray[np.complex128]) -> Floats:
    return spectrum.real**2 + spectrum.imag**2


def cycle_length(y: Floats, *, shortest: float, longest: float) -> float:
    """Frames of a cycle of sequences y (K, W) by (2); NaN where they do not repeat.

    Args:
        y: NaN where missing.
        shortest, longest: of cycles looked for, frames.
    """
    first, last = max(int(shortest), 2), min(int(longest) + 1, y.shape[1] - 1)
    D = mean_differences(y, last + 1)
    tau = np.arange(first, last)
    if len(tau) < 1 or not np.isfinite(D[first - 1 : last + 1]).any():
        return float("nan")
    with np.errstate(invalid="ignore"):
        minimum = tau[(D[tau] <= D[tau - 1]) & (D[tau] < D[tau + 1]) & (D[tau] < REPEATS)]
    if not len(minimum):
        return float("nan")
    low, high = D[minimum].min(), np.nanmax(D[: last + 1])
    k = int(minimum[D[minimum] <= low + TOLERANCE * (high - low)][0])  # (2)
    left, here, right = D[k - 1 : k + 2]
    return float(k + 0.5 * (left - right) / max(left - 2 * here + right, 1e-12))
