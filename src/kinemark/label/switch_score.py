"""How well tracks that go over from one marker to another were found and cut, where the truth is known."""

from __future__ import annotations

from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from .shredded import Change, Shredded
from .switching import CutLabels

WITHIN = 5
"""Frames by which a cut may be off; chosen."""


class SwitchScore(NamedTuple):
    """Changes of marker that were cut to within some frames, all that there are, and cuts where there is none."""

    found: int
    of: int
    false: int


def score_switches(found: CutLabels, truth: Shredded, *, within: int = WITHIN) -> SwitchScore:
    """The cuts of shredded tracks against their changes, frames off at most `within`."""
    changes = [(t, change.frame) for t, own in truth.changes.items() for change in own]
    cuts = [(one.track, one.frame) for one in found.switches]

    def hit(one: tuple[int, int], others: list[tuple[int, int]]) -> bool:
        return any(one[0] == t and abs(one[1] - frame) <= within for t, frame in others)

    n, wrong = (sum(hit(one, b) for one in a) for a, b in ((changes, cuts), (cuts, changes)))
    return SwitchScore(n, len(changes), len(cuts) - wrong)


def cut_truth(found: CutLabels, truth: Shredded) -> Shredded:
    """What the pieces are that tracks were cut into, for `score_labels`."""
    seen = np.isfinite(found.tracks.xyz[..., 0])
    first, changes = [], {}
    for p, t in enumerate(found.of.tolist()):
        own = np.flatnonzero(seen[p])
        start, last = (int(own[0]), int(own[-1])) if len(own) else (0, 0)
        all_of = (Change(0, truth.truth[t]), *truth.changes.get(t, ()))
        first.append([change.marker for change in all_of if change.frame <= start][-1])
        if inside := tuple(change for change in all_of if start < change.frame <= last):
            changes[p] = inside
    return Shredded(found.tracks, tuple(first), MappingProxyType(changes))
