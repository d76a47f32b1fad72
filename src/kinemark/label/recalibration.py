"""Probabilities that say how often names are right: a monotone map of p_label, `margin` (4).

Below 0.9 names were right more often than they said, and from 0.97 to 0.99 less often. With η the logit of a
probability, the map goes straight from knot to knot,

    η' = linear in η between the logits of OWN, or OTHER; below the first knot η' − η as there                    (1)

and from 0.99 on it changes nothing, as names were right there to 0.001: which names are sure stays.

That is of trials with the whole body, or nearly. Of a part of it alone, a limb can have the names of one that is
absent: all distances within it hold, no exchange of two labels shows it, and where most names are so, each fits as the
others do. On the other hand a label whose stiffest neighbours are all absent lacks what usually tells most, without
anything against it. So with A absent labels

    η'' = η' + log(1 + A) γ · (1, log(1 + e_a), k_a, min(m − 1, 0))                                               (2)

with e_a of `margin` (4), k_a 1 where none of the label's stiffest distances is seen, else 0, and m the median fit of
all labels that are there. Of another subject's template this was not measured, and is not done.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats
from .margin import MOST_NATS, Margins

OWN = ((0.02, 0.122), (0.2, 0.563), (0.5, 0.702), (0.97, 0.959), (0.985, 0.959), (0.99, 0.99))
"""Knots: probabilities, and what they become by the subject's own template, also a static one; measured on 325 random
shreds (benchmarks/labelling_shreds.py static:82000-82045 static:84000-84044 static:85000-85044 crowded:80000-80090
crowded:83000-83060 crowded:84000-84044). Where the knots are was chosen: of six ways by which each subject, left out,
was told as well, that by which all bins were true to 0.02."""
OTHER = ((0.05, 0.315), (0.5, 0.597), (0.9, 0.904), (0.975, 0.960), (0.99, 0.99))
"""The same by another subject's template; measured on 120 shreds (other:82000-82045 other:84000-84037
other:85000-85036)."""
OF_PARTS = (-1.73, 0.47, 1.97, 1.98)
"""γ of (2); logits; measured on 2 670 labels of 90 random shreds, 60 of them of parts (benchmarks/labelling_shreds.py
parts:210000-210060 crowded:210000-210010 static:210000-210012 own:210000-210008), and 741 of legs and upper bodies
alone (benchmarks/labelling_parts.py); of nine sets of features the one that told labels best with each subject left
out."""
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


def by_what_is_absent(probability: Floats, found: Margins) -> Floats:
    """(T) by (2), as it is where nothing is absent; by the subject's own template.

    Args:
        probability: (T) of labels, recalibrated; NaN for tracks without one. found: of these tracks.
    """
    told, median = np.log1p(np.clip(found.told, 0.0, MOST_NATS)), found.label_fit - found.fit_beside
    parts = np.stack([np.ones(len(told)), told, found.proofs == 0, np.minimum(median - 1.0, 0.0)], axis=1)
    eta = _logit(probability) + np.log1p(found.absent) * (parts @ np.array(OF_PARTS))
    return np.where(found.absent > 0, 1 / (1 + np.exp(-eta)), probability)


def _logit(p: Floats) -> Floats:
    p = np.clip(p, LEAST, MOST)
    return np.asarray(np.log(p / (1 - p)))
