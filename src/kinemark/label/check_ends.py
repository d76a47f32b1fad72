"""To the frame, where wrong names begin and end, of stretches that windows have found.

With g(f) the nats that the other names gain in frame f, a stretch begins at the frame s and ends before e that have

    Σ_{f ≥ s} g(f) greatest,   Σ_{f < e} g(f) greatest                                                             (1)

of the frames within a window of where it was found to. Right names lose by the others as much as wrong ones gain, so
that each frame more or less on either side is one that costs.
"""

from __future__ import annotations

import numpy as np

from ..data import Trajectories
from ..data.array_types import Floats
from .evidence import Single
from .exchange import Exchanger, Move
from .template import Template


def ends(
    known: Trajectories, template: Template, exchanger: Exchanger, move: Move, found: tuple[int, int], window: int
) -> tuple[int, int]:
    """First and last-plus-one frame of a stretch by (1).

    Args:
        known: labelled, by names of the template. move: what its labels should change to. found: first and last-plus-
            one frame, from 0, to a window. window: frames.
    """
    first, stop = found
    middle = (first + stop) // 2
    begin = max(first - window, 0), min(first + window, middle)
    end = max(stop - window, middle), min(stop + window, known.n_frames)
    after = _gains(known, template, exchanger, move, begin)[::-1].cumsum()
    before = _gains(known, template, exchanger, move, end).cumsum()
    placed = begin[1] - _most(after), end[0] + _most(before)
    return placed if placed[0] < placed[1] else found


def _most(total: Floats) -> int:
    """How many of n frames have the greatest sum, of sums over 1 … n of them; as few as have it, 0 where all lose."""
    return int(np.argmax(np.r_[0.0, total]))


def _gains(
    known: Trajectories, template: Template, exchanger: Exchanger, move: Move, between: tuple[int, int]
) -> Floats:
    """(n) nats that the move gains in each frame."""
    y = _places(known, template, *between)
    return np.array([exchanger.nats(y[[k]], [move])[0] for k in range(len(y))])


def _places(known: Trajectories, template: Template, first: int, stop: int) -> Single:
    """(stop − first, L, 3) where each label is, about one of the places."""
    xyz = np.full((stop - first, len(template), 3), np.nan)
    for path in known:
        xyz[:, template.names.index(path.name)] = path.xyz[first:stop]
    seen = np.isfinite(xyz[..., 0])
    return (xyz - xyz[seen][:1]).astype(np.float32) if seen.any() else xyz.astype(np.float32)
