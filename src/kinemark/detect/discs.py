"""Shapes fitted to the grey levels of small patches, with the covariance of what is found.

The shapes and their light are those of `native.shape_images`, whose equations are (1) to (8), and the fit is that of
`native.shape_fits`; a marker brighter on one side is that of `native.side_light`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Floats
from ..native.shape_fits import fit_shapes, scaled
from ..native.shape_images import Patches, Shape
from ..native.side_light import light_sides

FLOOR = 0.02**2 * np.pi / 4
"""px² · px²; 0.02 px of error for a disc of 1 px, less for larger ones, which square pixels of a sharp image leave;
chosen (see studies/overlapping_markers.py)."""
MOST_CONDITION = 1e12  # of a normal matrix that is inverted, without unit; conventional: four digits are then left


class DiscFit(NamedTuple):
    """What fits best: p parameters of the shape, then w, A and b.

    Attributes:
        parameters: (n, p + 3).
        cov: (n, p + 3, p + 3) by the weights; NaN where the pixels do not determine them, or the fit was given up.
        chi2: (n) weighted sum of squares.
        model: (n, N) grey levels.
    """

    parameters: Floats
    cov: Floats
    chi2: Floats
    model: Floats


def fit(
    shape: Shape, start: Floats, patches: Patches, *, wanted: Floats | None = None, enough: Floats | float = 0.0
) -> DiscFit:
    """The shape's parameters that explain each patch best, from start (n, p + 3).

    A fit that is above the χ² `wanted` (n) and hardly gets better is given up; one below `enough` (n) is good enough.
    """
    wanted = np.full(len(start), np.inf) if wanted is None else wanted
    found = fit_shapes(start, *patches, wanted, np.broadcast_to(enough, len(start)), shape=shape)
    return DiscFit(found.parameters, _covariance(found.normal, found.chi2 <= wanted), found.chi2, found.model)


def _covariance(normal: Floats, some: NDArray[np.bool_]) -> Floats:
    """The inverse of the normal matrix (n, p, p), NaN where that is singular and for all but some (n)."""
    cov = np.full_like(normal, np.nan)
    some = some & np.isfinite(normal).all((1, 2))
    if not some.any():
        return cov
    H, d = scaled(normal[some])
    inverse = np.linalg.inv(H + 1e-14 * np.eye(H.shape[1]))
    known = np.linalg.norm(H, axis=(1, 2)) * np.linalg.norm(inverse, axis=(1, 2)) < MOST_CONDITION
    cov[some] = np.where(known[:, None, None], inverse / (d[:, :, None] * d[:, None]), np.nan)
    return cov


def lit_from_a_side(shape: Shape, found: DiscFit, patches: Patches) -> DiscFit:
    """The fit with brightness that also rises to a side (`native.side_light`); no covariance."""
    chi2, model = light_sides(found.parameters, *patches, shape=shape)
    return DiscFit(found.parameters, np.full_like(found.cov, np.nan), chi2, model)
