"""Limbs that have each other's names as wholes: a left leg that is called right, and a right one that is called left.

A limb whose sides are exchanged keeps all distances within itself, so that no exchange of two markers shows it, nor
does that of the whole body. Which markers make a limb follows from the pairs of left and right names: single linkage
by their distance in the template gives groups from single pairs to the whole body. Each group is exchanged as one and
judged by all pairs that this touches, as any exchange ((1) of `exchange`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from ..data.array_types import Ints
from ..data.marker_sides import sides_by_name
from .anatomy import PROOF, Anatomy
from .evidence import PairScore, Single, hands
from .exchange import Exchanger, Move
from .stretches import Stretches
from .sweeps import places, total_score
from .template import Template

NEARLY = 50.0
"""Loss of an exchange of limbs, nats a frame, up to which it is settled and scored; chosen: two legs that had each
other's names lost 16 by it, right legs 30 by static templates and 136 and more by others."""
MOST = 2
"""Exchanges that are settled, at most, those that lose least; chosen."""
LIMB = 3
"""Pairs of a limb, at least; chosen: exchanges of two pairs are among those of `exchange`."""
FRAMES = 10
"""In which limbs are looked at; chosen: they hardly change in a trial."""


def limbs(template: Template, pairs: Sequence[tuple[str, str]]) -> list[list[tuple[str, str]]]:
    """Groups of two pairs or more that may be exchanged together, from limbs to the whole body."""
    left, right = (np.array([template.names.index(pair[k]) for pair in pairs], int) for k in (0, 1))
    if len(pairs) < 2:
        return []
    D = np.where(np.isfinite(template.distance), template.distance, template.size)
    near = np.minimum(D[np.ix_(left, left)], D[np.ix_(right, right)])
    near = (near + near.T) / 2
    np.fill_diagonal(near, 0.0)
    tree = scipy.cluster.hierarchy.linkage(scipy.spatial.distance.squareform(near, checks=False), "single")
    groups = [[k] for k in range(len(pairs))]
    for a, b, *_ in tree.tolist():
        groups.append(groups[int(a)] + groups[int(b)])
    return [[pairs[k] for k in sorted(group)] for group in groups[len(pairs) :]]


def exchange_of(template: Template, group: Sequence[tuple[str, str]]) -> Move:
    """Left and right of all pairs of a group exchanged."""
    left, right = (tuple(template.names.index(pair[k]) for pair in group) for k in (0, 1))
    return (*left, *right), (*right, *left)


def near_turns(y: Single, template: Template, pairs: PairScore, stated: Ints) -> list[Ints]:
    """(L) what labels become where a limb has the other side's names: of limbs by which that loses little.

    Args:
        y: (K, L, 3) places of labels, mm, NaN where not seen. stated: labels that keep their names; −1 and less for
            none.
    """
    known = {template.names[a] for a in stated[stated >= 0].tolist()}
    sides = [pair for pair in sides_by_name(template.names) if known.isdisjoint(pair)]
    groups = [group for group in limbs(template, sides) if LIMB <= len(group) < len(sides)]
    if not groups:
        return []
    y = _some(y)
    moves = [exchange_of(template, group) for group in groups]
    turns = np.repeat(np.arange(len(template))[None], len(moves), axis=0)
    for turn, (was, to) in zip(turns, moves, strict=True):
        turn[list(was)] = to
    anatomy = Anatomy.of(template.names)
    gains = Exchanger.of(template, pairs).gains(y, moves) + [anatomy.gain(y, turn) for turn in turns]
    there = [np.isfinite(y[:, list(was)]).any() for was, _ in moves]
    best = [k for k in np.argsort(-gains, kind="stable").tolist() if gains[k] > -NEARLY and there[k]]
    return [turns[k] for k in best[:MOST]]


def score_with_sides(stretches: Stretches, label: Ints, template: Template, pairs: PairScore) -> float:
    """Nats a frame of all pairs, of quadruples and of what any body shows of its sides (`anatomy`)."""
    score, _ = total_score(stretches, label, pairs)
    y = _some(places(stretches, label, len(template)))
    score += PROOF * Anatomy.of(template.names).agreement(y)
    if pairs.hands is None:  # otherwise the score has them
        score += sum(float(hands(xyz, template.handed, template.sign).sum()) for xyz in y) / max(len(y), 1)
    return score


def _some(y: Single) -> Single:
    """Of K frames those that are looked at."""
    return y[np.unique(np.linspace(0, len(y) - 1, min(len(y), FRAMES)).round().astype(int))]
