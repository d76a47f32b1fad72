"""Names that a marker of no name passed on: each to the marker beside it, up to one whose own label seems absent.

A marker that the template does not know, worn near a label's place, can take that label's name; the marker robbed
takes the next one's, and so on, to a label that no marker has. By another subject's template each lies fairly where it
should, and that one marker more has a name outweighs that all lie worse. So the chain of labels a₀ … a_n is
undone: the marker of a₀ has no name, and that of each a_i the name a_{i−1}. That is compared with what the names
are without any of the chain's, and with how they are, which is one name more, worth what names are worth in the median,
s, less what an absent and an extra marker cost, c, the more so where the trial has none otherwise. Undone, it gains

    min( S(undone) − max over k of S(as it is, without a_k),  S(undone) − S(as it is) + s − c )                    (1)

nats, with S the sum of `arrange` (1). Which chains are likely follows from what markers are worth by the names as they
are: a step from a to b gains

    g(a, b) = w(marker of b, a) − w(marker of a, a).                                                              (2)
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from .arrange import TEMPER, Markers, markers_of, moved_places, nats_of, own_places, sum_of
from .evidence import PairScore
from .shape import Shapes
from .stretches import FREE, Stretches
from .template import Template

FRAMES = 10
"""In which chains are scored; chosen, as in `rivals`."""
STEPS = 5
"""Of a chain, at most; chosen, as `chains.LONGEST` has it: the spine of the largest set has so many markers."""
EACH = 2
"""Chains that are tried from a label, by their first step; chosen."""
LIKELY = 0.0
"""Nats by (2) below which a chain is not tried; by definition: it would lose by (1) as well."""
ODD, FIRST = 8.0, 4.0
"""c of (1), nats, and what is added to it where the trial has no absent label otherwise, and where it has no marker
without name; chosen of 4, 6, 8 and 10, and of 0 to 6, by the log score of 1 962 labels of 33 shreds by other subjects'
templates, 28 of them with as many markers absent as there are extra ones, and four rows of benchmarks/labelling.py."""
CLEARLY = 8.0
"""Nats (1) that a chain must gain to be undone; chosen: of two clean trials of other subjects' one gained 2, and chains
that a marker within a third of the way passed on gain 13 to 59."""


def passed_back(stretches: Stretches, label: Ints, template: Template, pairs: PairScore) -> Ints:
    """(T) labels, with the chain undone by which clearly most is gained, one after the other while there is one.

    As they are where names were stated, which no chain may change.
    """
    shapes = Shapes.of(template)
    if not shapes.known.any() or not (label >= 0).any() or (stretches.fixed != FREE).any():
        return label
    markers = markers_of(stretches, label, len(template))
    now = markers.label
    for _ in range(STEPS):
        other, gain = undone(markers, now, shapes, pairs)
        if gain < CLEARLY:
            break
        now = other
    return np.where(markers.of >= 0, now[markers.of], label)


def undone(markers: Markers, now: Ints, shapes: Shapes, pairs: PairScore) -> tuple[Ints, float]:
    """(M) labels with the chain undone by which most is gained, and the nats (1) of it; −∞ where no chain is likely."""
    markers = markers._replace(xyz=markers.xyz[:: max(1, len(markers.xyz) // FRAMES)])
    L, placed = len(shapes.sigma), own_places(markers, now, shapes)
    holder = np.full(L, -1)
    holder[now[now >= 0]] = np.flatnonzero(now >= 0)

    def score(other: Ints) -> float:
        return sum_of(markers, other, shapes, pairs, moved_places(markers, now, other, shapes, placed))

    chains = set[tuple[int, ...]]()
    for share in (0.0, TEMPER):
        chains |= likely_chains(_gains(nats_of(markers, now, shapes, pairs, share), holder))
    if not chains:
        return now, -np.inf
    without = {int(a): score(np.where(now == a, -1, now)) for a in now[now >= 0]}
    odd = ODD + FIRST * (int((holder >= 0).all()) + int((now >= 0).all()))
    one_more = float(np.median(list(without.values()))) + odd
    best, gain = now, -np.inf
    for chain in chains:
        other = now.copy()
        other[holder[chain[0]]] = -1
        other[holder[list(chain[1:])]] = chain[:-1]
        more = score(other) - max(one_more, *(without[k] for k in chain))
        best, gain = (other, more) if more > gain else (best, gain)
    return best, gain


def _gains(worth: Floats, holder: Ints) -> Floats:
    """(L, L) of (2), −∞ where a label has no marker; worth (M, L), holder (L) −1 for none."""
    there: Bools = holder >= 0
    passed = worth[holder].T  # of a by the marker of b
    both = there[:, None] & there & ~np.eye(len(holder), dtype=bool)
    return np.where(both, passed - np.diag(passed)[:, None], -np.inf)


def likely_chains(gain: Floats) -> set[tuple[int, ...]]:
    """Labels a₀ … a_n of chains, from each label the best by each of a few first steps, and these steps alone.

    Args:
        gain: (L, L) of (2), of a step from the row's label to the column's.
    """
    after, onwards = [], np.zeros(len(gain))
    for _ in range(STEPS - 1):
        best = gain + onwards
        after.append(np.where(best.max(1) > 0, best.argmax(1), -1))
        onwards = np.maximum(best.max(1), 0.0)
    out = set[tuple[int, ...]]()
    for a, first in enumerate(gain + onwards):
        for b in np.argsort(-first, kind="stable")[:EACH].tolist():
            if first[b] > LIKELY:
                out |= {(a, b), _followed((a, b), after)}
    return out


def _followed(chain: tuple[int, ...], after: list[Ints]) -> tuple[int, ...]:
    """A chain, and its best next steps, to where none gains or a label comes again."""
    for step in after[::-1]:
        b = int(step[chain[-1]])
        if b < 0 or b in chain:
            break
        chain = (*chain, b)
    return chain
