"""A bundle adjustment that wrong points do not spoil.

The points' covariances need only be right in proportion: the standard deviation in their units is

    s² = median(d²) / (2 ln 2) · m / ν                                   (1)

with d the length of a normalised residual, m equations and ν = m less the unknowns: half of all d² are below 2 ln 2
where no point is wrong. With it

1. Cauchy's weights (c = `SOFT` s) hold wrong points at bay; s falls as the fit improves, until it settles.
2. Points beyond `reject` s are left out, and the rest is fitted by plain least squares. Points that are near again
   return. This is repeated until nothing changes.

What is usual of lenses (`lens_prior`) is weighed by s.
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Bools, Floats
from ...numerics.robust import plane_scale
from .parts import Part, slices, supported
from .solver import BundleState, Freedom, ImageObservations, normalised_residuals, solve

SOFT = 2.5  # c in standard deviations; near Cauchy's usual 2.385 (Holland & Welsch 1977)
ROUNDS = 8  # at most, of reweighting and of leaving out; chosen: two or three do (see benchmarks/bundle.py)
SETTLED = 0.95  # share of s that a round must leave to be the last; chosen (see benchmarks/bundle.py)
ROUGH = 1e-4
"""Share of the cost by which a soft solution may still fall; chosen: it is only a start (see benchmarks/bundle.py)."""
TINY = 1e-6
"""px or standard deviations; least scale, of perfect images; chosen: with 1e-9 what is usual of lenses is lost to
rounding beside what such images tell, and `usual_terms` finds no positive definite matrix."""


def unknowns(state: BundleState, freedoms: tuple[Freedom, ...], used: Bools) -> int:
    """How many parameters of cameras and used bodies there are."""
    cameras = sum(f.unknowns(c) for f, c in zip(freedoms, state.cameras, strict=True))
    return cameras + sum(int(seen.sum()) * part.degrees for part, seen in _used_bodies(state.parts, used))


def equations(state: BundleState, used: Bools) -> int:
    """How many there are: two an image point, and three a point that was surveyed."""
    surveyed = sum(3 * int(seen.sum()) for part, seen in _used_bodies(state.parts, used) if part.known and part.degrees)
    return 2 * int(used.sum()) + surveyed


def degrees_of_freedom(state: BundleState, freedoms: tuple[Freedom, ...], used: Bools) -> int:
    """ν, to which the world's own motions, g of `parameter_covariance`, are to be added."""
    return equations(state, used) - unknowns(state, freedoms, used)


def _used_bodies(parts: tuple[Part, ...], used: Bools) -> list[tuple[Part, Bools]]:
    """Each part, and which of its bodies are seen."""
    pairs = zip(parts, slices(parts), strict=True)
    return [(part, np.asarray(used[:, at].reshape(len(used), *part.xyz.shape[:2]).any((0, 2)))) for part, at in pairs]


def noise_scale(d: Floats, state: BundleState, freedoms: tuple[Freedom, ...], used: Bools) -> float:
    """(1) of normalised residuals d (C, N)."""
    m = equations(state, used)
    nu = max(m - unknowns(state, freedoms, used), 1)
    return max(plane_scale(d[used]) * float(np.sqrt(m / nu)), TINY)


def solve_robust(
    state: BundleState, seen: ImageObservations, freedoms: tuple[Freedom, ...], *, steps: int = 10
) -> tuple[BundleState, float]:
    """Step 1: the state, and s."""
    used = supported(state.parts, seen.used & np.isfinite(normalised_residuals(state, seen)))
    seen = seen._replace(used=used)
    scale = noise_scale(normalised_residuals(state, seen), state, freedoms, used) if used.any() else np.inf
    for _ in range(ROUNDS if used.any() else 0):
        freedoms = tuple(f.weighed(scale) for f in freedoms)
        state = solve(state, seen, freedoms, soft=SOFT * scale, steps=steps, tolerance=ROUGH)
        before, scale = scale, noise_scale(normalised_residuals(state, seen), state, freedoms, used)
        if scale > SETTLED * before:
            break
    return state, scale


def solve_without_outliers(
    state: BundleState, seen: ImageObservations, freedoms: tuple[Freedom, ...], *, reject: float, scale: float
) -> tuple[BundleState, Bools, tuple[Freedom, ...]]:
    """Step 2, from s: the state, which points (C, N) were kept, and `freedoms` weighed by s."""
    kept = _near(state, seen, supported(state.parts, seen.used), reject * scale)
    for _ in range(ROUNDS):
        freedoms, before = tuple(f.weighed(scale) for f in freedoms), scale
        state = solve(state, seen._replace(used=kept), freedoms)
        d = normalised_residuals(state, seen)
        scale = noise_scale(d, state, freedoms, kept)
        again = _near(state, seen, seen.used & (kept | (d <= reject * scale)), reject * scale)
        if (again == kept).all() and (scale > SETTLED * before or not any(f.prior for f in freedoms)):
            break
        kept = again
    return state, kept, freedoms


def _near(state: BundleState, seen: ImageObservations, used: Bools, limit: float) -> Bools:
    """`used` (C, N) without what is off by more than `limit`, the bodies placed anew from the rest."""
    still = tuple(Freedom(np.zeros(15, np.bool_)) for _ in state.cameras)
    for _ in range(ROUNDS):
        used = supported(state.parts, used & ~np.isinf(normalised_residuals(state, seen)))
        d = np.where(used, normalised_residuals(state, seen), 0.0)
        if not (d > limit).any():
            break
        used = supported(state.parts, used & (d <= limit))
        state = solve(state, seen._replace(used=used), still, steps=3)
    return used
