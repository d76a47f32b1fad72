"""What other paths show in the moment of a problem.

Two markers that are exchanged both leave their ways at once, three that are turned about all do; where neither is
recognised as the other's partner, each is judged by itself. But a foot that strikes the floor moves many markers at
once as well, each of which tells a little. So of what other paths show within ONCE frames, the likeliest counts as the
part that it is of all that is no error there:

    a = max_j w_j / (1 + Σ_j (1 − w_j))                                                                    (1)

0 where nothing else happens, and up to 1 where all that does is surely wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats

ONCE = 2.0
"""Frames within which is at once; chosen of 0.5 to 3: what is told of each laboratory by the others is least likely
with the shortest, and within a nat with 2 and 3."""


class Moment(NamedTuple):
    """The middle frame of a problem, and the paths that it is about."""

    frame: float
    paths: frozenset[int]


def at_once(wrong: Floats, moments: Sequence[Moment]) -> Floats:
    """(1) of problems (N) that are as likely by themselves."""
    frame = np.array([one.frame for one in moments], np.float64)
    order = np.argsort(frame, kind="stable")
    first = np.searchsorted(frame[order], frame - ONCE, side="left")
    last = np.searchsorted(frame[order], frame + ONCE, side="right")
    out = np.zeros(len(frame))
    for k, one in enumerate(moments):
        beside = order[first[k] : last[k]].tolist()
        others = wrong[[j for j in beside if not one.paths & moments[j].paths]]
        out[k] = others.max(initial=0.0) / (1 + (1 - others).sum())
    return out
