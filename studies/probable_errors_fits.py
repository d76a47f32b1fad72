"""Coefficients of probabilities: fitted anew, or those that are kept, times a factor and with another constant."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from kinemark.data.array_types import Floats
from kinemark.edit.probable_errors.probability import COEFFICIENTS

LOOK = -2.94  # log-odds of what is worth a look


def fitted(x: Floats, y: Floats, known: Floats | float = 0.0) -> Floats:
    """Coefficients of the likeliest logistic function beside log-odds that are known, slightly drawn to 0."""
    one = np.column_stack([np.ones(len(x)), x])

    def cost(c: Floats) -> tuple[float, Floats]:
        z = known + one @ c
        slope = one.T @ (scipy.special.expit(z) - y) + 2e-4 * len(x) * np.append(0, c[1:])
        return float((np.logaddexp(0, z) - y * z).sum() + 1e-4 * len(x) * (c[1:] ** 2).sum()), slope

    return scipy.optimize.minimize(cost, np.zeros(one.shape[1]), jac=True, method="L-BFGS-B").x


def rescaled(kind: str, x: Floats, y: Floats) -> Floats:
    """The coefficients that are kept, all times a factor and with another constant: what they say of each other was
    fitted to more errors than there are, and holds; how many there are changes with the tracker."""
    old = np.array(COEFFICIENTS[kind])
    z = old[0] + x @ old[1:]
    a, more = fitted(z[:, None], y, z)
    out: Floats = (1 + more) * old
    out[0] += a
    return out


def levelled(kind: str, x: Floats, y: Floats, of: Sequence[str]) -> Floats:
    """The coefficients that are kept, all times a factor and with another constant, each recording (n) counting the
    same by what it has that is worth a look: else the one that shakes most decides for all."""
    z = np.column_stack([np.ones(len(x)), x]) @ np.array(COEFFICIENTS[kind])
    count = {name: sum(a == name and b > LOOK for a, b in zip(of, z, strict=True)) for name in set(of)}
    weight = np.array([1 / max(count[name], 1) for name in of])

    def cost(c: Floats) -> float:
        u = c[0] + np.exp(c[1]) * z
        return float((weight * (np.logaddexp(0, u) - y * u)).sum() * len(y) / weight.sum() + (c**2).sum() / 2)

    a, b = scipy.optimize.minimize(cost, np.zeros(2)).x
    out: Floats = np.exp(b) * np.array(COEFFICIENTS[kind])
    out[0] += a
    return out
