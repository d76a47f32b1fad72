"""What one other marker alone says against an exchange of two names.

The markers of a plate look alike. Where a template shows one posture and knows no segment, two of them are told apart
by their distances to the rest of the body alone, and all of these change together when the part that bears the plate
turns: of a hand that turned over thirty markers elsewhere say, all alike, that two of its glove have each other's
names. So what they say is no sum. Of labels a and b, with l of `evidence` (1),

    z = max over c of  ‹ l(y_a y_c; D_ac) + l(y_b y_c; D_bc) − l(y_a y_c; D_bc) − l(y_b y_c; D_ac) ›              (1)

is what the one that tells most says, and an exchange loses at most `TIMES` that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data.array_types import Bools, Floats
from ..numerics.vectors import lengths
from .evidence import PairScore, Single

TIMES = 5.0
"""Times (1) that an exchange loses at most; chosen on static trials without segments of five children, a racer in a
wheelchair and two more: of exchanged markers of gloves (1) is 0.02 to 0.17 where all others together say 3 to 11 nats,
and 3 made right names with 0.6 and more unsure; below 0.2 are the two markers of a wrist, which a forearm exchanges."""


def told_by_one(y: Single, pairs: PairScore, twos: Sequence[tuple[int, int]]) -> Floats:
    """(M) nats (1), mean over the frames in which either of two is seen; not below 0.

    Args:
        y: (K, L, 3) places of labels, mm, NaN where not seen. twos: M labels a and b.
    """
    d, out = lengths(y[:, :, None] - y[:, None]), np.zeros(len(twos))
    every = np.arange(y.shape[1])
    for k, (a, b) in enumerate(twos):
        lost = pairs.at(d[:, a], a, every) + pairs.at(d[:, b], b, every)
        lost -= pairs.at(d[:, a], b, every) + pairs.at(d[:, b], a, every)
        lost[:, [a, b]] = 0.0
        seen = np.isfinite(y[:, [a, b], 0]).any(1).sum()
        out[k] = lost.sum(0).max(initial=0.0) / max(int(seen), 1)
    return out


def in_one_posture(twos: Sequence[tuple[int, int]], keeps: Bools) -> Bools:
    """(M) whether neither of two labels has a distance that is known to keep.

    Args:
        twos: M labels a and b. keeps: (L, L) of the template.
    """
    loose = np.asarray(~keeps.any(1))
    return np.asarray(loose[np.array(twos, np.int64).reshape(-1, 2)].all(1))
