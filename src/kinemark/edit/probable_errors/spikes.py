"""Spikes: samples of a path that jump away, and back within SPIKE_S, while it goes on before and after as one.

A foot that strikes the floor jumps as well, where frames are few, and all its markers with it: what is near a path,
and as far from it before as after, carries it meanwhile as a rigid body, unless the path has left it
(`SpikeEvidence.left`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints
from .carried import LEAST_MM, left_mm
from .paths import Ends, Paths, between, ends, meeting
from .probability import of_source, probability

SPIKE_S = 0.15
"""s; chosen: longer than an image that was taken wrongly lasts."""

ALONE = -1.0
"""`SpikeEvidence.left` without companions; chosen: between that of motion and that of spikes."""


class SpikeEvidence(NamedTuple):
    """What tells of a spike.

    Attributes:
        off: ln(1 + χ²/4) of its samples from where the path is by what is before and after, the least of them.
        without: the same of how before goes on in after. times: ln of how many times farther the samples are.
        seconds: ln of their duration, s. rate: ln of the trial's, Hz.
        left: ln of how far the path is from where its companions carry it, as a share of how far the samples are off,
            1 at most.
    """

    off: float
    without: float
    times: float
    seconds: float
    rate: float
    left: float


class Spike(NamedTuple):
    """Samples `first` to `last` (frames from 0) of a path that stand off, by how much, and how likely that is wrong;
    the kind is that of its source (`probability.of_source`)."""

    path: int
    first: int
    last: int
    kind: str
    evidence: SpikeEvidence
    wrong: float
    keep_mm: float
    erase_mm: float


def spikes(paths: Paths) -> list[Spike]:
    """Those of all paths, each sample in one at most, the most telling first."""
    rows = [
        (p, a, b)
        for p, jumps in enumerate(paths.jumps)
        for k, a in enumerate(jumps.tolist())
        for b in jumps[k + 1 :].tolist()
        if paths.frames[p][b] - paths.frames[p][a] <= SPIKE_S * paths.rate
    ]
    if not rows:
        return []
    p, a, b = (np.array(column, np.int64) for column in zip(*rows, strict=True))
    before, after = ends(paths, p, a, -1), ends(paths, p, b + 1, 1)
    rest = meeting(before, after, paths.rate, paths.q)
    without = np.log1p(rest.squared / 4)
    off, squared = _standing_off(paths, p, a, b, before, after)
    found = []
    for n in range(len(p)):
        own = paths.frames[p[n]]
        first, last = int(own[a[n] + 1]), int(own[b[n]])
        times = float(np.log((off[n] + LEAST_MM) / (rest.off[n] + LEAST_MM)))
        seconds = float(np.log((last - first + 1) / paths.rate))
        evidence = SpikeEvidence(
            float(np.log1p(squared[n] / 4)),
            float(without[n]),
            times,
            seconds,
            float(np.log(paths.rate)),
            _left(paths, int(p[n]), int(own[a[n]]), int(own[b[n] + 1]), float(off[n])),
        )
        kind = of_source("spike", bool(paths.images[p[n], first : last + 1].any()))
        wrong = probability(kind, evidence)
        found.append(Spike(int(p[n]), first, last, kind, evidence, wrong, float(off[n]), float(rest.off[n])))
    return _apart(found)


def _standing_off(paths: Paths, p: Ints, a: Ints, b: Ints, before: Ends, after: Ends) -> tuple[Floats, Floats]:
    """(N) how far the first, the middle or the last sample is off at least, mm, and its χ²."""
    off, squared = [], []
    for index in (a + 1, (a + b + 1) // 2, b):
        frame = np.array([paths.frames[k][i] for k, i in zip(p, index, strict=True)])
        place, variance = between(before, after, frame.astype(np.float64), paths.rate, paths.q)
        d = np.linalg.norm(paths.xyz[p, frame] - place, axis=1)
        off.append(d)
        squared.append(d**2 / (variance + paths.sd[p] ** 2))
    return np.min(off, axis=0), np.min(squared, axis=0)


def _left(paths: Paths, p: int, before: int, after: int, off: float) -> float:
    """`SpikeEvidence.left` of samples between two frames that are so far off, mm."""
    frames = paths.frames[p]
    middle = int(frames[np.searchsorted(frames, (before + after) / 2)])
    change = left_mm(paths, p, min(middle, after - 1), before, after)
    return ALONE if np.isnan(change) else float(min(np.log((change + LEAST_MM) / (off + LEAST_MM)), 0.0))


def _apart(found: list[Spike]) -> list[Spike]:
    """Of those that share samples the likeliest."""
    kept: list[Spike] = []
    for one in sorted(found, key=lambda spike: -spike.wrong):
        if not any(one.path == k.path and one.first <= k.last + 1 and k.first <= one.last + 1 for k in kept):
            kept.append(one)
    return kept
