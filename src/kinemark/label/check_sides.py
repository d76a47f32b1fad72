"""Labelled trials checked for left and right: limbs whose sides are swapped, for a while or all through.

A limb that is swapped keeps all distances within itself, so that no exchange of two markers shows it. Each limb
(`limbs`) is swapped as one; of those that gain, the one that gains most is taken, and pairs are added to it and taken
from it as long as that gains more, down to one pair.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..data import Trajectories
from ..data.progress import tell
from .check import LEAST_NATS, WINDOW_S
from .check_ends import ends
from .evidence import PairScore, Single
from .exchange import Exchanger, Move
from .limbs import exchange_of, limbs
from .stretches import stretches_of
from .sweeps import places
from .template import Template


class SideSwap(NamedTuple):
    """Left and right of some markers that fit better the other way round.

    Attributes:
        pairs: names of left and right.
        first, stop: first and last-plus-one frame, from 0.
        gain: nats a frame by which the other way round is better.
        off_mm, off_swapped_mm: median by which the distances of these markers to all others are off, as the names are
            and the other way round; NaN where the whole body is swapped, whose distances stay.
    """

    pairs: tuple[tuple[str, str], ...]
    first: int
    stop: int
    gain: float
    off_mm: float
    off_swapped_mm: float


def find_side_swaps(
    trajectories: Trajectories, template: Template, pairs: Sequence[tuple[str, str]]
) -> tuple[SideSwap, ...]:
    """Stretches of a labelled trial in which left and right of some pairs are swapped, in the order of time.

    Args:
        trajectories: labelled. template: of the subject.
        pairs: left and right names, as `MarkerSet.pairs` or `sides_by_name` have them.
    """
    there = {name for name in template.names if name in trajectories.names}
    kept = [pair for pair in pairs if set(pair) <= there]
    if len(kept) < 2:
        return ()
    known = trajectories.select([name for name in template.names if name in there])
    stretches = stretches_of(known, template.size)
    y = places(stretches, np.array([template.names.index(name) for name in known.names]), len(template))
    exchanger = Exchanger.of(template, PairScore.of_template(template))
    groups = limbs(template, kept)
    wide = max(1, round(WINDOW_S * trajectories.rate))
    window = stretches.frame // wide
    found = []
    for part in (parts := np.unique(window)):
        tell(int(part), int(parts[-1]))
        rows = np.flatnonzero(window == part)
        best = _best(y[rows], template, exchanger, groups)
        if best is not None:
            group, gain, off = best
            found.append(
                SideSwap(tuple(group), int(stretches.frame[rows[0]]), int(stretches.frame[rows[-1]]) + 1, gain, *off)
            )
    placed = (_placed(one, known, template, exchanger, wide) for one in _merged(found, 2 * wide))
    return tuple(sorted(placed, key=lambda one: one.first))


def _placed(one: SideSwap, known: Trajectories, template: Template, exchanger: Exchanger, window: int) -> SideSwap:
    """With its ends to the frame."""
    move = exchange_of(template, one.pairs)
    first, stop = ends(known, template, exchanger, move, (one.first, one.stop), window)
    return one._replace(first=first, stop=stop)


def _best(
    y: Single, template: Template, exchanger: Exchanger, groups: list[list[tuple[str, str]]]
) -> tuple[list[tuple[str, str]], float, tuple[float, float]] | None:
    """The group whose swap gains most in these frames, if any gains enough."""
    seen = np.asarray(np.isfinite(y[..., 0]).any(0))
    moves = [exchange_of(template, group) for group in groups]
    usable = np.array([float(np.mean(seen[list(move[0])])) > 0.5 for move in moves])
    gains = np.where(usable, exchanger.gains(y, moves), -np.inf)
    best, gain = groups[int(gains.argmax())], float(gains.max())
    if gain <= LEAST_NATS:
        return None
    while True:
        turned = [[p for p in groups[-1] if (p in best) != (p == pair)] for pair in groups[-1]]
        turned = [group for group in turned if group]
        gains = exchanger.gains(y, [exchange_of(template, group) for group in turned])
        if not len(turned) or gains.max() <= gain + 1e-6:
            return best, gain, _off(y, template, exchange_of(template, best))
        best = turned[int(gains.argmax())]
        gain = float(gains.max())


def _off(y: Single, template: Template, move: Move) -> tuple[float, float]:
    """Median by which distances between the moved and the other labels are off, mm, before and after."""
    was, to = np.array(move[0]), np.array(move[1])
    others = np.setdiff1d(np.arange(len(template)), was)
    d = np.linalg.norm(y[:, was][:, :, None] - y[:, others][:, None], axis=-1)
    if not np.isfinite(d).any():
        return float("nan"), float("nan")
    before = np.nanmedian(np.abs(d - template.distance[np.ix_(was, others)]))
    after = np.nanmedian(np.abs(d - template.distance[np.ix_(to, others)]))
    return round(float(before), 1), round(float(after), 1)


def _merged(found: list[SideSwap], near: int) -> list[SideSwap]:
    """Neighbouring windows with the same pairs as one."""
    out: list[SideSwap] = []
    for one in found:
        old = next(
            (k for k, other in enumerate(out) if other.pairs == one.pairs and one.first - other.stop < near), None
        )
        if old is None:
            out.append(one)
            continue
        before = out[old]
        n, m = before.stop - before.first, one.stop - one.first
        mean = [(n * x + m * z) / (n + m) for x, z in zip(before[3:], one[3:], strict=True)]
        out[old] = SideSwap(one.pairs, before.first, one.stop, *mean)
    return out
