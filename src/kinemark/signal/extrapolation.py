"""Where a sequence goes next: the extrapolation ladder of KISS 4.3.

The last n samples y(−n+1) … y(0) are fitted by a polynomial of degree d in time by least squares, and the polynomial is
read at time 1. With the Vandermonde matrix V of the times −n+1 … 0,

    ŷ(1) = [1 1 … 1] V⁺ y = w · y                                        (1)

so each rung of the ladder is a fixed row of weights, and the variance of the prediction is σ² Σ w².

    samples known   1                   2                 3, 4                        5 or more
    fit             nearest (constant)  straight line     line through the last 3     parabola through the last 5
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats, Ints

LADDER = ((1, 0), (2, 1), (3, 1), (3, 1), (5, 2))
"""(samples, degree) for 1, 2, 3, 4, and 5 or more known samples; chosen."""


def weights(samples: int, degree: int) -> Floats:
    """w (samples,) of (1), oldest first.

    Raises:
        ValueError: the degree is not below the number of samples.
    """
    if not 0 <= degree < samples:
        raise ValueError(f"degree {degree} needs more than {samples} samples")
    past = np.vander(np.arange(1 - samples, 1), degree + 1, increasing=True)
    return np.ones(degree + 1) @ np.linalg.pinv(past)


PAST = 5
"""Samples that the ladder looks back on; by definition."""

RUNGS = np.array([np.pad(weights(n, d), (PAST - n, 0)) for n, d in LADDER])
"""Weights of the last five samples for each rung of `LADDER`; exact."""


def extrapolate(history: Floats, known: Ints) -> Floats:
    """The next sample (T, k) of T sequences from their last five (T, 5, k), oldest first.

    Args:
        history: where fewer than five are known, the unknown ones come first and may hold anything finite.
        known: (T) how many are known, at least 1.
    """
    return np.einsum("tn,tnk->tk", RUNGS[np.minimum(known, PAST) - 1], history)


def gain(known: Ints) -> Floats:
    """Σ w² (T): how many times the variance of a sample the variance of the prediction is."""
    return (RUNGS**2).sum(1)[np.minimum(known, PAST) - 1]
