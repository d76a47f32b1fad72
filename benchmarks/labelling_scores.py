"""How good labels are where the truth is known: samples, ghosts, frames, whether probabilities are true, and how well
tracks that go over from one marker to another were found and cut."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from labelling_shredded import Change, Shredded
from numpy.typing import NDArray

from kinemark.data.array_types import Bools, Ints
from kinemark.label import Labels
from kinemark.label.switching import CutLabels

BINS = (0.0, 0.5, 0.7, 0.9, 0.95, 0.99, 1.0)
"""Bounds of the probabilities that are looked at together; chosen, closer where a name is used."""
WITHIN = 5
"""Frames by which a cut may be off; chosen."""


class LabelScore(NamedTuple):
    """A name that is not sure counts as none, save in `best_right` and `best_wrong`.

    Attributes:
        right, wrong, unsure: shares of the samples of markers that the template knows; their sum is 1.
        ghosts: share of all other samples that have a name: of ghosts, and of markers that the template does not know.
        best_right, best_wrong: right and wrong if all names were taken, sure or not.
        frames: share of the frames in which each such marker has its name, and nothing else has one.
        sure_wrong: share of the sure tracks that are not what they are called, all through.
        probability, good, samples: of each named track: that it is right, whether it is all through, and how long.
    """

    right: float
    wrong: float
    unsure: float
    ghosts: float
    best_right: float
    best_wrong: float
    frames: float
    sure_wrong: float
    probability: NDArray[np.float64]
    good: Bools
    samples: Ints


class Reliability(NamedTuple):
    """Names whose probability is from `low` to below `high`: how many, what it is in the mean, how many are right."""

    low: float
    high: float
    names: int
    probability: float
    right: float
    samples_right: float


def score_labels(labels: Labels, truth: Shredded, known: Sequence[str]) -> LabelScore:
    """Labels of shredded tracks against what the tracks are.

    Args:
        labels: of `truth.tracks`.
        known: names of the template; none where it is of something else, so that every name is wrong.

    Raises:
        ValueError: there are other numbers of labels than of tracks.
    """
    if len(labels) != len(truth.truth):
        raise ValueError(f"there are {len(labels)} labels and {len(truth.truth)} tracks, wanted one each")
    seen = np.isfinite(truth.tracks.xyz[..., 0])
    real, good = _samples(labels, truth, set(known), seen)
    has = np.array([name is not None for name in labels.names], bool)
    sure = np.array([state == "sure" for state in labels.state], bool)
    wrong, n, others = seen & has[:, None] & ~good, max(int(real.sum()), 1), seen & ~real
    right = float(good[sure].sum()) / n
    off = float((wrong & real)[sure].sum()) / n
    whole = good.sum(1) == seen.sum(1)
    frames = (good[sure].sum(0) == real.sum(0)) & ~wrong[sure].any(0)
    return LabelScore(
        right, off, 1 - right - off,
        float((others & has[:, None])[sure].sum()) / max(int(others.sum()), 1),
        float(good.sum()) / n, float((wrong & real).sum()) / n,
        float(frames.mean()) if len(frames) else 1.0,
        float((sure & ~whole).sum()) / max(int(sure.sum()), 1),
        labels.probability[has], whole[has], seen.sum(1)[has],
    )  # fmt: skip


def _samples(labels: Labels, truth: Shredded, known: set[str], seen: Bools) -> tuple[Bools, Bools]:
    """(T, F) samples of markers that are known, and those of them that have their name."""
    real, good = np.zeros_like(seen), np.zeros_like(seen)
    for t, (name, first) in enumerate(zip(labels.names, truth.truth, strict=True)):
        for change in (Change(0, first), *truth.changes.get(t, ())):
            real[t, change.frame :] = change.marker in known
            good[t, change.frame :] = change.marker in known and change.marker == name
    return real & seen, good & seen


def reliability(scores: Sequence[LabelScore], bins: Sequence[float] = BINS) -> tuple[Reliability, ...]:
    """How often names are right by their probability, over all scores; bins without names are left out."""
    p, good, n = (np.concatenate([getattr(one, key) for one in scores]) for key in ("probability", "good", "samples"))
    out = []
    for low, high in pairwise(bins):
        own = (p >= low) & ((p < high) | (high >= 1))
        if own.any():
            by_sample = float((good[own] * n[own]).sum() / max(n[own].sum(), 1))
            out.append(Reliability(low, high, int(own.sum()), float(p[own].mean()), float(good[own].mean()), by_sample))
    return tuple(out)


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
