"""Probabilities that say how often names are right: a monotone map of those that `margin` (1) gives.

Below 0.9 names were right more often than they said, and from 0.97 to 0.99 less often. With η the logit of a
probability, the map goes straight from knot to knot,

    η' = linear in η between the logits of OWN, or OTHER; below the first knot η' − η as there                    (1)

and from 0.99 on it changes nothing, as names were right there to 0.001: which names are sure stays.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats

OWN = ((0.02, 0.122), (0.2, 0.563), (0.5, 0.702), (0.97, 0.959), (0.985, 0.959), (0.99, 0.99))
"""Knots: probabilities, and what they become by the subject's own template, also a static one; measured on 325 random
shreds (benchmarks/labelling_shreds.py static:82000-82045 static:84000-84044 static:85000-85044 crowded:80000-80090
crowded:83000-83060 crowded:84000-84044). Where the knots are was chosen: of six ways by which each subject, left out,
was told as well, that by which all bins were true to 0.02."""
OTHER = ((0.05, 0.315), (0.5, 0.597), (0.9, 0.904), (0.975, 0.960), (0.99, 0.99))
"""The same by another subject's template; measured on 120 shreds (other:82000-82045 other:84000-84037
other:85000-85036)."""
LEAST, MOST = 1e-9, 1 - 1e-12
"""Between which a probability has a logit; by definition of what a float holds."""


def recalibrated(probability: Floats, *, another: bool) -> Floats:
    """(T) by (1); 0 stays 0, and so does all from the last knot on.

    Args:
        probability: (T). another: the template is another subject's.
    """
    knots, to = _logit(np.array(OTHER if another else OWN)).T
    eta = _logit(probability)
    moved = np.where(eta < knots[0], eta + to[0] - knots[0], np.interp(eta, knots, to))
    changed = (probability > 0) & (eta < knots[-1])
    return np.where(changed, 1 / (1 + np.exp(-moved)), probability)


def _logit(p: Floats) -> Floats:
    p = np.clip(p, LEAST, MOST)
    return np.asarray(np.log(p / (1 - p)))
