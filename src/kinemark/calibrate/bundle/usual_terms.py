"""Which lens terms are left at what is usual of them, as the images tell nothing else.

Terms v with a prior about v₀ (`lens_prior`) are fitted with the others, to m = v̂ − v₀ with covariance P, in units of
the images' noise s and with the prior's precision Λ. Fitting them makes the other parameters less certain, which is
more than is won where v₀ is nearly true. Holding them adds

    mᵀ P⁻¹ m / s²                                                        (1)

to the sum of squares, and saves as many parameters as the images determine,

    γ = tr(1 − P Λ)                                                      (2)

(MacKay 1992). They are held if (1) is less than 2 γ (3), as Akaike (1974) judges models. Kinds of terms (`KINDS`) are
judged together over all cameras, and those are held for which (1) − 2 γ is least. The covariance remains that of the
fit in which they were free: a held term may be off by as much as the images leave open.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from .lens_prior import at_usual, directions_of, values_of
from .parameter_covariance import joint_covariance
from .robust_adjustment import degrees_of_freedom
from .solver import BundleState, Freedom, ImageObservations, cost, normal_equations, solve

KINDS = np.array([0, 1, 1, 2, 2, 1])
"""Of `lens_prior` (1): the pixels' shape, radial terms, tangential terms; by definition."""
PRICE = 2.0  # of a parameter, in squares of standard deviations, (3); Akaike (1974)
NEAR = 1e-5  # share of the cost that the last fit may still fall by; chosen: far less than one standard deviation


def with_usual_terms(
    state: BundleState, seen: ImageObservations, freedoms: tuple[Freedom, ...], kept: Bools
) -> BundleState:
    """The state with needless terms at their usual values, fitted to the points `kept` (C, N) again."""
    held = needless(state, seen._replace(used=kept), freedoms)
    if not held.any():
        return state
    cameras = tuple(
        at_usual(camera, f.prior, held[KINDS]) if f.prior else camera
        for f, camera in zip(freedoms, state.cameras, strict=True)
    )
    fewer = tuple(freedom.held(held[KINDS]) for freedom in freedoms)
    return solve(state._replace(cameras=cameras), seen._replace(used=kept), fewer, tolerance=NEAR)


def needless(state: BundleState, seen: ImageObservations, freedoms: tuple[Freedom, ...]) -> Bools:
    """Which of the three `KINDS` are held by (3), of a state that fits best."""
    kind, m, P, precision = _terms(state, seen, freedoms)
    best, least = np.zeros(3, np.bool_), 0.0
    for held in map(np.array, product([False, True], repeat=3)):
        i = held[kind]
        block = P[np.ix_(i, i)]
        won = m[i] @ np.linalg.solve(block, m[i]) - PRICE * (1 - np.diag(block) * precision[i]).sum()  # (1), (2)
        if won < least:
            best, least = held, won
    return best


def _terms(
    state: BundleState, seen: ImageObservations, freedoms: tuple[Freedom, ...]
) -> tuple[Ints, Floats, Floats, Floats]:
    """Of all cameras' terms with a prior: their kind, m / s, P and the diagonal of Λ."""
    covariance, gauge = joint_covariance(
        state, normal_equations(state, seen, freedoms), freedoms, np.asarray(seen.used.any(0))
    )
    s = np.sqrt(cost(state, seen, freedoms) / max(degrees_of_freedom(state, freedoms, seen.used) + gauge, 1))
    kind, m, rows, precision = [], [], [], []
    for c, (freedom, camera) in enumerate(zip(freedoms, state.cameras, strict=True)):
        if not freedom.prior:
            continue
        known = freedom.prior.precision > 0
        D = np.zeros((int(known.sum()), len(covariance)))
        D[:, 15 * c : 15 * c + 15] = directions_of(camera)[known]
        rows.append(D)
        kind.append(KINDS[known])
        m.append((values_of(camera) - freedom.prior.usual)[known] / s)
        precision.append(freedom.prior.precision[known])
    D = np.concatenate(rows)
    return np.concatenate(kind), np.concatenate(m), D @ covariance @ D.T, np.concatenate(precision)
