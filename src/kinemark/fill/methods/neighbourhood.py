"""A marker and those about it as one signal: what PCA and the low-rank Kalman smoother learn from.

The columns of a neighbourhood are the coordinates of K markers less the mean of those of them that are seen in the gap,
frame by frame (1): the walk through the laboratory is taken out, by the same rule in the gap and where it is learnt.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints
from ..known_samples import KnownSamples


class Neighbourhood(NamedTuple):
    """Markers, and the frames from which they are learnt.

    Attributes:
        markers: (K), those seen in the gap first, the marker sought last.
        n_seen: how many are seen in the gap.
        frames: (N) where all are seen, evenly thinned.
        step: the frames are among every `step`-th.
    """

    markers: Ints
    n_seen: int
    frames: Ints
    step: int


def neighbourhood(known: KnownSamples, near: Ints, sought: Ints, *, frames: Ints, least: int) -> Neighbourhood | None:
    """The seen markers `near`, most useful first, with those sought.

    Where fewer than `least` frames show them all, those that cost the most frames are left out, one by one; None where
    fewer than two markers are left, or no frames.
    """
    step = int(frames[1] - frames[0]) if len(frames) > 1 else 1
    base = known.seen[sought[:, None], frames].all(0)
    use, missing = list(near), ~known.seen[near[:, None], frames] & base
    lacking = missing.sum(0)
    while (base & (lacking == 0)).sum() < least and len(use) > 2:
        gained = (missing & (lacking == 1)).sum(1)
        costliest = len(use) - 1 - int(np.argmax(gained[::-1]))
        lacking = lacking - missing[costliest]
        missing = np.delete(missing, costliest, axis=0)
        use.pop(costliest)
    together = base & (lacking == 0)
    if len(use) < 2 or together.sum() < 3:
        return None
    return Neighbourhood(np.array([*use, *sought]), len(use), frames[together], step)


def columns(known: KnownSamples, hood: Neighbourhood, frames: Ints) -> tuple[Floats, Floats]:
    """(1): signals (F, 3 K) in these frames, and the centres (F, 3) taken out."""
    x = known.at(hood.markers, frames[:, None])
    centre = np.einsum("fki->fi", x[:, : hood.n_seen]) / hood.n_seen
    return (x - centre[:, None]).reshape(len(frames), 3 * len(hood.markers)), centre
