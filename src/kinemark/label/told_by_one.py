"""What one other marker alone says against an exchange of two names.

The markers of a plate look alike. Where no marker that is seen tells two of them apart by distances D that are known
to keep, |D_ac − D_bc| > `CLEARLY` √(σ_ac² + σ_bc²) (2), the rest of the body alone does, and all of its distances
change together when the part that bears the plate turns: of a hand that turned over thirty markers elsewhere say, all
alike, that two of its glove have each other's
names. So what they say is no sum. Of labels a and b, with l of `evidence` (1),

    z = max over c of  ‹ l(y_a y_c; D_ac) + l(y_b y_c; D_bc) − l(y_a y_c; D_bc) − l(y_b y_c; D_ac) ›              (1)

is what the one that tells most says, and an exchange loses at most `TIMES` that. The markers of a wrist may have each
other's names as those of its hand have, and then say that these are right: so a name is at most as sure as the
surest of those that say `SAYS_MUCH`, or most where none does.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from ..numerics.evenly import evenly_rounded
from ..numerics.vectors import lengths
from .evidence import PairScore, Single
from .exchange import FRAMES, Exchanger
from .stretches import Stretches
from .sweeps import places
from .template import Template

TIMES = 5.0
"""Times (1) that an exchange loses at most; chosen on static trials without segments of five children, a racer in a
wheelchair and two more: of exchanged markers of gloves (1) is 0.02 to 0.17 where all others together say 3 to 11 nats,
and 3 made right names with 0.6 and more unsure; below 0.2 are the two markers of a wrist, which a forearm exchanges."""
SAYS_MUCH = 0.3
"""Nats from which on a marker is one of those that tell two apart; chosen above what is said of exchanged ones."""

CLEARLY = 1.5
"""Of (2); chosen: of two of a glove a forearm that moved said 0.8, and the wrist's marker 7.5."""


def told_by_one(y: Single, pairs: PairScore, twos: Sequence[tuple[int, int]]) -> Floats:
    """(M) nats (1), mean over the frames in which either of two is seen; not below 0.

    Args:
        y: (K, L, 3) places of labels, mm, NaN where not seen. twos: M labels a and b.
    """
    return said_by_each(y, pairs, twos).max(1, initial=0.0)


def said_by_each(y: Single, pairs: PairScore, twos: Sequence[tuple[int, int]]) -> Floats:
    """(M, L) nats that each marker c says in (1), mean over the frames in which either of two is seen."""
    d, out = lengths(y[:, :, None] - y[:, None]), np.zeros((len(twos), y.shape[1]))
    every = np.arange(y.shape[1])
    for k, (a, b) in enumerate(twos):
        lost = pairs.at(d[:, a], a, every) + pairs.at(d[:, b], b, every)
        lost -= pairs.at(d[:, a], b, every) + pairs.at(d[:, b], a, every)
        lost[:, [a, b]] = 0.0
        seen = np.isfinite(y[:, [a, b], 0]).any(1).sum()
        out[k] = lost.sum(0) / max(int(seen), 1)
    return out


def at_most_tellers(p: Floats, stretches: Stretches, label: Ints, template: Template, pairs: PairScore) -> Floats:
    """(T) probabilities of names, those that others tell by (1) at most as sure as the surest of these.

    Args:
        p: (T) before. label: (T) −1 for none.
    """
    twos = [(was[0], was[1]) for was, _ in Exchanger.of(template, pairs).keeping(stretches.fixed).twos]
    there = np.isin(np.arange(len(template)), label)
    own = [twos[k] for k in np.flatnonzero(told_by_none(twos, template, there)).tolist()]
    if not own or not there.any():
        return p
    of_label, most = np.zeros(len(template)), np.ones(len(template))
    np.maximum.at(of_label, label[label >= 0], p[label >= 0])
    y = places(stretches, label, len(template))
    y = y[evenly_rounded(len(y), FRAMES)]
    for two, nats in zip(own, said_by_each(y, pairs, own), strict=True):
        if nats.max() > 0:
            surest = of_label[nats >= min(SAYS_MUCH, nats.max())].max()
            most[list(two)] = np.minimum(most[list(two)], surest)
    return np.where(label >= 0, np.minimum(p, most[np.maximum(label, 0)]), p)


def told_by_none(twos: Sequence[tuple[int, int]], template: Template, there: Bools) -> Bools:
    """(M) whether no distance that is known to keep tells two labels apart (2).

    Args:
        twos: M labels a and b. there: (L) markers that are seen.
    """
    a, b = np.array(twos, np.int64).reshape(-1, 2).T
    D, spread, keeps = template.distance, template.spread, template.keeps
    with np.errstate(invalid="ignore", divide="ignore"):
        clear = np.abs(D[a] - D[b]) > CLEARLY * np.hypot(spread[a], spread[b])
    tells = clear & (keeps[a] | keeps[b]) & there
    tells[np.arange(len(a)), a] = tells[np.arange(len(b)), b] = False  # they keep their own distance either way
    return np.asarray(~tells.any(1))
