"""Moves that no single track can make: two to four labels change places all through the trial.

The markers of a plate look alike: with two of them exchanged, each supports the other. So whole labels are exchanged
and the score of all pairs that this touches is compared, by the template as it was given:

    ΔS = Σ_pairs ‹ l(|y_a − y_b|; D_π(a)π(b)) − l(|y_a − y_b|; D_ab) ›  + quadruples                                (1)

No pair can have more than its base, nor can more quadruples be turned back than are wrong. So a move gains in frame k
at most

    u_k = Σ_pairs base_π(a)π(b) − l(|y_a − y_b|; D_ab)  + quadruples that are wrong                               (2)

and one that loses more in some frames than all others can give has not to be looked at.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Bools, Ints
from ..numerics.evenly import evenly_rounded
from ..numerics.vectors import lengths
from .anatomy import Anatomy
from .evidence import WRONG_HAND, PairScore, Single
from .template import Template

FRAMES = 40
"""Frames in which moves are compared; chosen."""
NEAR, NEAR_THREE = 8, 5
"""Nearest labels with which one is exchanged, in twos and in threes; chosen."""
BEST = 24
"""Exchanges of two, the best, that are tried two at a time; chosen."""
MOST_AT_ONCE = 400_000
"""Distances that are scored at once; chosen: they stay in a processor's cache."""
MOVES = 30
"""At most, one after the other; chosen."""
UNTOLD = 2.0
"""Nats a frame below which distances and quadruples tell nothing of a move, so that what any body shows of its front
decides; chosen: heel and toe of a foot whose ankle is absent lose 0.0 to 0.1, with it 12 and more."""
ONE_OF, ROUNDED = 8, 1.0
"""Every how many frames what a move gains is known to (2), chosen: two of the dozen frames of a window; and nats that
rounding may make of sums in single precision, chosen far above."""

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

    def gains(self, y: Single, moves: Sequence[Move]) -> NDArray[np.float64]:
        """(1) of moves, nats, mean over frames; y (K, L, 3) places of the labels as they are."""
        seen = [np.isfinite(y[:, list(was), 0]).any(1).sum() for was, _ in moves]
        return self.nats(y, moves) / np.maximum(seen, 1)

    def may_gain(self, y: Single, moves: Sequence[Move]) -> Bools:
        """Whether (1) of moves that exchange two may be above 0, by (2)."""
        was = np.array([move[0] for move in moves], np.int64).reshape(-1, 2)
        most = self.pairs.base.sum(1)[was].sum(1) - self._as_they_are(y)[:, was].sum(2)
        some = np.arange(len(y)) % ONE_OF == 0
        return np.asarray(self.nats(y[some], moves) + most[~some].sum(0) > -ROUNDED)

    def _as_they_are(self, y: Single) -> Single:
        """(K, L) nats of all pairs and quadruples of which each label is one."""
        a, b = np.nonzero(np.triu(self.pairs.inverse))
        d = lengths(y[:, a] - y[:, b])
        of = np.zeros((len(a) + len(self.handed), y.shape[1]), np.float32)
        of[np.arange(len(a)), a] = of[np.arange(len(a)), b] = 1.0
        np.put_along_axis(of[len(a) :], self.handed, np.float32(1.0), axis=1)
        wrong = -WRONG_HAND * _wrong(_planes(y), self.handed, self.sign).T
        return np.asarray(np.hstack([self.pairs.at(d, a, b), wrong]) @ of)

    def nats(self, y: Single, moves: Sequence[Move]) -> NDArray[np.float64]:
        """(1) of moves, nats of all frames together; as `gains`."""
        return self.of_frames(y, moves).sum(1)

    def of_frames(self, y: Single, moves: Sequence[Move]) -> NDArray[np.float64]:
        """(M, K) the same of each frame."""
        found = np.zeros((len(moves), len(y)))
        if not moves:
            return found
        d, planes = lengths(y[:, :, None] - y[:, None]), _planes(y)
        wrong = _wrong(planes, self.handed, self.sign)
        for size in {len(was) for was, _ in moves}:
            own = [i for i, (was, _) in enumerate(moves) if len(was) == size]
            most = max(1, MOST_AT_ONCE // max(y.shape[0] * y.shape[1] * size, 1))
            for some in (own[k : k + most] for k in range(0, len(own), most)):
                found[some] = self._nats(
                    d, planes, wrong, *(np.array(part) for part in zip(*(moves[i] for i in some), strict=True))
                )
        return found

    def _nats(self, d: Single, planes: Single, wrong: Single, was: Ints, to: Ints) -> NDArray[np.float64]:
        """(M, K) of moves of as many labels, (M, n) each; d (K, L, L) distances of the labels as they are."""
        every, rows = np.arange(d.shape[1]), np.arange(len(was))[:, None]
        new = np.repeat(every[None], len(was), axis=0)
        new[rows, was] = to
        apart = d[:, was].transpose(1, 2, 0, 3)  # (M, n, K, L)
        each = self.pairs.at(apart, to[:, :, None, None], new[:, None, None])
        each -= self.pairs.at(apart, was[:, :, None, None], every)
        moved = np.ones((len(was), len(every)), np.float32)
        moved[rows, was] = 0.5  # counted from both sides
        nats = (each @ moved[:, None, :, None])[..., 0].sum(1)
        return np.asarray(nats - WRONG_HAND * self._hands(planes, wrong, was, new))

    def _hands(self, planes: Single, wrong: Single, was: Ints, new: Ints) -> Single:
        """(M, K) how many quadruples more are turned the wrong way after each move; (Q, K) `wrong` as they are."""
        more = np.zeros((len(was), planes.shape[2]), np.float32)
        of_quad = np.zeros((new.shape[1], len(self.handed)), bool)
        of_quad[self.handed, np.arange(len(self.handed))[:, None]] = True
        move, quad = np.nonzero(of_quad[was].any(1))
        if len(move):
            back = np.argsort(new, axis=1)  # who is label a after the move
            now = _wrong(planes, back[move[:, None], self.handed[quad]], self.sign[quad])
            own, first = np.unique(move, return_index=True)
            more[own] = np.add.reduceat(now - wrong[quad], first, axis=0)
        return more

    def pairs_of_twos(self, gains: NDArray[np.float64]) -> list[Move]:
        """Two exchanges at once, of the best and disjoint."""
        best = [self.twos[i] for i in np.argsort(-gains, kind="stable")[:BEST]]
        both = [(p, q) for p, q in combinations(best, 2) if not set(p[0]) & set(q[0])]
        return [((*p[0], *q[0]), (*p[1], *q[1])) for p, q in both]


def _planes(y: Single) -> Single:
    """(3, L, K) of places (K, L, 3): what is taken of a label lies in one piece."""
    return np.ascontiguousarray(y.transpose(2, 1, 0))


def _wrong(planes: Single, quads: Ints, sign: Ints) -> Single:
    """(Q, K) one where a quadruple is turned the wrong way."""
    a = planes[:, quads[:, 0]]
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = (planes[:, quads[:, k]] - a for k in (1, 2, 3))
    triple = ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx)
    return (sign[:, None].astype(np.float32) * triple < 0).astype(np.float32)


def best_moves(y: Single, exchanger: Exchanger, least: float, anatomy: Anatomy | None = None) -> Ints:
    """(L) what each label becomes after all moves that gain more than `least` nats, the best first.

    Args:
        anatomy: tells of moves of which distances and quadruples do not: heel and toe of a foot without its ankle.
    """
    L = y.shape[1]
    some = evenly_rounded(len(y), FRAMES)
    y = y[some]
    new = np.arange(L)
    for _ in range(MOVES):
        twos = exchanger.gains(y, exchanger.twos)
        moves = [*exchanger.threes, *exchanger.pairs_of_twos(twos)]
        gains, moves = np.concatenate([twos, exchanger.gains(y, moves)]), [*exchanger.twos, *moves]
        if anatomy is not None:
            gains = _with_anatomy(y, moves, gains, anatomy)
        if not len(gains):
            break
        best = int(gains.argmax())
        if gains[best] <= least:
            break
        turn = _turn(moves[best], L)
        new = turn[new]
        y = y[:, np.argsort(turn)]
    return new


def _with_anatomy(
    y: Single, moves: Sequence[Move], gains: NDArray[np.float64], anatomy: Anatomy
) -> NDArray[np.float64]:
    """(M) gains of moves, with what any body shows of its front where distances and quadruples tell nothing."""
    there: Bools = np.asarray(np.isfinite(y[..., 0]).any(0))
    untold = np.flatnonzero(np.abs(gains) < UNTOLD).tolist()
    told = [k for k in untold if anatomy.tells([a for a in moves[k][0] if there[a]])]
    gains = gains.copy()
    gains[told] += anatomy.gains(y, [_turn(moves[k], y.shape[1]) for k in told])
    return gains


def _turn(move: Move, L: int) -> Ints:
    """(L) what each label becomes by a move."""
    turn = np.arange(L)
    turn[list(move[0])] = move[1]
    return turn
