"""How many lens terms points of planes support: cross-validation.

The points of each view are cut into blocks of neighbours, `SIDE` × `SIDE` over the plane, and the blocks dealt to
`FOLDS` parts. Each part is left out in turn, the camera fitted to the rest, and the part predicted. Neighbours lie
too close together to test each other, hence blocks. With e_bm the mean square of the normalised errors in block b under
model m, the score of a model is its mean over the points,

    E_m = Σ n_b e_bm / Σ n_b                                             (1)

With the best model m*, the difference E_m − E_m* has the standard error

    s_m² = B / (B − 1) Σ n_b² (e_bm − e_bm* − (E_m − E_m*))² / (Σ n_b)²    (2)

from the B blocks, both models judged on the same ones. The simplest model is taken with

    E_m − E_m* ≤ max(s_m, γ E_m*)                                        (3)

The first bound is Breiman et al.'s (1984) "one standard error rule", with paired differences. By it alone terms that
gain a few parts in a thousand come in by chance, and they are not free: in one view that faces the camera, p1 and p2
leave the centre of the lens open by some 10 px. With the second, γ = `TOLERATED_LOSS`, an error is accepted that has a
hundredth of the variance of the noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from .plane_views import POSE, KnownOptics, PlaneFit, PlanePoints, fit_planes, normalised_residuals

SIDE = 4  # blocks across and down a view; chosen (see studies/linearisation.py)
FOLDS = 4
"""Parts of the cross-validation; chosen, so that no two blocks of a part lie side by side (see
studies/linearisation.py)."""
STEPS = 6  # tries from a start that is near; chosen (see studies/linearisation.py)
TOLERATED_LOSS = (
    0.01  # of the least error; what fewer terms may lose; chosen on the simulations of docs/theory/linearisation.md
)
BEHIND = 1e12  # standard deviations²; stands for a point behind the camera; a sentinel, by definition
RADIAL = (0, 1, 4)
"""Places of k1, k2, k3 among k1 k2 p1 p2 k3; by definition."""


class LensScore(NamedTuple):
    """A lens model and how it predicts points left out: RMS error, in standard deviations of the points as stated.

    `worse` is (1) less that of the best model, `error` its standard error (2); both squared units. Infinite where the
    points are too few for the model.
    """

    radial: int
    tangential: bool
    rms: float
    worse: float
    error: float

    @property
    def terms(self) -> int:
        """How many lens terms it has."""
        return self.radial + 2 * self.tangential


def lens_terms(radial: int, tangential: bool) -> Bools:
    """(5) which of k1, k2, p1, p2, k3 the model has."""
    terms = np.array([False, False, tangential, tangential, False])
    terms[list(RADIAL[:radial])] = True
    return terms


def score_lenses(
    models: Sequence[tuple[int, bool]], start: PlaneFit, points: PlanePoints, known: KnownOptics
) -> list[LensScore]:
    """The scores of models (radial, tangential) from a fit of a large one, in the order given."""
    block = _blocks(points)
    errors = [_block_errors(lens_terms(*model), start, points, block, known) for model in models]
    count = np.bincount(block)
    n, e = count[count > 0], np.array(errors)[:, count > 0]
    mean = (e * n).sum(1) / n.sum()  # (1)
    best = int(mean.argmin())
    with np.errstate(invalid="ignore"):
        deviation = e - e[best] - (mean - mean[best])[:, None]
        error = np.sqrt(len(n) / (len(n) - 1) * ((n * deviation) ** 2).sum(1)) / n.sum()  # (2)
    error = np.where(np.isfinite(mean), error, np.inf)
    found = zip(models, np.sqrt(mean), mean - mean[best], error, strict=True)
    return [LensScore(*model, float(rms), float(worse), float(s)) for model, rms, worse, s in found]


def simplest(scores: Sequence[LensScore]) -> LensScore:
    """(3)."""
    least = min(s.rms for s in scores) ** 2
    good = [s for s in scores if np.isfinite(s.rms) and s.worse <= max(s.error, TOLERATED_LOSS * least)]
    return min(good, key=lambda s: (s.terms, s.worse))


def _block_errors(lens: Bools, start: PlaneFit, points: PlanePoints, block: Ints, known: KnownOptics) -> Floats:
    """Mean square error in each block when it was left out."""
    total, views = np.zeros(block.max() + 1), len(start.planes.t)
    view, place = np.divmod(block, SIDE**2)
    i, j = np.divmod(place, SIDE)
    part = (i + 2 * j + view) % FOLDS  # no two blocks of a part lie side by side
    whole = fit_planes(start.planes, points, lens=lens, known=known, noise=start.noise, steps=4 * STEPS)
    for fold in range(FOLDS):
        rest, out = points.part(part != fold), part == fold
        if len(rest.uv) < 4 + lens.sum() + POSE * views or np.bincount(rest.view, minlength=views).min() < 4:
            return np.full(len(total), np.inf)
        fit = fit_planes(whole.planes, rest, lens=lens, known=known, noise=start.noise, steps=STEPS)
        d = normalised_residuals(fit.planes, points.part(out))
        total += np.bincount(block[out], np.nan_to_num(d**2, nan=BEHIND), minlength=len(total))
    return np.asarray(total / np.maximum(np.bincount(block), 1))


def _blocks(points: PlanePoints) -> Ints:
    """(N) block of each point, numbered through all views; about as many points in each of a view."""
    block = np.zeros(len(points.uv), np.int64)
    for v in np.unique(points.view):
        rows = points.view == v
        ranks = [np.argsort(np.argsort(points.xyz[rows, k], kind="stable")) for k in (0, 1)]
        across, down = (rank * SIDE // rows.sum() for rank in ranks)
        block[rows] = v * SIDE**2 + across * SIDE + down
    return block
