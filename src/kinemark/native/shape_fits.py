"""Shapes fitted to the grey levels of small patches, by Levenberg and Marquardt's steps, each patch by itself.

The shape, w, A and b of `shape_images` (1) are found together (`numerics.levenberg_marquardt` (2), (3) and (5), the
damping with fixed factors) on Σ (grey − I)² weighted by 1 / variance of the pixel. w is held within `WIDTHS` and A
above 1. A fit has converged when a step is small, or brings little, or explains enough.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Floats
from ..numerics.levenberg_marquardt import MAX_DAMPING, Damping, Iterates, minimise_many
from .array_checks import FLOAT, Arrays
from .compiled_library import library
from .shape_images import (
    NODE_WEIGHTS,
    NODES,
    NODES_CORNER,
    WEIGHTS_CORNER,
    Patches,
    Shape,
    cut,
    discs,
    ellipse,
    image,
    motion,
)

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
WIDTHS = (0.25, 3.0)  # px; of the blur w; chosen (see studies/overlapping_markers.py)

_FITS = Arrays(
    start=(FLOAT, "n", "P"),
    x=(FLOAT, "n", "N"),
    y=(FLOAT, "n", "N"),
    grey=(FLOAT, "n", "N"),
    weight=(FLOAT, "n", "N"),
    white=(FLOAT, "n"),
    wanted=(FLOAT, "n"),
    enough=(FLOAT, "n"),
)
_SHAPES: tuple[Shape, ...] = (discs, ellipse, motion, cut)  # in the order of the kinds in shapes.c
MOST = 24  # parameters, as in shapes.c; by definition
_RULES = [DAMPING.value, *(DAMPING.fixed or ()), MAX_DAMPING, SMALL_STEP, SMALL_GAIN, HOPELESS, *WIDTHS]
FIXED = np.array(_RULES, np.float64), np.stack([NODES, NODE_WEIGHTS]), np.stack([NODES_CORNER, WEIGHTS_CORNER])
"""What compiled functions of shapes are told in every call, in the order of `Fit` in shapes.c; by definition."""


class ShapeFits(NamedTuple):
    """What fits best: p parameters of the shape, then w, A and b.

    Attributes:
        parameters: (n, p + 3).
        chi2: (n) weighted sum of squares.
        model: (n, N) grey levels.
        normal: (n, p + 3, p + 3) the normal matrix, of which the inverse is the covariance.
    """

    parameters: Floats
    chi2: Floats
    model: Floats
    normal: Floats


def fit_shapes(
    start: Floats,
    x: Floats,
    y: Floats,
    grey: Floats,
    weight: Floats,
    white: Floats,
    wanted: Floats,
    enough: Floats,
    *,
    shape: Shape,
) -> ShapeFits:
    """The shape's parameters that explain each of n patches of N pixels best.

    Args:
        start: (n, p + 3) where the parameters, w, A and b begin.
        x: (n, N) px, such that discs are round.
        y: (n, N) px.
        grey: (n, N) grey levels.
        weight: (n, N) 1 / variance of each; what is negative counts as 0.
        white: (n) grey level at which the sensor is saturated; inf where it is not.
        wanted: (n) χ² above which a fit that hardly gets better is given up.
        enough: (n) χ² below which a fit is good enough.
        shape: one of `shape_images`.

    Raises:
        ValueError: an array has another shape or dtype, or the shape has another number of parameters.
    """
    arrays = start, *columns, wanted, enough = _FITS(start, x, y, grey, weight, white, wanted, enough)
    n, P = start.shape
    if not is_shape(shape, P):
        raise ValueError(f"start has {P} parameters a patch, wanted 3 k + 3 of k discs, not above {MOST}, or else 8")
    if compiled := library():
        N = columns[0].shape[1]
        p, chi2, model, normal = start.copy(), np.empty(n), np.empty((n, N)), np.empty((n, P, P))
        work = np.empty((4, N))
        if compiled.fit_shapes(kind_of(shape), n, N, P, STEPS, *FIXED, *arrays[1:], p, chi2, model, normal, work):
            return ShapeFits(p, chi2, model, normal)
    return _numpy_fits(shape, start, Patches(*columns), wanted, enough)


def is_shape(shape: Shape, P: int) -> bool:
    """Whether the shape may have P parameters with w, A and b."""
    return P <= MOST and (P >= 6 and P % 3 == 0 if shape is discs else P == 8)


def kind_of(shape: Shape) -> int:
    """Its number in shapes.c."""
    return _SHAPES.index(shape)


@np.errstate(all="ignore")
def _numpy_fits(shape: Shape, start: Floats, patches: Patches, wanted: Floats, enough: Floats) -> ShapeFits:
    patches = patches._replace(weight=np.maximum(patches.weight, 0.0))
    used = np.maximum((patches.weight > 0).sum(1), 1)
    problems = _Shapes(shape, patches, wanted, enough, used)
    found = minimise_many(problems, problems.at(start.copy(), patches), steps=STEPS, damping=DAMPING)
    model, J = found.equations
    return ShapeFits(found.parameters, found.cost, model, _normal(J, patches))


@dataclass(frozen=True, slots=True)
class _Shapes:
    """The problems for `minimise_many`; `used` (n) pixels have weight."""

    shape: Shape
    patches: Patches
    wanted: Floats
    enough: Floats
    used: NDArray[np.int64]

    def at(self, p: Floats, patches: Patches) -> Iterates:
        """Parameters with the patches' models and derivatives."""
        model, J = image(self.shape, p, patches)
        return Iterates(p, chi2_of(model, patches), (model, J))

    def step(self, which: NDArray[np.int64], now: Iterates, damping: Floats) -> tuple[Iterates, Floats]:
        """After the step, w within its bounds and A above 1."""
        part = self.patches if len(which) == len(self.patches.x) else self.patches.take(which)
        model, J = now.equations
        step, predicted = step_of(J, model, part, damping)
        return self.at(_held(now.parameters + step), part), predicted

    def converged(self, which: NDArray[np.int64], now: Iterates, tried: Iterates) -> NDArray[np.bool_]:
        """Whether the step was small, or brought little, or the fit is good enough."""
        chi2, wanted = tried.cost, self.wanted[which]
        small = np.where(chi2 > wanted, HOPELESS * chi2, SMALL_GAIN * np.maximum(1.0, chi2 / self.used[which]))
        moved = np.abs(tried.parameters - now.parameters)[:, :-2].max(1)
        return np.asarray((moved < SMALL_STEP) | (now.cost - chi2 < small) | (chi2 < self.enough[which]))


def chi2_of(model: Floats, patches: Patches) -> Floats:
    """(n) the weighted sum of squares that a model (n, N) leaves."""
    off = patches.grey - model
    return np.asarray((patches.weight * off * off).sum(1))


def _normal(J: Floats, patches: Patches) -> Floats:
    return np.asarray((J * patches.weight[:, None]) @ J.transpose(0, 2, 1))


def scaled(H: Floats) -> tuple[Floats, Floats]:
    """H (n, P, P) with ones along its diagonal, and the roots (n, P) of what it was."""
    d = np.sqrt(np.maximum(np.einsum("nii->ni", H), 1e-12))
    return H / (d[:, :, None] * d[:, None]), d


def step_of(J: Floats, model: Floats, patches: Patches, damping: Floats) -> tuple[Floats, Floats]:
    """Levenberg–Marquardt's step (n, P), and by how much (n) it predicts to lower χ²."""
    H, d = scaled(_normal(J, patches))
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
