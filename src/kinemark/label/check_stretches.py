"""Labelled trials checked for stretches whose name is wrong: what is called so is another marker, or none.

In windows of half a second the mean evidence e(a) of what is called a, by the four names that tell most of it there
((1) of `sweeps`), is below 0 where most of them say that it is none. Names farther off tell little of a marker, and all
of them together would outvote those of its own segment. A wrong marker spoils the evidence of its neighbours too, so
that the worst is set aside before the others are judged anew. What it may be instead is told where a name that is free
there fits it well.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..data import Trajectories
from ..data.array_types import Floats, Ints
from ..data.progress import tell
from ..numerics.vectors import lengths
from .check import WINDOW_S
from .evidence import PairScore, Single
from .stretches import stretches_of
from .sweeps import places
from .template import Template

LEAST_TOLD = 8.0
"""Nats that the neighbours must be able to tell of a marker for it to be judged, a frame; chosen: two rigid pairs."""
WRONG = 0.0
"""Evidence below which a name is wrong, as a share of what the template expects; chosen: no name is better."""
INSTEAD = 0.5
"""Evidence from which on a free name is told instead, as a share of what is expected; chosen."""
PEERS = 4
"""Names that judge a marker, and by which it is told how far it is off; chosen: as many as a segment has."""


class Mislabelled(NamedTuple):
    """A marker that is called otherwise than it should be.

    Attributes:
        marker: what it is called. first, stop: first and last-plus-one frame, from 0.
        evidence: nats a frame for its name, below 0; expected: what the template expects where a name is right.
        off_mm: median by which its distances to its steadiest neighbours are off.
        instead: the name that fits; None where none that is free does.
    """

    marker: str
    first: int
    stop: int
    evidence: float
    expected: float
    off_mm: float
    instead: str | None


def find_mislabelled(
    trajectories: Trajectories, template: Template, *, besides: Mapping[str, Ints] | None = None
) -> tuple[Mislabelled, ...]:
    """Stretches of a labelled trial whose name is wrong, in the order of time.

    Args:
        trajectories: labelled. template: of the subject.
        besides: marker → frames in which it is known to be exchanged, and not said again.
    """
    known = trajectories.select([name for name in template.names if name in trajectories.names])
    if len(known) < 4:
        return ()
    pairs = PairScore.of_template(template)
    stretches = stretches_of(known, template.size)
    y = places(stretches, np.array([template.names.index(name) for name in known.names]), len(template))
    for name, frames in (besides or {}).items():
        y[np.isin(stretches.frame, frames), template.names.index(name)] = np.nan
    window = stretches.frame // max(1, round(WINDOW_S * trajectories.rate))
    found = []
    for part in (parts := np.unique(window)):
        tell(int(part), int(parts[-1]))
        rows = np.flatnonzero(window == part)
        found += _in_window(y[rows].copy(), template, pairs, stretches.frame[rows])
    return _merged(found, round(2 * WINDOW_S * trajectories.rate))


def _in_window(y: Single, template: Template, pairs: PairScore, frame: Ints) -> list[Mislabelled]:
    """The worst first, each set aside before the next is looked for."""
    found = []
    for _ in range(len(template)):
        own, expected = _evidence(y, pairs)
        share = np.where(expected > LEAST_TOLD, own / np.maximum(expected, 1e-9), np.inf)
        worst = int(share.argmin())
        if share[worst] >= WRONG:
            break
        rows = np.flatnonzero(np.isfinite(y[:, worst, 0]))
        said = Mislabelled(
            template.names[worst], int(frame[rows[0]]), int(frame[rows[-1]]) + 1, float(own[worst]),
            float(expected[worst]), _off(y, worst, template), _instead(y, worst, template, pairs),
        )  # fmt: skip
        found.append(said)
        y[:, worst] = np.nan
    return found


def _evidence(y: Single, pairs: PairScore) -> tuple[Floats, Floats]:
    """(L) mean nats of each label by those that tell most, and what is expected of as many; 0 for absent labels."""
    L = y.shape[1]
    every = np.arange(L)
    d = lengths(y[:, :, None] - y[:, None])
    there = np.isfinite(d)
    n = np.maximum(np.isfinite(y[..., 0]).sum(0), 1)
    told = pairs.expected * there.sum(0) / n[:, None]
    peers = told >= np.sort(told, axis=1)[:, [-PEERS]]
    own = np.where(peers, pairs.at(d, every[:, None], every[None]).sum(0), 0.0).sum(1) / n
    expected = np.where(peers, told, 0.0).sum(1)
    return own.astype(np.float64), np.where(np.isfinite(y[..., 0]).any(0), expected, 0.0)


def _off(y: Single, a: int, template: Template) -> float:
    """Median over its steadiest neighbours and the frames, mm."""
    there = np.isfinite(y[..., 0]).any(0)
    spread = np.where(there & np.isfinite(template.distance[a]), template.spread[a], np.inf)
    spread[a] = np.inf
    near = [int(b) for b in np.argsort(spread, kind="stable")[:PEERS] if np.isfinite(spread[b])]
    d = np.linalg.norm(y[:, [a]] - y[:, near], axis=-1)
    off = np.abs(d - template.distance[a, near])
    return round(float(np.nanmedian(off)), 1) if np.isfinite(off).any() else float("nan")


def _instead(y: Single, a: int, template: Template, pairs: PairScore) -> str | None:
    """The free name that fits best, if one does."""
    free = np.flatnonzero(~np.isfinite(y[..., 0]).any(0))
    best, told = None, 0.0
    for b in free.tolist():
        other = y.copy()
        other[:, b], other[:, a] = y[:, a], np.nan
        own, expected = _evidence(other, pairs)
        if expected[b] > LEAST_TOLD and own[b] > max(INSTEAD * expected[b], told):
            best, told = template.names[b], float(own[b])
    return best


def _merged(found: list[Mislabelled], near: int) -> tuple[Mislabelled, ...]:
    """Neighbouring windows of the same marker as one."""
    out: list[Mislabelled] = []
    for one in found:
        k = next((k for k, old in enumerate(out) if old.marker == one.marker and one.first - old.stop < near), None)
        if k is None:
            out.append(one)
            continue
        old = out[k]
        n, m = old.stop - old.first, one.stop - one.first
        evidence, expected, off = ((n * x + m * z) / (n + m) for x, z in zip(old[3:6], one[3:6], strict=True))
        out[k] = Mislabelled(one.marker, old.first, one.stop, evidence, expected, off, old.instead or one.instead)
    return tuple(sorted(out, key=lambda one: (one.first, one.marker)))
