"""Whether left and right of a trial differ as the template's do, or the other way round, as in a mirrored world.

No body is quite its own mirror image, and no two wands sit alike. Let a', b' be the partners of labels a, b, and of all
a, b whose distances keep, on both sides,

    x = d_ab − d_a'b' in the trial,   m = D_ab − D_a'b' in the template

Names that are right have x = m, names that all are of the other side x = −m, up to scatter. So with w the inverse of
the variance that the template leaves both distances,

    r = Σ w (x − m)² / Σ w (x + m)²                                                                              (1)

is far above 1 for the latter, however small the asymmetry is; about 1 where the template has none, or where markers
were put on anew and x hangs on m no more.
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from ..numerics.vectors import lengths
from .evidence import OF_SIZE, Single
from .template import Template

TURNED = 8.0
"""r from which the names are those of the other side; chosen: in a right world it is 0.34 at most in 69 templates and
trials of one subject, 15 to 62 markers, 3.5 where markers were moved by 5 to 15 mm, 240 trials, and 5.8 where another
child's markers are taken for the subject's, 60 pairs."""
ONE_PAIR = 1.0
"""r that is left when any one marker and its partner are left out, at least; chosen: one wand that was put on anew
tells nothing."""
QUARTER = 2.0
"""r of each quarter of the frames, at least; chosen: distances that hang on the posture differ between left and right
too, so half a stride by a template of the other half, which is its mirror image, has r = 8.1 in all and 0.6 and 1.0 in
two quarters; mirrored walks of five children have 3.5 to 190."""


class _Differences(NamedTuple):
    """Of n pairs of distances: (n, 4) labels a, b, a', b'; x, m, w, (n) each."""

    labels: Ints
    x: Floats
    m: Floats
    w: Floats

    def ratio(self, some: Bools) -> float:
        """(1) of some."""
        straight, turned = (float((self.w * off**2)[some].sum()) for off in (self.x - self.m, self.x + self.m))
        return straight / turned if turned > 0 else 1.0

    def whole(self) -> float:
        """(1) of all."""
        return self.ratio(np.ones(len(self.x), bool))


def sides_are_turned(y: Single, template: Template, other: Ints) -> bool:
    """Whether what differs between left and right does so the other way round.

    Args:
        y: (K, L, 3) places of labels in some frames, mm, NaN where not seen. other: (L) partners of labels, themselves
            where they have none.
    """
    found = _differences(y, template, other)
    if found.whole() < TURNED:
        return False
    pairs = [(a, b) for a, b in enumerate(other.tolist()) if a < b]
    without = (np.asarray(~np.isin(found.labels, pair).any(1)) for pair in pairs)
    quarters = (_differences(some, template, other) for some in np.array_split(y, 4) if len(some))
    return all(found.ratio(some) > ONE_PAIR for some in without) and all(one.whole() > QUARTER for one in quarters)


def _differences(y: Single, template: Template, other: Ints) -> _Differences:
    D, L = template.distance, len(template)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of labels that are never seen together
        d = np.nanmean(lengths(y[:, :, None] - y[:, None]), axis=0)
    a, b = np.triu_indices(L, 1)
    A, B = np.minimum(other[a], other[b]), np.maximum(other[a], other[b])
    known = template.keeps & np.isfinite(d)
    once = known[a, b] & known[A, B] & (a * L + b < A * L + B)
    a, b, A, B = a[once], b[once], A[once], B[once]
    variance = template.spread[a, b] ** 2 + template.spread[A, B] ** 2 + (OF_SIZE * template.size) ** 2
    return _Differences(np.stack([a, b, A, B], axis=1), d[a, b] - d[A, B], D[a, b] - D[A, B], 1 / variance)
