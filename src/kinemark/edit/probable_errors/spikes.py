"""Spikes: samples of a path that jump away, and back within SPIKE_S, while it goes on before and after as one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .paths import Paths, ends, meeting
from .probability import probability

SPIKE_S = 0.15
"""s; chosen: longer than an image that was taken wrongly lasts."""


class SpikeEvidence(NamedTuple):
    """ln(1 + χ²/4) of the lesser of both jumps; of what is left without the samples; ln of seconds."""

    jump: float
    without: float
    seconds: float


class Spike(NamedTuple):
    """Samples `first` to `last` (frames from 0) of a path that stand off, by how much, and how likely they are wrong."""

    path: int
    first: int
    last: int
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
    away = meeting(ends(paths, p, a, -1), ends(paths, p, a + 1, 1), paths.rate, paths.q)
    back = meeting(ends(paths, p, b, -1), ends(paths, p, b + 1, 1), paths.rate, paths.q)
    rest = meeting(ends(paths, p, a, -1), ends(paths, p, b + 1, 1), paths.rate, paths.q)
    jump = np.log1p(np.fmin(away.squared, back.squared) / 4)
    without = np.log1p(rest.squared / 4)
    found = []
    for n in range(len(p)):
        own = paths.frames[p[n]]
        first, last = int(own[a[n] + 1]), int(own[b[n]])
        evidence = SpikeEvidence(float(jump[n]), float(without[n]), float(np.log((last - first + 1) / paths.rate)))
        keep = float(np.fmax(away.off[n], back.off[n]))
        found.append(Spike(int(p[n]), first, last, evidence, probability("spike", evidence), keep, float(rest.off[n])))
    return _apart(found)


def _apart(found: list[Spike]) -> list[Spike]:
    """Of those that share samples the likeliest."""
    kept: list[Spike] = []
    for one in sorted(found, key=lambda spike: -spike.wrong):
        if not any(one.path == k.path and one.first <= k.last + 1 and k.first <= one.last + 1 for k in kept):
            kept.append(one)
    return kept
