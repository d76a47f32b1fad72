"""How much better a track's label is than what else it could be, and the probability that follows.

A track t with label a could be b. Where another track u seen at the same time is b, both would have to change, so that
what u loses counts too:

    m_t = min over b of  e(t, a) − e(t, b) + [ e(u, b) − max(e(u, a), 0) ]                                        (1)

and b may be "none", worth 0. All through the trial, exchanges of whole labels must lose as well: x_a is the least that
an exchange with a loses (`exchange` (1)). Pairs are not independent, so that neither is a logarithm of odds. The odds
are measured: with f = e(t, a) over what the template expects, F the same of the whole trial, and w independent frames,

    logit p = β · (1, log(1 + m), log(1 + x), min(f, 1), log w, min(F, 1))                                        (2)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Floats, Ints
from .evidence import PairScore
from .exchange import FRAMES, Exchanger
from .stretches import Stretches
from .sweeps import evidence, expectation, places
from .template import Template

BETA = (-9.4, 0.53, 0.80, 3.26, 0.80, 6.9)
"""Of (2); measured by benchmarks/labelling.py --fit on the rows that it says were tuned on."""


class Margins(NamedTuple):
    """Of T tracks: m, x (nats), f; the runner-up's label, −1 for none; NaN and −1 for tracks without label; F."""

    track: Floats
    exchange: Floats
    fit: Floats
    runner_up: Ints
    trial_fit: float


def margins(stretches: Stretches, label: Ints, template: Template, pairs: PairScore, trial_fit: float) -> Margins:
    """Of each track with a label."""
    nats = evidence(stretches, label, pairs)
    named = np.flatnonzero(label >= 0)
    apart = _overlap(stretches, label, named, nats)
    fit = np.full(len(label), np.nan)
    expected = np.maximum(expectation(stretches, label, pairs), 1e-9)
    fit[named] = nats[named, label[named]] / expected[label[named]]
    track, runner_up = np.full(len(label), np.nan), np.full(len(label), -1)
    rest = np.concatenate([apart, nats[named, label[named]][:, None]], axis=1)
    rest[np.arange(len(named)), label[named]] = np.inf
    second = rest.argmin(1)
    track[named] = rest[np.arange(len(named)), second]
    runner_up[named] = np.where(second == nats.shape[1], -1, second)
    whole = _exchanges(stretches, label, template, pairs)
    exchange = np.full(len(label), np.nan)
    exchange[named] = whole[label[named]]
    return Margins(track, exchange, fit, runner_up, trial_fit)


def _overlap(stretches: Stretches, label: Ints, named: Ints, nats: Floats) -> Floats:
    """(n, L) the margin (1) of named tracks against each label."""
    own = nats[named, label[named]]
    apart = own[:, None] - nats[named]
    seen = stretches.seen[named].astype(np.float32)
    together = seen @ seen.T > 0
    np.fill_diagonal(together, False)
    for i, j in zip(*np.nonzero(together), strict=True):  # u = j holds b = label of j
        lost = own[j] - max(nats[named[j], label[named[i]]], 0.0)
        b = label[named[j]]
        apart[i, b] = max(apart[i, b], own[i] - nats[named[i], b] + max(lost, 0.0))
    return apart


def _exchanges(stretches: Stretches, label: Ints, template: Template, pairs: PairScore) -> Floats:
    """(L) the least that an exchange with each label loses, nats; a large number where there is none."""
    exchanger = Exchanger.of(template, pairs)
    y = places(stretches, label, len(template))
    y = y[np.unique(np.linspace(0, len(y) - 1, min(len(y), FRAMES)).round().astype(int))]
    lost = np.full(len(template), np.inf)
    for move, gain in zip(exchanger.twos, exchanger.gains(y, exchanger.twos), strict=True):
        lost[list(move[0])] = np.minimum(lost[list(move[0])], -gain)
    return np.where(np.isfinite(lost), np.maximum(lost, 0.0), 0.0)


def features(found: Margins, weight: Floats) -> Floats:
    """(T, 6) of (2)."""
    ones = np.ones(len(weight))
    track, exchange = (np.log1p(np.maximum(part, 0.0)) for part in (found.track, found.exchange))
    return np.stack(
        [ones, track, exchange, np.clip(found.fit, -1.0, 1.0), np.log(weight), ones * min(found.trial_fit, 1.0)], axis=1
    )


def probability(found: Margins, weight: Floats, beta: NDArray[np.float64] | tuple[float, ...] = BETA) -> Floats:
    """(T) by (2); 0 for tracks without label."""
    logit = features(found, weight) @ np.asarray(beta)
    return np.where(np.isfinite(logit), 1 / (1 + np.exp(-np.clip(np.nan_to_num(logit), -30, 30))), 0.0)
