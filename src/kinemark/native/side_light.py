"""Markers that are brighter on one side: one linear step from shapes that are equally bright all over.

With U the light of `shape_images` (1), found by `shape_fits` with ground g and brightness A, such a marker has

    I(x, y) = g + A (1 + a (x − x̄) + b (y − ȳ)) U(x, y)                   (1)

with (x̄, ȳ) the mean of the pixels that count (2). a and b begin at 0, and one step of Gauss and Newton changes them
together with all other parameters. Where that leaves more than before, nothing is changed.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats
from .array_checks import FLOAT, Arrays
from .compiled_library import library
from .shape_fits import FIXED, chi2_of, is_shape, kind_of, step_of
from .shape_images import Patches, Shape, image

_SHAPES = Arrays(
    parameters=(FLOAT, "n", "P"),
    x=(FLOAT, "n", "N"),
    y=(FLOAT, "n", "N"),
    grey=(FLOAT, "n", "N"),
    weight=(FLOAT, "n", "N"),
    white=(FLOAT, "n"),
)


def light_sides(
    parameters: Floats, x: Floats, y: Floats, grey: Floats, weight: Floats, white: Floats, *, shape: Shape
) -> tuple[Floats, Floats]:
    """What n fitted shapes leave of their patches of N pixels where they may be lit from a side.

    Args:
        parameters: (n, p + 3) those of the shape, w, A and g, as `fit_shapes` found them.
        x: (n, N) px.
        y: (n, N) px.
        grey: (n, N) grey levels.
        weight: (n, N) 1 / variance of each; what is negative counts as 0.
        white: (n) grey level at which the sensor is saturated; inf where it is not.
        shape: one of `shape_images`.

    Returns:
        (n) χ², and (n, N) the grey levels of the model.

    Raises:
        ValueError: an array has another shape or dtype, or the shape has another number of parameters.
    """
    parameters, *columns = _SHAPES(parameters, x, y, grey, weight, white)
    n, P = parameters.shape
    if not is_shape(shape, P):
        raise ValueError(f"parameters are {P} a patch, which are not those of {shape.__name__}")
    if compiled := library():
        N = columns[0].shape[1]
        chi2, model, work = np.empty(n), np.empty((n, N)), np.empty((4, N))
        if compiled.light_sides(kind_of(shape), n, N, P, *FIXED, *columns, parameters, chi2, model, work):
            return chi2, model
    return _numpy_sides(shape, parameters, Patches(*columns))


@np.errstate(all="ignore")
def _numpy_sides(shape: Shape, parameters: Floats, patches: Patches) -> tuple[Floats, Floats]:
    patches = patches._replace(weight=np.maximum(patches.weight, 0.0))
    model, J = image(shape, parameters, patches)
    bright = model - parameters[:, -1, None]
    used = patches.weight > 0
    number = np.maximum(used.sum(1, keepdims=True), 1)
    rising = [bright * (at - (used * at).sum(1, keepdims=True) / number) for at in (patches.x, patches.y)]  # (2)
    J = np.concatenate([J, np.stack(rising, 1)], 1)
    change = np.einsum("np,npk->nk", step_of(J, model, patches, np.zeros(len(J)))[0], J)
    better = chi2_of(model + change, patches) < chi2_of(model, patches)
    model = model + np.where(better[:, None], change, 0.0)
    return chi2_of(model, patches), model
