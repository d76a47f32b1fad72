"""A first labelling of single frames, without any knowledge but the template: beam search.

Labels are placed one after the other, each time the one that those placed before tell most of. A state says which
point each placed label has, or none; all its continuations are scored by the distances to a label's most telling
neighbours and by quadruples' orientation, and the best `beam` go on. Frames are ranked by the score of what was found,
not by how many points they have.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data.array_types import Ints
from .evidence import WRONG_HAND, PairScore, Single, distances, hands
from .stretches import FREE

TELLING = 14
"""Placed labels to which a new one is compared; chosen: more change nothing but the time."""
QUADS_EACH = 4
"""Quadruples that a new label is tested by; chosen."""
ROUNDS = 6
"""Of assignment after the search, at most; chosen."""
STATED = 1e6
"""Worth of a name that was stated, nats; chosen: more than all evidence of a frame."""


class Placing(NamedTuple):
    """A label's turn in the search: itself, its telling neighbours among those before, quadruples' others and signs."""

    label: int
    by: Ints
    others: Ints
    sign: Ints


def placings(pairs: PairScore, handed: Ints, sign: Ints, first: Sequence[int] = ()) -> list[Placing]:
    """The order in which labels are placed; `first` those of which it was stated where they are."""
    told = pairs.expected
    L = len(told)
    done = list(first) or [int(np.sort(told, axis=1)[:, -4:].sum(1).argmax())]
    turn = {a: k for k, a in enumerate(done)}
    while len(done) < L:
        best = np.sort(told[:, done], axis=1)[:, -TELLING:].sum(1)
        best[done] = -np.inf
        turn[int(best.argmax())] = len(done)
        done.append(int(best.argmax()))
    last = np.array([max(quad, key=lambda a: turn[a]) for quad in handed.tolist()], np.int64)
    out = []
    for k, a in enumerate(done):
        by = np.array(done[:k], np.int64)
        by = by[np.argsort(-told[a, by], kind="stable")[:TELLING]]
        own = np.flatnonzero(last == a)[:QUADS_EACH]
        others, signs = _others(handed[own], sign[own], a)
        out.append(Placing(a, by, others, signs))
    return out


def _others(quads: Ints, sign: Ints, a: int) -> tuple[Ints, Ints]:
    """(q, 3) the other labels, and signs of (others, a) in that order: b − a is the last edge of the triple product."""
    others = np.array([[b for b in quad if b != a] for quad in quads.tolist()], np.int64).reshape(-1, 3)
    place = np.array([quad.index(a) for quad in quads.tolist()], np.int64)
    return others, sign * np.where(place % 2 == 1, 1, -1)


def search(xyz: Single, pairs: PairScore, order: list[Placing], beam: int, fixed: Ints | None = None) -> Ints:
    """(L) the point of each label, or −1, in the best state found; xyz (N, 3) all points of one frame.

    `fixed` (N) says which label a point has, as `Stretches.fixed`; nothing of any where None.
    """
    N, L = len(xyz), len(order)
    fixed = np.full(N, FREE) if fixed is None else fixed
    d = distances(xyz, xyz)
    np.fill_diagonal(d, np.nan)
    state, score = np.full((1, L), N, np.int64), np.zeros(1, np.float32)  # N: no point
    used = np.zeros((1, N + 1), bool)
    far = np.vstack([xyz, np.full((1, 3), np.nan, np.float32)])
    for turn in order:
        gain = np.zeros((len(state), N + 1), np.float32)
        table = np.zeros((len(turn.by), N + 1, N + 1), np.float32)
        table[:, :N, :N] = pairs.at(d, turn.label, turn.by[:, None, None])
        for b, told in zip(turn.by, table, strict=True):
            gain += told[state[:, b]]
        for others, sign in zip(turn.others, turn.sign, strict=True):
            gain[:, :N] += _hand(far[state[:, others]], xyz, sign)
        total = np.where(used, -np.inf, score[:, None] + gain)
        total[:, N] = score
        its = fixed == turn.label
        total[:, np.append(~its, True) if its.any() else np.append(fixed != FREE, False)] = -np.inf
        flat = total.ravel()
        keep = np.argpartition(-flat, beam)[:beam] if len(flat) > beam else np.arange(len(flat))
        keep = keep[np.isfinite(flat[keep])]
        parent, point = np.divmod(keep, N + 1)
        state, score, used = state[parent].copy(), flat[keep], used[parent].copy()
        state[:, turn.label] = point
        used[np.arange(len(keep)), point] = True
        used[:, N] = False
    best = state[score.argmax()]
    return np.where(best < N, best, -1)


def _hand(three: Single, xyz: Single, sign: int) -> Single:
    """(B, N) nats of candidates xyz (N, 3) beside three placed points (B, 3, 3)."""
    p = three[:, 0]
    normal = np.cross(three[:, 1] - p, three[:, 2] - p)
    volume = sign * (normal @ xyz.T - (normal * p).sum(-1)[:, None])
    return np.where(volume < 0, np.float32(-WRONG_HAND), np.float32(0.0))


def settle(xyz: Single, point: Ints, pairs: PairScore, fixed: Ints | None = None) -> Ints:
    """(L) assigned anew by all labelled neighbours until nothing changes; points that none claims stay free.

    `fixed` (N) as for `search`; such points keep what they are.
    """
    fixed = np.full(len(xyz), FREE) if fixed is None else fixed
    stated = np.flatnonzero(fixed >= 0)
    for _ in range(ROUNDS):
        labelled = np.full((len(point), 3), np.nan, np.float32)
        placed = np.flatnonzero(point >= 0)
        labelled[placed] = xyz[point[placed]]
        own = np.full(len(xyz), -1)
        own[point[placed]] = placed
        nats = pairs.of_points(xyz, labelled, own)
        gain = np.where((fixed == FREE)[:, None], np.maximum(nats, 0.0), 0.0)
        gain[stated, fixed[stated]] = STATED
        rows, columns = scipy.optimize.linear_sum_assignment(-gain)
        new = np.full(len(point), -1)
        good = gain[rows, columns] > 0
        new[columns[good]] = rows[good]
        if (new == point).all():
            break
        point = new
    return point


def frame_score(xyz: Single, point: Ints, pairs: PairScore, handed: Ints, sign: Ints) -> float:
    """Nats of a frame's labelling by all pairs and quadruples."""
    labelled = np.full((len(point), 3), np.nan, np.float32)
    placed = np.flatnonzero(point >= 0)
    labelled[placed] = xyz[point[placed]]
    every: NDArray[np.int64] = np.arange(len(point))
    nats = pairs.at(distances(labelled, labelled), every[:, None], every[None])
    return float(nats.sum() / 2 + hands(labelled, handed, sign).sum())
