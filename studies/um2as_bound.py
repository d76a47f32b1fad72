"""Bounds on the error of a camera's eleven parameters: a textbook's that UM²AS could not use, and two that hold.

Control points moved by R px in any directions change A L = b (UM²AS eq. 4.6; (2) of `um2as_equations`) by δA and δb.
Where the unmoved points fit, A L = b exactly, and (UM²AS eq. 4.7, from Usmani 1991)

    ‖δL‖ / ‖L‖ ≤ ‖A⁺‖ / (1 − κ) · (‖δb‖ / ‖L‖ + ‖δA‖)    where    κ = ‖A⁺‖ ‖δA‖ < 1            (1)

(A⁺ for the A⁻¹ of eq. 4.7, since A has more rows than columns; the norms are the spectral ones.) Neither norm of a
change depends on the directions θ: δA holds −Δu X and −Δv X, so δAᵀδA = R² Σ X Xᵀ, as Δu² + Δv² = R², and

    ‖δA‖ = R σ_max(X),    ‖δb‖ = R √N                                                        (2)

"Unfortunately this condition was not met by the perturbed matrices" (UM²AS 4.3): in its units, px and cm, κ is 210 to
330, and ten times that with mm. That is the units' fault, not the laboratory's. With columns of A of unit length, (1)
bounds the parameters in units of their own; κ is then 0.03, and the bound holds, though it is loose.

To first order the error of equation 4.11 has a bound of its own without a condition, and a tight one. With the gain
G = dL / d(u, v) of (5) of `um2as_equations`, and N points moved by R each,

    ‖δL‖ / ‖L‖ ≤ ‖G‖ R √N / ‖L‖                                                              (3)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from um2as_equations import fit_parameters, parameter_gain, rows

from kinemark.data.array_types import Floats


class ParameterBound(NamedTuple):
    """κ of (1), and the largest ‖δL‖ / ‖L‖ by it, percent; NaN where κ is 1 or more, since (1) says nothing then."""

    kappa: float
    percent: float


def parameter_bound(points: Floats, uv: Floats, radius: float, *, unit_columns: bool = False) -> ParameterBound:
    """The bound (1) for control points (N, 3) that a camera sees at (N, 2) px, each moved by `radius` px.

    Args:
        points: in any unit of length; (1) depends on it unless `unit_columns`.
        uv: where the unmoved points are seen, px.
        radius: px.
        unit_columns: for the parameters times the lengths of the columns of A, of which each has the same weight.

    Raises:
        KinemarkError: fewer than six points, or points in one plane.
    """
    L = fit_parameters(points, uv)
    A = rows(points, uv).reshape(-1, len(L))
    size = np.linalg.norm(A, axis=0) if unit_columns else np.ones(len(L))
    back, length = np.linalg.norm(np.linalg.pinv(A / size), 2), np.linalg.norm(L * size)
    dA, db = radius * np.linalg.norm(points / size[8:], 2), radius * np.sqrt(len(points))  # (2)
    kappa = float(back * dA)
    percent = 100 * back / (1 - kappa) * (db / length + dA) if kappa < 1 else np.nan  # (1)
    return ParameterBound(kappa, float(percent))


def first_order_bound(points: Floats, uv: Floats, radius: float) -> float:
    """The bound (3), percent, for control points (N, 3) that a camera sees at (N, 2) px, each moved by `radius` px.

    Raises:
        KinemarkError: fewer than six points, or points in one plane.
    """
    gain = np.linalg.norm(parameter_gain(points, uv), 2)
    return float(100 * gain * radius * np.sqrt(len(points)) / np.linalg.norm(fit_parameters(points, uv)))  # (3)
