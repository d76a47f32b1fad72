"""How much better a track's label is than what else it could be, and the probability that follows.

A name is right when two things hold: what is called a all through the trial is a, and this track is one of it.

    p = p_label(a) · p_track(t)                                                                                   (1)

*The track.* A track t with label a could be b. Where another track u seen at the same time is b, both would have to
change, so that what u loses or gains counts too:

    m_t = min over b of  e(t, a) − e(t, b) + [ e(u, b) − max(e(u, a), 0) ]                                        (2)

where what u gains, seen for n_u frames to n_t, counts min(1, n_u / n_t) times, and b may be "none", worth 0, also
where u takes a instead, from b or no name:

    m_t ≤ e(t, a) − min(1, n_u / n_t) [ e(u, a) − max(e(u, b), 0) ]                                              (2')

e is of what is known of the subject after the trial (`pool`), as pieces of a marker are
judged by the others. With f_t = e(t, a) over what is expected, f_a the same of all tracks that are a, w independent
frames, c how much better the track goes on from others that are a than from any other label's, F the fit of the
frames that it is in, and N markers on the body without a name, any of which a piece may be of,

    logit p_track = β · (1, log(1 + m), f_t, f_t − f_a, log w, log(1 + c), F, −log(1 + N), N = 0) + δ            (3)

δ is measured on the trial itself (`calibration`). The β of pieces, which have less than half of their label's samples,
by the subject's own template are others: a label is right where most of its samples are, so that a track that has most
of them is right where its label is.

*The label.* A whole label exchanged all through the trial is invisible to its pieces. Exchanges must lose: x is the
least that one with a loses (`exchange` (1), at most five times `told_by_one` (1) where no
distance that keeps tells both apart), or that a loses to a marker without name (`claims` (1)); where x is 0,
or below it by another subject's template, the other way round is as likely. Chains of labels that
have all moved up one place end at one that fits badly, or at a piece of a marker, so that the worst fit f_n of the four
nearest labels and the share n of the frames in which a is seen, of those in which the best seen is, count as well. All
of it is by the template as it was given, as what is known after the trial was learnt from these very labels:

    p_label = logistic(k x) · logistic(3 (e_a − 2))
        · logistic(β · (1, log(1 + x), f_a, f_n, F, log n, log(1 + y), h, f', h', f_n', r, log W, s > 0, s > 1,
                        (h − 1) log(1 + N)))                                                                      (4)

with y the loss by `rivals` (1), W the independent frames in which a is seen, and h how well the four stiffest distances
hold (`held`); the β of another subject's template are others. An extra marker that took the name of an absent one fits
fairly, but worse than the trial's others do, and its stiffest distances are off: f' and h' are what f_a and h lack of
their medians over all labels, and f_n' what f_n lacks of one half. r is 1 where the template knows a distance of the
label that keeps, as to a marker of the same segment, and 0 where all its distances change, as of a static trial without
segments. Names that moved up one place end at a label that is absent and begin at a marker without name: s is 2 where
the trial has neither (`left_over`), 1 where it has but one of the two, 0 where it has both. Of N markers on the body
without a name, the more there are the likelier one of them lies where the label belongs, fairly and not quite: what the
stiffest distances lack of holding counts for more there. Of a part of the body that is absent ghosts take the names,
and nothing that is seen tells against it, nor for it: e_a, nats a frame of all tracks that are a, is less than one
distance that keeps tells.

Pairs are not independent, so that none of these is a logarithm of odds: all β are
measured, over many templates and trials (`benchmarks/labelling_shreds.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Bools, Floats, Ints
from ..numerics.evenly import evenly_rounded
from .anatomy import Anatomy
from .claims import left_over, lost_to_claims
from .evidence import PairScore, Single, frame_fit
from .exchange import FRAMES, Exchanger
from .held import stiffness_kept
from .rivals import lost_to_rivals
from .stretches import Stretches, together
from .sweeps import continuity, evidence, expectation, places
from .template import Template
from .told_by_one import TIMES, told_by_none, told_by_one

BETA_TRACK = (-3.21, 1.48, 2.15, 2.23, 1.66, 1.05, 0.84, 0.0, 0.0)
"""Of (3); logits; measured on the rows of benchmarks/labelling_cases.py that are tuned on, each shredded in two ways,
then all times 1.25, less 0.2, by 234 random shreds of 0.4 to 5 s of walks and static trials' templates: with (2') more
tracks were right than these said. Of 56 700 tracks of right labels by another subject's template 11 are wrong where 8
are expected."""
BETA_PIECE = (-2.31, 1.41, 0.38, 0.0, 0.0, 0.91, 2.56, 0.61, 1.0)
"""The same of pieces, by the subject's own template; measured on 116 000 of right labels: of random shreds
(benchmarks/labelling_shreds.py from 80000 to 85044 and from 210000 on), 26 more in 25 to 60 pieces, and the rows of
benchmarks/labelling.py. By the others pieces beside nameless markers were wrong three times as often as was said, and
of those beside none or one that were 0.9 to 0.99 likely none of 294 was wrong. The last was measured on 24 526 more of
120 shreds, beside none: 2 were wrong where 31 were expected, and of 266 from 0.9 to 0.995 none of 4.7; chosen at the
lower end of what these allow, as errors come many in a shred."""
MOST_OF_LABEL = 0.5
"""Share of its label's samples from which on a track is no piece; by definition of a label that is right."""
BETA_LABEL = (-1.57, 0.34, 1.28, 0.0, 0.0, 3.11, 1.54, 2.44, 0.0, 11.86, 0.0, 3.18, 0.92, 0.45, 0.03, 1.19)
"""Of (4), of the subject's own template; logits; measured by benchmarks/labelling_shreds.py on 10 658 labels of random
shreds of walks' and static trials' templates; none but the first below 0, as what fits better makes no name less
sure. The last alone was measured on 14 400 labels of 325 shreds more, 192 of them crowded: sure names were wrong there
five times as often as p_label said."""
BETA_OTHER = (-4.27, 0.0, 0.0, 1.00, 0.0, 3.27, 2.24, 4.33, 1.45, 0.63, 0.0, 0.03, 0.0, 1.54, 3.00, 0.0)
"""Of (4), of another subject's template; logits; measured in the same way on 10 681 labels. The first and the last were
-3.82 and 1.39, and were measured anew on 5 655 labels of 104 further shreds: of 1 014 labels from 0.9 to 0.999
seventeen were wrong where eight were expected, and none of 2 026 where nothing is left over. With 40 more shreds the
first would be -4.3 (-4.8 to -3.8). The last is 0 also as measured, on 132 shreds."""
GAINED, LOST = 0.25, 2.0
"""k of (4), 1/nats, where an exchange gains and where it loses; measured on the same 109 shreds: of static trials most
names that an exchange would gain by are right."""
GAINED_OTHER = 0.0
"""The same where an exchange gains by another subject's template, as a marker that sits elsewhere changes all its
distances alike; measured on 127 shreds: 22 of 33 such names were right, of those by 10 nats and more 7 of 11."""
TOLD, TOLD_SLOPE = 2.0, 3.0
"""Nats a frame of e_a below which a name is of nothing, and by how many logits a nat; chosen on legs and upper bodies
alone of three children: right names are told by 5.2 nats and more, eight of twelve wrong ones from 0.5 on by less than
3.3; of one leg alone by a posture of 15 markers, where no distance is known to keep, right ones by 1.6 to 5."""
CHAIN_END = 0.5
"""Fit of a near label below which a chain of names may end at it; measured on the same shreds: one in ten right names
of other children, and half of the wrong ones, are near such a label."""
NEAR = 4
"""Nearest labels whose fit counts for a label; chosen."""
LEAST_EXPECTED = 5.0
"""Nats that a fit is a share of, at least, as one distance that keeps tells; chosen: a ghost on the place of a part of
the body that is absent, of whose distances to the rest the template expects nothing, fitted a thousand million times.
"""
FIT_HIGH = 1.3
"""Fits above it tell no more than it; chosen, a third above what the template expects."""
MOST_POSES = 11.0
"""Of W; chosen: five seconds, longer trials were not measured."""
MOST_NATS = 500.0
"""Margins above it tell no more than it; chosen."""


class Margins(NamedTuple):
    """Of T tracks; NaN, and −1, for tracks without label.

    Attributes:
        track: m, nats a frame. runner_up: the label that comes second, −1 for none. fit: f_t. beside: f_t − f_a.
        link: c, nats. exchange: x. label_fit: f_a. near_fit: f_n. present: n. frame_fit: F.
        rival: y. stiff: h. poses: W.
        fit_beside, stiff_beside: f_a and h less their medians of all labels that are there. rigid: r.
        shut: s. nameless: N. told: e_a.
        share: of its label's samples, those of the track.
        proofs: how many of a's stiffest distances are seen, in the mean. absent: how many labels no marker has.
    """

    track: Floats
    runner_up: Ints
    fit: Floats
    beside: Floats
    link: Floats
    exchange: Floats
    label_fit: Floats
    near_fit: Floats
    present: Floats
    frame_fit: Floats
    rival: Floats
    stiff: Floats
    poses: Floats
    fit_beside: Floats
    stiff_beside: Floats
    rigid: Floats
    shut: Floats
    nameless: Floats
    told: Floats
    proofs: Floats
    absent: Floats
    share: Floats


def margins(
    stretches: Stretches,
    label: Ints,
    template: Template,
    pairs: PairScore,
    after: PairScore | None = None,
    *,
    exchanges: bool = True,
) -> Margins:
    """Of each track with a label, by the template's `pairs` and by what is known `after` the trial, where it is given.

    x, y and s, which (3) does not need, are those of no other name without exchanges, and N is 1.
    """
    y, L = places(stretches, label, len(template)), len(template)
    t = np.flatnonzero(label >= 0)
    a = label[t]
    given = evidence(stretches, label, pairs)
    label_fit, present = _of_labels(stretches, t, a, _share(given, stretches, label, pairs), L)
    told, _ = _of_labels(stretches, t, a, given[t, a], L)
    nats, share, own_fit = given, _share(given, stretches, label, pairs), label_fit
    if after is not None:
        nats = evidence(stretches, label, after)
        share = _share(nats, stretches, label, after)
        own_fit, _ = _of_labels(stretches, t, a, share, L)
    some = y[evenly_rounded(len(y), FRAMES)]
    lost = _exchanges(some, template, pairs, stretches.fixed) if exchanges else np.zeros(L)
    rival = lost_to_rivals(stretches, label, template, pairs) if exchanges else np.zeros(L)
    lost = np.minimum(lost, lost_to_claims(stretches, label, given)) if exchanges else lost
    least, second = _second(stretches, t, a, nats, label)
    (stiff, proofs), there = stiffness_kept(some, pairs, template.keeps), np.unique(a)
    over = np.array(left_over(stretches, label, L) if exchanges else (1, 1))
    found = Margins(
        least, second, share, share - own_fit[a], _goes_on(stretches, label, L)[t], lost[a],
        label_fit[a], _worst_near(template, label_fit)[a], present[a],
        _fit_meanwhile(stretches, t, y, pairs), rival[a],
        stiff[a], _poses(stretches, t, a, L)[a], _beside(label_fit, there)[a], _beside(stiff, there)[a],
        template.keeps.any(1).astype(float)[a], np.full(len(t), (over == 0).sum(), float),
        np.full(len(t), float(over[1])), told[a], proofs[a], np.full(len(t), float(over[0])),
        _of_its_label(stretches, t, a, L),
    )  # fmt: skip
    runner_up = np.full(len(label), -1)
    runner_up[t] = second
    full = {name: _of_all(part, t, len(label)) for name, part in found._asdict().items() if name != "runner_up"}
    return Margins(runner_up=runner_up, **full)


def _of_its_label(stretches: Stretches, t: Ints, a: Ints, L: int) -> Floats:
    """(n) share of the samples of labels a that tracks t have."""
    n = stretches.seen[t].sum(1)
    return np.asarray(n / np.maximum(np.bincount(a, n, L)[a], 1.0))


def _poses(stretches: Stretches, t: Ints, a: Ints, L: int) -> Floats:
    """(L) independent frames of all tracks t that are labels a."""
    return np.asarray(1.0 + np.bincount(a, stretches.weight[t] - 1.0, L), float)


def _goes_on(stretches: Stretches, label: Ints, L: int) -> Floats:
    """(T) nats by which a track goes on from its label's others, more than from those of any other label."""
    nats, every, of = continuity(stretches, label, L), np.arange(len(label)), np.maximum(label, 0)
    own = nats[every, of]
    nats[every, of] = 0.0
    return np.asarray(own - nats.max(1, initial=0.0))


def _beside(values: Floats, there: Ints) -> Floats:
    """(L) less the median of the labels that are there."""
    return values - (float(np.median(values[there])) if len(there) else 0.0)


def _share(nats: Floats, stretches: Stretches, label: Ints, pairs: PairScore) -> Floats:
    """(n) of the tracks with a label, evidence over what is expected."""
    t = np.flatnonzero(label >= 0)
    return np.asarray(nats[t, label[t]] / np.maximum(expectation(stretches, label, pairs)[t, label[t]], LEAST_EXPECTED))


def _of_all(part: NDArray[np.generic], t: Ints, T: int) -> Floats:
    """(T) from those of tracks t; NaN elsewhere."""
    out = np.full(T, np.nan)
    out[t] = part
    return out


def _second(stretches: Stretches, t: Ints, a: Ints, every: Floats, label: Ints) -> tuple[Floats, Ints]:
    """(n) the margins (2) and (2') of tracks t with labels a, the less, and the label that is second."""
    nats = every[t]
    own = nats[np.arange(len(t)), a]
    apart = own[:, None] - nats
    meet, n = together(stretches.seen), stretches.seen[t].sum(1)
    i, j = np.nonzero(meet[np.ix_(t, t)])  # u = j holds b, the label of j
    lost = own[j] - np.maximum(nats[j, a[i]], 0.0)
    lost = np.maximum(lost, np.minimum(1.0, n[j] / n[i]) * lost)  # what u gains counts by its frames
    both = np.full_like(apart, -np.inf)
    np.maximum.at(both, (i, a[j]), own[i] - nats[i, a[j]] + lost)
    none = np.minimum(own, _taken_over(stretches, t, a, every, label, meet[t]))
    rest = np.concatenate([np.where(np.isfinite(both), both, apart), none[:, None]], axis=1)
    rest[np.arange(len(t)), a] = np.inf
    second = rest.argmin(1)
    return rest[np.arange(len(t)), second], np.where(second == nats.shape[1], -1, second)


def _taken_over(stretches: Stretches, t: Ints, a: Ints, every: Floats, label: Ints, meet: Bools) -> Floats:
    """(n) the margin (2') of tracks t with labels a: another that they meet (n, T) takes the label, they have none."""
    T = len(label)
    has = np.where(label >= 0, np.maximum(every[np.arange(T), np.maximum(label, 0)], 0.0), 0.0)
    gain = every[:, a].T - has  # of u, (n, T)
    n = stretches.seen.sum(1)
    share = np.minimum(1.0, n / np.maximum(n[t], 1)[:, None])
    most = np.where(meet, share * gain, 0.0).max(1, initial=0.0)
    return np.asarray(every[t, a] - np.maximum(most, 0.0))


def _of_labels(stretches: Stretches, t: Ints, a: Ints, share: Floats, L: int) -> tuple[Floats, Floats]:
    """(L) the fit of all tracks that are a label, 1 where none is, and its frames as a share of the most of any."""
    n = np.isfinite(stretches.xyz[t, :, 0]).sum(1).astype(float)
    total, frames = np.bincount(a, n * share, L), np.bincount(a, n, L)
    return np.where(frames > 0, total / np.maximum(frames, 1), 1.0), frames / max(frames.max(initial=0.0), 1.0)


def _worst_near(template: Template, label_fit: Floats) -> Floats:
    """(L) the least fit of the nearest labels, not below 0."""
    D = np.where(np.isfinite(template.distance), template.distance, np.inf) + np.diag(np.full(len(template), np.inf))
    near = np.argsort(D, axis=1, kind="stable")[:, : min(NEAR, len(template) - 1)]
    return np.asarray(np.maximum(label_fit[near].min(1), 0.0))


def _fit_meanwhile(stretches: Stretches, t: Ints, y: Single, pairs: PairScore) -> Floats:
    """(n) fit of the frames in which tracks t are seen."""
    fit = frame_fit(y, pairs)
    here = np.isfinite(stretches.xyz[t, :, 0])
    return np.asarray((here * fit).sum(1) / np.maximum(here.sum(1), 1))


def _exchanges(y: Single, template: Template, pairs: PairScore, fixed: Ints) -> Floats:
    """(L) the least that an exchange of two, with each label, loses, nats.

    Negative where it gains, 0 where a label has none. Labels that were stated of tracks, `fixed` (T), have none.
    """
    exchanger, every = Exchanger.of(template, pairs).keeping(fixed), np.arange(len(template))
    anatomy = Anatomy.of(template.names)
    lost = np.full(len(template), np.inf)
    gains = np.maximum(exchanger.gains(y, exchanger.twos), -_most(y, template, pairs, exchanger))
    for (was, to), gain in zip(exchanger.twos, gains, strict=True):
        turn = every.copy()
        turn[list(was)] = to
        told = anatomy.gain(y, turn) if anatomy.tells(was) else 0.0
        lost[list(was)] = np.minimum(lost[list(was)], -gain - told)
    return np.where(np.isfinite(lost), lost, 0.0)


def _most(y: Single, template: Template, pairs: PairScore, exchanger: Exchanger) -> Floats:
    """(M) the most that exchanges of two count as losing, nats; infinite where what keeps tells both apart."""
    twos = [(was[0], was[1]) for was, _ in exchanger.twos]
    there = np.asarray(np.isfinite(y[..., 0]).any(0))
    out, own = np.full(len(twos), np.inf), np.flatnonzero(told_by_none(twos, template, there))
    out[own] = TIMES * told_by_one(y, pairs, [twos[k] for k in own.tolist()])
    return out


def track_features(found: Margins, weight: Floats) -> Floats:
    """(T, 9) of (3)."""
    fit, off = np.minimum(found.fit, FIT_HIGH), np.minimum(found.beside, FIT_HIGH)
    parts = (
        _log(np.maximum(found.track, 0.0)),
        fit,
        off,
        np.log(weight),
        _log(np.maximum(found.link, 0.0)),
        np.minimum(found.frame_fit, 1.0),
        -np.log1p(found.nameless),
        found.nameless == 0,
    )
    return np.stack([np.ones(len(weight)), *parts], axis=1)


def label_features(found: Margins) -> Floats:
    """(T, 16) of (4); the same for all tracks of a label, but for the fit of their frames."""
    fits = (np.minimum(part, FIT_HIGH) for part in (found.label_fit, found.near_fit))
    parts = (
        _log(found.exchange), *fits, np.minimum(found.frame_fit, 1.0), np.log(found.present),
        _log(found.rival), found.stiff,
        *(np.minimum(part, 0.0) for part in (found.fit_beside, found.stiff_beside, found.near_fit - CHAIN_END)),
        found.rigid, np.log(np.minimum(found.poses, MOST_POSES)), found.shut > 0, found.shut > 1,
        (found.stiff - 1.0) * np.log1p(found.nameless),
    )  # fmt: skip
    return np.stack([np.ones(len(found.fit)), *parts], axis=1)


def first_factors(found: Margins, gained: float = GAINED) -> Floats:
    """(T) the first two factors of (4), with k = gained where an exchange gains."""
    exchange = logistic(np.where(found.exchange > 0, LOST, gained) * found.exchange)
    return exchange * logistic(TOLD_SLOPE * (found.told - TOLD))


def _log(nats: Floats) -> Floats:
    """log(1 + nats), of those from 0 to the most that tell anything."""
    return np.asarray(np.log1p(np.clip(nats, 0.0, MOST_NATS)))


def probability(
    found: Margins,
    weight: Floats,
    *,
    shift: float = 0.0,
    piece: Sequence[float] = BETA_PIECE,
    label: Sequence[float] = BETA_LABEL,
    gained: float = GAINED,
) -> Floats:
    """(T) by (1), with δ = shift; 0 for tracks without label."""
    p = label_probability(found, label=label, gained=gained) * track_probability(found, weight, shift, piece)
    return np.where(np.isfinite(p), p, 0.0)


def label_probability(found: Margins, *, label: Sequence[float] = BETA_LABEL, gained: float = GAINED) -> Floats:
    """(T) p_label by (4), NaN for tracks without label."""
    return np.asarray(first_factors(found, gained) * logistic(label_features(found) @ np.asarray(label)))


def track_probability(
    found: Margins, weight: Floats, shift: float = 0.0, piece: Sequence[float] = BETA_PIECE
) -> Floats:
    """(T) p_track by (3), with δ = shift and the β of pieces; NaN for tracks without label."""
    return logistic(track_logit(found, weight, piece) + shift)


def track_logit(found: Margins, weight: Floats, piece: Sequence[float] = BETA_PIECE) -> Floats:
    """(T) by (3), without δ."""
    features = track_features(found, weight)
    pieces = features @ np.asarray(piece)
    return np.where(found.share < MOST_OF_LABEL, pieces, features @ np.asarray(BETA_TRACK))


def logistic(logit: Floats) -> Floats:
    """1 / (1 + exp(−logit)), without overflow."""
    return np.asarray(1 / (1 + np.exp(-np.clip(logit, -30, 30))))
