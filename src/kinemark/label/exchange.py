"""Moves that no single track can make: two to four labels change places all through the trial.

The markers of a plate look alike: with two of them exchanged, each supports the other. So whole labels are exchanged
and the score of all pairs that this touches is compared, by the template as it was given:

    ΔS = Σ_pairs ‹ l(|y_a − y_b|; D_π(a)π(b)) − l(|y_a − y_b|; D_ab) ›  + quadruples                                (1)
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Ints
from .evidence import WRONG_HAND, PairScore, Single
from .template import Template

FRAMES = 40
"""Frames in which moves are compared; chosen."""
NEAR, NEAR_THREE = 8, 5
"""Nearest labels with which one is exchanged, in twos and in threes; chosen."""
BEST = 24
"""Exchanges of two, the best, that are tried two at a time; chosen."""
MOVES = 30
"""At most, one after the other; chosen."""

Move = tuple[tuple[int, ...], tuple[int, ...]]
"""Labels, and what they become."""


class Exchanger(NamedTuple):
    """The moves that a template suggests, and what compares them."""

    pairs: PairScore
    handed: Ints
    sign: Ints
    twos: list[Move]
    threes: list[Move]

    @classmethod
    def of(cls, template: Template, pairs: PairScore) -> Exchanger:
        """Moves among labels that are near each other."""
        d = np.where(np.isfinite(template.distance), template.distance, np.inf) + np.diag(
            np.full(len(template), np.inf)
        )
        near = np.argsort(d, axis=1, kind="stable")
        twos = {tuple(sorted((a, int(b)))) for a, row in enumerate(near) for b in row[:NEAR] if a != b}
        groups = {
            tuple(sorted((a, int(b), int(c))))
            for a, row in enumerate(near)
            for b, c in combinations(row[:NEAR_THREE], 2)
            if len({a, int(b), int(c)}) == 3
        }
        cycles: list[Move] = [(g, to) for g in sorted(groups) for to in ((g[1], g[2], g[0]), (g[2], g[0], g[1]))]
        return cls(pairs, template.handed, template.sign, [((a, b), (b, a)) for a, b in sorted(twos)], cycles)

    def keeping(self, labels: Ints) -> Exchanger:
        """Without the moves of these labels, of which it was stated who they are; −1 and less for none."""
        known = set(labels[labels >= 0].tolist())
        twos, threes = ([move for move in moves if not known & set(move[0])] for moves in (self.twos, self.threes))
        return self._replace(twos=twos, threes=threes)

    def gain(self, y: Single, d: Single, move: Move) -> float:
        """(1) in nats, mean over frames; y (K, L, 3) places and d (K, L, L) distances of the labels as they are."""
        was, to = list(move[0]), list(move[1])
        L = y.shape[1]
        every = np.arange(L)
        new = every.copy()
        new[was] = to
        a, b = np.array(was)[:, None], every[None]
        each = self.pairs.at(d[:, was], new[a], new[b]) - self.pairs.at(d[:, was], a, b)
        each[:, :, was] *= 0.5  # counted from both sides
        quads = np.flatnonzero(np.isin(self.handed, was).any(1))
        back = np.argsort(new)  # who is label a after the move
        old, now = self.handed[quads], back[self.handed[quads]]
        seen = max(1, int(np.isfinite(y[:, was, 0]).any(1).sum()))
        hands = (_wrong(y, now, self.sign[quads]) - _wrong(y, old, self.sign[quads])).sum()
        return float((each.sum() - WRONG_HAND * hands) / seen)

    def gains(self, y: Single, moves: list[Move]) -> NDArray[np.float64]:
        """Of many moves."""
        d = np.sqrt(((y[:, :, None] - y[:, None]) ** 2).sum(-1))
        return np.array([self.gain(y, d, move) for move in moves])

    def pairs_of_twos(self, gains: NDArray[np.float64]) -> list[Move]:
        """Two exchanges at once, of the best and disjoint."""
        best = [self.twos[i] for i in np.argsort(-gains, kind="stable")[:BEST]]
        both = [(p, q) for p, q in combinations(best, 2) if not set(p[0]) & set(q[0])]
        return [((*p[0], *q[0]), (*p[1], *q[1])) for p, q in both]


def _wrong(y: Single, quads: Ints, sign: Ints) -> NDArray[np.int64]:
    """(K, Q) one where a quadruple is turned the wrong way."""
    a = y[:, quads[:, 0]]
    u, v, w = (y[:, quads[:, k]] - a for k in (1, 2, 3))
    return (sign * (u * np.cross(v, w)).sum(-1) < 0).astype(np.int64)


def best_moves(y: Single, exchanger: Exchanger, least: float) -> Ints:
    """(L) what each label becomes after all moves that gain at least `least` nats, the best first."""
    L = y.shape[1]
    some = np.linspace(0, len(y) - 1, min(len(y), FRAMES)).round().astype(int)
    y = y[some]
    new = np.arange(L)
    for _ in range(MOVES):
        twos = exchanger.gains(y, exchanger.twos)
        moves = [*exchanger.threes, *exchanger.pairs_of_twos(twos)]
        gains = np.concatenate([twos, exchanger.gains(y, moves)])
        if not len(gains):
            break
        best = int(gains.argmax())
        if gains[best] <= least:
            break
        was, to = [*exchanger.twos, *moves][best]
        turn = np.arange(L)
        turn[list(was)] = to
        new = turn[new]
        y = y[:, np.argsort(turn)]
    return new
