"""Why a name is not sure: which neighbours speak against it and for the runner-up."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data.array_types import Floats, Ints
from ..numerics.vectors import lengths
from .evidence import PairScore, Single
from .stretches import Stretches
from .sweeps import places
from .template import Template

MOST = 3
"""Neighbours that are said; chosen."""
LEAST = 0.5
"""Nats a frame below which a neighbour says nothing; chosen."""

Against = tuple[tuple[str, float], ...]
"""Markers and by how many nats a frame each speaks for the runner-up, the most first."""


def against(
    stretches: Stretches,
    label: Ints,
    runner_up: Ints,
    template: Template,
    pairs: PairScore,
    wanted: Sequence[bool],
) -> tuple[Against, ...]:
    """(T) of the tracks that are wanted and have a runner-up; empty for others.

    For track t, called a, with b the runner-up ("none" is worth 0), a neighbour n speaks by the mean over the frames
    ‹ l_bn(d) − l_an(d) › with l of `evidence` (1).
    """
    y = places(stretches, label, len(template))
    out: list[Against] = [()] * len(label)
    for t in np.flatnonzero(np.asarray(wanted, bool) & (label >= 0)):
        nats = _speaking(stretches.xyz[t], y, int(label[t]), int(runner_up[t]), pairs)
        first = np.argsort(-nats, kind="stable")[:MOST]
        out[t] = tuple((template.names[n], round(float(nats[n]), 2)) for n in first if nats[n] >= LEAST)
    return tuple(out)


def _speaking(xyz: Single, y: Single, a: int, b: int, pairs: PairScore) -> Floats:
    """(L) nats for b rather than a, by each neighbour; 0 by those two themselves and by those never seen with it."""
    rows = np.flatnonzero(np.isfinite(xyz[:, 0]))
    d = lengths(y[rows] - xyz[rows, None])
    every = np.arange(y.shape[1])
    own = pairs.at(d, np.array(a), every)
    other = pairs.at(d, np.array(b), every) if b >= 0 else np.zeros_like(own)
    seen = np.isfinite(d)
    nats = (np.where(seen, other - own, 0.0)).sum(0) / np.maximum(seen.sum(0), 1)
    nats[[a] if b < 0 else [a, b]] = 0.0
    return np.asarray(nats, np.float64)
