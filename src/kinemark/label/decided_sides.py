"""Left and right of the whole subject: which exchange of all names of the one side with the other's would lose.

All distances of a body are those of its mirror image. Quadruples tell them apart (`template` (2)); a marker set that is
symmetric and flat has none, and front and back, left and right are then a guess. So all names of the left change places
with those of the right at once. Where that gains, it is done; where it neither gains nor loses as much as one quadruple
is worth, the sides are undecided: their names are as likely as the other way round, and the finding asks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import make_finding
from ..data.array_types import Floats, Ints
from ..data.finding import Finding
from .evidence import WRONG_HAND, PairScore
from .exchange import FRAMES, Exchanger
from .side_pairs import sides_by_name
from .stretches import Stretches
from .sweeps import places
from .template import Template


def mirrored(names: tuple[str, ...]) -> Ints:
    """(L) the label of each name's other side; its own where it has none."""
    number = {name: a for a, name in enumerate(names)}
    out = np.arange(len(names))
    for one, other in sides_by_name(names):
        out[[number[one], number[other]]] = number[other], number[one]
    return out


class Sides(NamedTuple):
    """(T) labels with left and right as they fit best; (T) tracks whose side nothing decides; the finding that asks."""

    label: Ints
    undecided: NDArray[np.bool_]
    finding: Finding | None


def decided_sides(stretches: Stretches, label: Ints, template: Template, pairs: PairScore) -> Sides:
    """All sides exchanged where that gains more than a quadruple is worth; undecided where it loses no more than that.

    Args:
        label: (T) of the trial, −1 for none.
    """
    other, every, none = mirrored(template.names), np.arange(len(template)), np.zeros(len(label), bool)
    present = np.isin(every, label)
    paired = (other != every) & (present | present[other])
    if not paired.any():
        return Sides(label, none, None)
    gain = _gain(stretches, label, template, pairs, np.flatnonzero(paired), other)
    if gain > WRONG_HAND:
        return Sides(np.where(label >= 0, other[label], -1), none, None)
    if gain < -WRONG_HAND:
        return Sides(label, none, None)
    names = tuple(template.names[a] for a in np.flatnonzero(paired & present))
    return Sides(label, (label >= 0) & paired[label], make_finding("sides_undecided", markers=names))


def _gain(stretches: Stretches, label: Ints, template: Template, pairs: PairScore, moved: Ints, other: Ints) -> float:
    """Nats a frame that the exchange of all these labels gains."""
    y = places(stretches, label, len(template))
    y = y[np.unique(np.linspace(0, len(y) - 1, min(len(y), FRAMES)).round().astype(int))]
    move = (tuple(moved.tolist()), tuple(other[moved].tolist()))
    return float(Exchanger.of(template, pairs).gains(y, [move])[0])


def at_most_even(probability: Floats, undecided: NDArray[np.bool_]) -> Floats:
    """(T) with those that are undecided as likely as their mirror image: half of what they were."""
    return np.asarray(np.where(undecided, 0.5 * probability, probability))
