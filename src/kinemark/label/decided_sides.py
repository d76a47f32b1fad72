"""Left and right of the whole subject: which exchange of all names of the one side with the other's would lose.

All distances of a body are those of its mirror image. Quadruples tell them apart (`template` (2)), and what any body
shows of its front (`anatomy`); a marker set that is symmetric and flat has neither, and left and right are then a
guess. So all names of the left change places with those of the right at once; where that loses little, the exchanged
body is also settled by moves of a few labels, as a pelvis turns with its legs. Where one of these labellings is better
it is taken; where the two differ by less than two quadruples are worth, the sides are undecided: their names are as
likely as the other way round, and the finding asks. Names that
were stated stay where they are, so that the rest of the body decides by them.

In a world whose axes are left-handed, as where y was counted the other way, the names of the other side have the right
orientation. But no body is quite its own mirror image, and distances are the same in both worlds: by the subject's own
template the exchange of all names loses distances in a right one, and gains them in a mirrored one. So where distances
gain that much and orientation says no, the world is said to be mirrored, and no name is sure; so it is where most
quadruples of the names are turned. Few markers gain little by any exchange; of them the small differences between left
and right tell, which have the other sign in a mirrored world (`asymmetry`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import make_finding
from ..data.array_types import Floats, Ints
from ..data.finding import Finding
from ..numerics.evenly import evenly_rounded
from .anatomy import Anatomy
from .asymmetry import sides_are_turned
from .evidence import WRONG_HAND, PairScore, Single, hands
from .exchange import FRAMES, Exchanger, best_moves
from .side_pairs import mirrored
from .stretches import FREE, Stretches
from .sweeps import places
from .template import Template

UNDECIDED = 2 * WRONG_HAND
"""Nats a frame below which the sides are asked for; chosen, as two quadruples are worth."""
MIRRORED = 20.0
"""Nats a frame that distances gain by the exchange of all sides from which a world is mirrored; chosen: simulated
walkers, hardly to be told from their mirror images, gain up to 10 in a right world, and real subjects by their own
trials 150 and more in a mirrored one, by static ones 20 to 66."""
NEARLY = 100.0
"""Loss of the mirror image, nats a frame, beyond which no other is looked for; chosen: bodies that are known well
lose 220 or more."""


class Sides(NamedTuple):
    """(T) labels with left and right as they fit best; (T) tracks whose side nothing decides; the finding that asks,
    or says that the world is mirrored."""

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
    if _mirrored_world(stretches, new, template, pairs, other):
        return Sides(new, new >= 0, make_finding("world_mirrored"))
    if abs(gain) > UNDECIDED:
        return Sides(new, none, None)
    names = tuple(template.names[a] for a in np.flatnonzero(paired & present))
    return Sides(new, (new >= 0) & (other != every)[new], make_finding("sides_undecided", markers=names))


def _best_turn(
    stretches: Stretches, label: Ints, template: Template, pairs: PairScore, other: Ints
) -> tuple[Ints, float]:
    """(L) what each label becomes on the other side, and the nats a frame that this gains: the better of two ways."""
    exchanger, anatomy = Exchanger.of(template, pairs).keeping(stretches.fixed), Anatomy.of(template.names)
    y = _some_places(stretches, label, len(template))

    def gain(turn: Ints) -> float:
        return _gain(exchanger, y, turn) + anatomy.gain(y, turn)

    plain = gain(other)
    if plain < -NEARLY:
        return other, plain
    settled = best_moves(y[:, np.argsort(other)], exchanger, WRONG_HAND, anatomy)[other]
    if (settled == np.arange(len(settled))).all() or (settled == other).all():
        return other, plain
    return max(((other, plain), (settled, gain(settled))), key=lambda one: one[1])


def _mirrored_world(stretches: Stretches, label: Ints, template: Template, pairs: PairScore, other: Ints) -> bool:
    """Whether labels (T) fit better by distances with their sides exchanged, or most of their quadruples are turned.

    By another subject's template, who is not quite symmetric in another way, and where names were stated, distances
    tell nothing.
    """
    y = _some_places(stretches, label, len(template))
    seen = np.isfinite(y[:, template.handed, 0]).all(2)
    turned = np.array([hands(xyz, template.handed, template.sign) < 0 for xyz in y]).reshape(seen.shape) & seen
    if 2 * turned.sum() > seen.sum():
        return True
    if np.any(template.doubt) or (stretches.fixed != FREE).any():
        return False
    plain = Exchanger.of(template, pairs)
    by_distances = plain._replace(handed=plain.handed[:0], sign=plain.sign[:0])
    return _gain(by_distances, y, other) > MIRRORED or sides_are_turned(y, template, other)


def _some_places(stretches: Stretches, label: Ints, L: int) -> Single:
    """(K, L, 3) of labels, in the frames that are compared."""
    y = places(stretches, label, L)
    return y[evenly_rounded(len(y), FRAMES)]


def _gain(exchanger: Exchanger, y: Single, turn: Ints) -> float:
    """Nats a frame by which labels y (K, L, 3) are better when each becomes turn (L)."""
    moved = np.flatnonzero(turn != np.arange(len(turn)))
    return float(exchanger.gains(y, [(tuple(moved.tolist()), tuple(turn[moved].tolist()))])[0])


def at_most_even(probability: Floats, undecided: NDArray[np.bool_]) -> Floats:
    """(T) with those that are undecided as likely as their mirror image: half of what they were."""
    return np.asarray(np.where(undecided, 0.5 * probability, probability))
