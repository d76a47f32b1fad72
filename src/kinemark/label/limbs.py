"""Limbs that have each other's names as wholes: a left leg that is called right, and a right one that is called left.

A limb whose sides are exchanged keeps all distances within itself, so that no exchange of two markers shows it, nor
does that of the whole body. Which markers make a limb follows from the pairs of left and right names: single linkage
by their distance in the template gives groups from single pairs to the whole body. Each group is exchanged as one and
judged by all pairs that this touches, as any exchange ((1) of `exchange`).

Quadruples of a limb tell its side, and by another subject's template sweeps go by them as well. A search that begins
with a leg on the wrong side then settles its names to suit them: the outer side of a foot has the names of the inner
one, and to exchange the legs loses more than it gains, until what settled settles back. The distances of the limb's
markers to all others of the body hardly change by it. So by such a template one limb is also tried where these alone,
with what any body shows of its sides (`anatomy`), are no worse, or little, the other way round.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from ..data.array_types import Bools, Floats, Ints
from ..data.marker_sides import sides_by_name
from ..numerics.evenly import evenly_rounded
from ..numerics.vectors import lengths
from .anatomy import PROOF, Anatomy
from .evidence import PairScore, Single, hands
from .exchange import Exchanger, Move
from .stretches import Stretches
from .sweeps import places, total_score
from .template import Template

NEARLY = 50.0
"""Loss of an exchange of limbs, nats a frame, up to which it is settled and scored; chosen: two legs that had each
other's names lost 16 by it, right legs 30 by static templates and 136 and more by others."""
BY_THE_REST = -20.0
"""What an exchange of limbs gains by distances to the rest of the body and by `anatomy`, nats a frame, above which one
is settled and scored whatever it loses within the limbs; chosen: turned legs that had settled gained 3 to 84, right
limbs of children's walks by other children's templates lost 39 to 92."""
MOST = 2
"""Exchanges that are settled, at most, those that lose least, beside one by the rest; chosen."""
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
    """(L) what labels become where a limb has the other side's names: of limbs by which that loses little, or hardly by
    the rest of the body.

    Args:
        y: (K, L, 3) places of labels, mm, NaN where not seen. stated: labels that keep their names; −1 and less for
            none.
    """
    known = {template.names[a] for a in stated[stated >= 0].tolist()}
    sides = [pair for pair in sides_by_name(template.names) if known.isdisjoint(pair)]
    groups = [group for group in limbs(template, sides) if LIMB <= len(group) < len(sides)]
    if not groups:
        return []
    y = y[evenly_rounded(len(y), FRAMES)]
    moves = [exchange_of(template, group) for group in groups]
    turns = np.repeat(np.arange(len(template))[None], len(moves), axis=0)
    for turn, (was, to) in zip(turns, moves, strict=True):
        turn[list(was)] = to
    anatomy = Anatomy.of(template.names)
    told = anatomy.gains(y, turns)
    gains = Exchanger.of(template, pairs).gains(y, moves) + told
    there = np.array([np.isfinite(y[:, list(was)]).any() for was, _ in moves])
    best = _best(gains, there & (gains > -NEARLY))[:MOST]
    if pairs.hands is not None:
        by_rest = np.array([gain_by_the_rest(y, pairs, move) for move in moves]) + told
        best += [k for k in _best(by_rest, there & (by_rest > BY_THE_REST)) if k not in best][:1]
    return [turns[k] for k in best]


def _best(gains: Floats, among: Bools) -> list[int]:
    """Those of some exchanges, the one that gains most first."""
    return [k for k in np.argsort(-gains, kind="stable").tolist() if among[k]]


def gain_by_the_rest(y: Single, pairs: PairScore, move: Move) -> float:
    """Nats a frame that an exchange gains by distances between the labels that it moves and all others.

    Args:
        y: (K, L, 3) places of labels as they are, mm, NaN where not seen.
    """
    was, to = (np.array(part) for part in move)
    rest = np.setdiff1d(np.arange(y.shape[1]), was)
    d = lengths(y[:, was, None] - y[:, None, rest])
    gain = pairs.at(d, to[:, None], rest) - pairs.at(d, was[:, None], rest)
    return float(gain.sum()) / max(int(np.isfinite(y[:, was, 0]).any(1).sum()), 1)


def score_with_sides(stretches: Stretches, label: Ints, template: Template, pairs: PairScore) -> float:
    """Nats a frame of all pairs, of quadruples and of what any body shows of its sides (`anatomy`)."""
    score, _ = total_score(stretches, label, pairs)
    y = places(stretches, label, len(template))
    y = y[evenly_rounded(len(y), FRAMES)]
    score += PROOF * Anatomy.of(template.names).agreement(y)
    if pairs.hands is None:  # otherwise the score has them
        score += sum(float(hands(xyz, template.handed, template.sign).sum()) for xyz in y) / max(len(y), 1)
    return score
