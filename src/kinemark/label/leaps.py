"""Pieces that leap off the course of their marker, as ghosts in its gap do.

A ghost can lie where its marker is at other times: a marker of the shank moves by centimetres against the thigh. But
it does not lie there then. Where a marker was off its foretold place just before, and just after, says where it is
meanwhile, by `carried_places` (2): the place c, with the covariance C that the core of the marker shows for as much
time. A piece p leaps where at its first and its last sample

    (p − c)ᵀ C⁻¹ (p − c) > LEAP²                                                                                   (1)

The pieces before and after may be ghosts themselves. So first a piece leaps that does so from each side alone, and
then those that leap from both sides together when all that leapt before are left out, with whatever bears their name.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from .body_places import Figure, distance
from .carried_places import carried, changes
from .stretches import GRID_HZ, Stretches
from .sweeps import places

LEAP = 20.0**0.5
"""Of (1), standard deviations; chosen on trials of three children, simulated walks and five recordings: by it 10 of 34
ghosts in gaps that had sure names, and pieces with 0.13 % of the samples, are sure no more; by 12 of its square 13 and
0.32 %."""


def marker_places(stretches: Stretches, label: Ints, own: Ints) -> Floats:
    """(M, K, 3) mm where the labels `own` (M) are by label (T) of tracks, NaN where not seen."""
    return places(stretches, label, int(own.max(initial=-1)) + 1)[:, own].swapaxes(0, 1).astype(float)


def leaping(stretches: Stretches, label: Ints, own: Ints, every: list[Figure], core: Floats, asked: Bools) -> Bools:
    """(T) whether pieces leap.

    Args:
        label: (T) −1 for none. own: (M) labels of the markers. every: figures of those that are looked at.
        core: (M, K, 3) mm, the cores of markers. asked: (T) of which pieces.
    """
    step = int(np.diff(stretches.frame).max(initial=1))
    time, grid = stretches.frame / step, (stretches.frame - stretches.frame[:1]) % step == 0
    out, xyz = np.zeros(len(label), bool), marker_places(stretches, label, own)
    v = [changes(one, core[one.marker][grid], xyz[one.near][:, grid], GRID_HZ) for one in every]
    for alone in (True, False):
        xyz, out = marker_places(stretches, np.where(out, -1, label), own), np.zeros(len(label), bool)
        for figure, change in zip(every, v, strict=True):
            t = np.flatnonzero(asked & (label == own[figure.marker]))
            out[t] = _squares(figure, xyz, stretches.xyz[t].astype(float), time, change, alone) > LEAP**2
    return out


def _squares(
    figure: Figure, xyz: Floats, pieces: Floats, time: Floats, change: tuple[Floats, Floats], alone: bool
) -> Floats:
    """(P) of (1) of pieces (P, K, 3) mm, the least of both ends, each by one side `alone` or by both; 0 by none."""
    own, seen = xyz[figure.marker], np.isfinite(pieces[..., 0])
    P, piece = len(pieces), np.tile(np.arange(len(pieces)), 2)
    end = np.r_[seen.argmax(1), seen.shape[1] - 1 - seen[:, ::-1].argmax(1)]
    sides = _sides(np.isfinite(own[:, 0]), seen[piece], end)
    if alone:
        sides = np.r_[sides[0, :P], sides[1, P:]][None]
    place, cov = carried(figure, own, xyz[figure.near], end, sides, time, change)
    square = distance(pieces[piece, end], place, cov)
    told = (sides >= 0).any(0) & np.isfinite(square)
    least = np.where(told, square, np.inf).reshape(2, P).min(0)
    return np.where(np.isfinite(least), least, 0.0)


def _sides(known: Bools, seen: Bools, end: Ints) -> Ints:
    """(2, P) the nearest rows before and after `end` (P) in which others than these pieces (P, K) are known (K)."""
    row = np.arange(len(known))
    others = known & ~seen
    before = np.where(others & (row < end[:, None]), row, -1).max(1)
    after = np.where(others & (row > end[:, None]), row, len(row)).min(1)
    return np.stack([before, np.where(after < len(row), after, -1)])
