"""How good labels are where the truth is known: samples, ghosts, frames, and whether probabilities are true."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Bools, Ints
from .labels import Labels
from .shredded import Change, Shredded

BINS = (0.0, 0.5, 0.7, 0.9, 0.95, 0.99, 1.0)
"""Bounds of the probabilities that are looked at together; chosen, closer where a name is used."""


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
