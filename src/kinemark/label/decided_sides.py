"""Left and right of the whole subject: which exchange of all names of the one side with the other's would lose.

All distances of a body are those of its mirror image. Quadruples tell them apart (`template` (2)), and what any body
shows of its front (`anatomy`); a marker set that is symmetric and flat has neither, and left and right are then a
guess. So all names of the left change places with those of the right at once; where that loses little, the exchanged
body is also settled by moves of a few labels, as a pelvis turns with its legs. Where one of these labellings is better
it is taken; where the two differ by less than two quadruples are worth, the sides are undecided: their names are as
likely as the other way round, and the finding asks. Names that
were stated stay where they are, so that the rest of the body decides by them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import make_finding
from ..data.array_types import Floats, Ints
from ..data.finding import Finding
from .anatomy import Anatomy
from .evidence import WRONG_HAND, PairScore
from .exchange import FRAMES, Exchanger, best_moves
from .side_pairs import mirrored
from .stretches import Stretches
from .sweeps import places
from .template import Template

UNDECIDED = 2 * WRONG_HAND
"""Nats a frame below which the sides are asked for; chosen, as two quadruples are worth."""
NEARLY = 100.0
"""Loss of the mirror image, nats a frame, beyond which no other is looked for; chosen: bodies that are known well
lose 220 or more."""


class Sides(NamedTuple):
    """(T) labels with left and right as they fit best; (T) tracks whose side nothing decides; the finding that asks."""

    label: Ints
    undecided: NDArray[np.bool_]
    finding: Finding | None


def decided_sides(stretches: Stretches, label: Ints, template: Template, pairs: PairScore) -> Sides:
    """The labelling or its mirror image, whichever is better; undecided where they are nearly as good.

    Args:
        label: (T) of the trial, −1 for none.
    """
    every, none = np.arange(len(template)), np.zeros(len(label), bool)
    other = mirrored(template.names)
    stated = np.isin(every, stretches.fixed)
    other = np.where(stated | stated[other], every, other)
    present = np.isin(every, label)
    paired = (other != every) & (present | present[other])
    if not paired.any():
        return Sides(label, none, None)
    turn, gain = _best_turn(stretches, label, template, pairs, other)
    new = np.where(label >= 0, turn[label], -1) if gain > 0 else label
    if abs(gain) > UNDECIDED:
        return Sides(new, none, None)
    names = tuple(template.names[a] for a in np.flatnonzero(paired & present))
    return Sides(new, (new >= 0) & (other != every)[new], make_finding("sides_undecided", markers=names))


def _best_turn(
    stretches: Stretches, label: Ints, template: Template, pairs: PairScore, other: Ints
) -> tuple[Ints, float]:
    """(L) what each label becomes on the other side, and the nats a frame that this gains: the better of two ways."""
    exchanger, anatomy = Exchanger.of(template, pairs).keeping(stretches.fixed), Anatomy.of(template.names)
    y = places(stretches, label, len(template))
    y = y[np.unique(np.linspace(0, len(y) - 1, min(len(y), FRAMES)).round().astype(int))]

    def gain(turn: Ints) -> float:
        moved = np.flatnonzero(turn != np.arange(len(turn)))
        move = (tuple(moved.tolist()), tuple(turn[moved].tolist()))
        return float(exchanger.gains(y, [move])[0]) + anatomy.gain(y, turn)

    plain = gain(other)
    if plain < -NEARLY:
        return other, plain
    settled = best_moves(y[:, np.argsort(other)], exchanger, WRONG_HAND)[other]
    if (settled == np.arange(len(settled))).all() or (settled == other).all():
        return other, plain
    return max(((other, plain), (settled, gain(settled))), key=lambda one: one[1])


def at_most_even(probability: Floats, undecided: NDArray[np.bool_]) -> Floats:
    """(T) with those that are undecided as likely as their mirror image: half of what they were."""
    return np.asarray(np.where(undecided, 0.5 * probability, probability))
