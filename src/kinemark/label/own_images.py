"""Sets that are their own image: other ways to give all names of a trial that its distances allow as well.

A box, a rod with a bar across or a hand whose markers are numbered can be named in several ways, and a search ends in
one of them by chance. An image π calls π(a) what is called a. With d_ab the mean distance of two labels in the trial
and l of `evidence` (1), it loses on the labels placed so far

    λ = Σ l(d_ab; D_ab) − l(d_ab; D_π(a)π(b))                                                                     (1)

Images are sought by beam search. One label after the other is denied its own name. The rest are placed in the
order in which those before tell them best, and what loses more than twice what may be lost is dropped. So the search
in a set that is no image of itself ends after a few labels.

The trial judges what is found: by its frames, quadruples and what any body shows of its sides (`exchange` (1),
`anatomy`). What loses little there is as likely as the names themselves, unless distances that keep say otherwise: the
small ones by which nothing is quite its own image. With w the inverse of the variance that the template leaves both,

    r = Σ w (d_ab − D_ab)² / Σ w (d_ab − D_π(a)π(b))²                                                             (2)

is far below 1 where they tell the names from the image, as in `asymmetry` (1). An image says nothing of a label that
an exchange of two would lose as little of, as this counts already (`margin`).
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np

from ..data import make_finding
from ..data.array_types import Bools, Floats, Ints
from ..data.finding import Finding
from ..data.marker_sides import sides_by_name
from ..numerics.evenly import evenly_rounded
from ..numerics.vectors import lengths
from .anatomy import Anatomy
from .asymmetry import TURNED
from .decided_sides import UNDECIDED
from .evidence import OF_SIZE, PairScore, Single
from .exchange import Exchanger
from .stretches import Stretches
from .sweeps import places
from .template import Template

BY_SHAPE = 15.0
"""Nats a frame that an image may lose and be as likely, where no name of the set has a side; chosen: of simulated
hands with alike fingers postures alone make it up to 12 either way."""
OF_EACH = 2.5
"""The same for each label that an image moves, at most; chosen: few labels have few distances that a posture changes,
and a turn of three numbered markers of a pelvis loses 14 by the static trial of one child, 2 by that of another."""
BEAM = 20
"""Images that go on from label to label; chosen: of 48 simulated hands 20 find all images and 10 miss two."""
TELLING = 14
"""Labels placed before to which one is compared; chosen, as in `key_frames`."""
MOST_OF_A_PAIR = 0.25
"""Share of what an image may lose that the pair which tells a label most may; chosen: where few lose so much, it is no
image."""
MOST = 48
"""Images that the trial judges, those that lose least; chosen: a cube has 47, half of which its quadruples tell."""
STARTS = 16
"""Labels that are denied their names, evenly among all, or every other where there are few; chosen: what moves half of
the labels, or four that are listed side by side, moves one of these."""
FEWEST = 3
"""Labels of an image; by definition: of two `exchange` tells."""
FRAMES = 20
"""In which images are judged; chosen: a set that is its image is so in any."""


class OwnImages(NamedTuple):
    """What the names of a trial could be at once, all of them.

    Attributes:
        label: (T) by the image that fits best. share: (T) of the images that fit nearly as well, those in which a track
            has this name; 1 where there are none. other: (T) its name in the best of the rest, −1 for none.
        finding: that asks; None where nothing is to be asked.
    """

    label: Ints
    share: Floats
    other: Ints
    finding: Finding | None = None


def no_images(label: Ints) -> OwnImages:
    """Of labels (T) that are what they are."""
    return OwnImages(label, np.ones(len(label)), np.full(len(label), -1))


def own_images(stretches: Stretches, label: Ints, template: Template, pairs: PairScore) -> OwnImages:
    """What a trial's labels (T), −1 for none, could be at once; those that were stated stay what they are."""
    every = np.arange(len(template))
    y = places(stretches, label, len(template))
    y = y[evenly_rounded(len(y), FRAMES)]
    least = UNDECIDED if sides_by_name(template.names) else BY_SHAPE
    turns = images(_mean_distances(y), pairs, stretches.fixed[stretches.fixed >= 0], 2 * least)
    gains = _gains(y, turns, template, pairs)
    if gains.max(initial=0.0) > 0:
        best = turns[gains.argmax()]
        label = np.where(label >= 0, best[label], -1)
        back = np.argsort(best)  # what had each name before
        y, turns, gains = y[:, back], np.vstack([every, turns])[:, back], np.append(0.0, gains) - gains.max()
        other = np.any(turns != every, axis=1)
        turns, gains = turns[other], gains[other]
    counts = _as_likely(y, turns, gains, least, template, pairs)
    ways = 1 + counts.sum(0) + ((turns == every) & counts.any(1, keepdims=True)).sum(0)
    share = (ways - counts.sum(0)) / ways
    open_ = np.flatnonzero(share < 1)
    if not len(open_):
        return no_images(label)
    second = every.copy()
    second[open_] = turns[np.where(counts, gains[:, None], -np.inf).argmax(0)[open_], open_]
    own, moved = np.maximum(label, 0), (label >= 0) & np.isin(label, open_)
    finding = make_finding(
        "own_image",
        markers=[template.names[a] for a in open_.tolist()],
        other_list=[template.names[a] for a in second[open_].tolist()],
        ways=int(ways.max()),
    )
    return OwnImages(label, np.where(moved, share[own], 1.0), np.where(moved, second[own], -1), finding)


def _as_likely(y: Single, turns: Ints, gains: Floats, least: float, template: Template, pairs: PairScore) -> Bools:
    """(N, L) whether each label has another name in each image (N, L), which is as likely and tells more than two do.

    Args:
        y: (K, L, 3) places of labels. gains: (N) nats a frame of images. least: nats that these may lose.
    """
    moved, d = np.asarray(turns != np.arange(len(template))), _mean_distances(y)
    near = gains > -np.minimum(least, OF_EACH * moved.sum(1))
    near[near] = [not _told_apart(d, turn, template) for turn in turns[near]]
    alone = np.full(len(template), -np.inf)
    if near.any():
        exchanger = Exchanger.of(template, pairs)
        for (was, _), gain in zip(exchanger.twos, exchanger.gains(y, exchanger.twos), strict=True):
            alone[list(was)] = np.maximum(alone[list(was)], gain)
    counts = moved & near[:, None] & (gains[:, None] > alone)
    return np.asarray(counts & (counts.sum(1, keepdims=True) >= FEWEST))


def _gains(y: Single, turns: Ints, template: Template, pairs: PairScore) -> Floats:
    """(N) nats a frame that the labels y (K, L, 3) gain by images."""
    exchanger, anatomy, every = Exchanger.of(template, pairs), Anatomy.of(template.names), np.arange(len(template))
    moved = [np.flatnonzero(turn != every) for turn in turns]
    moves = [(tuple(own.tolist()), tuple(turn[own].tolist())) for own, turn in zip(moved, turns, strict=True)]
    return exchanger.gains(y, moves) + anatomy.gains(y, turns)


def _told_apart(d: Single, turn: Ints, template: Template) -> bool:
    """Whether (2) tells names of distances d (L, L) from those that become turn (L)."""
    there = np.ix_(turn, turn)
    known = np.triu(template.keeps & template.keeps[there] & np.isfinite(d), 1)
    weight = known / (template.spread**2 + template.spread[there] ** 2 + (OF_SIZE * template.size) ** 2)
    straight, turned = (
        float(np.nansum(np.where(known, weight * (d - D) ** 2, 0.0)))
        for D in (template.distance, template.distance[there])
    )
    return straight * TURNED < turned


def images(d: Single, pairs: PairScore, stated: Ints, most: float) -> Ints:
    """(N, L) what labels become in each image that loses little by (1), without the names as they are.

    Args:
        d: (L, L) mean distances in the trial, mm; NaN of labels that are not there, which stay what they are.
        stated: labels that keep their names. most: nats that an image may lose.
    """
    every = np.arange(len(d))
    there = np.flatnonzero(np.isfinite(d).any(1))
    stated = np.intersect1d(there, stated)
    free = np.setdiff1d(there, stated)
    found: dict[bytes, tuple[float, Ints]] = {}
    told = pairs.expected
    for first in free[:: max(2, len(free) // STARTS)].tolist():
        if any(turn[first] != first for lost, turn in found.values() if 2 * lost < most):
            continue
        order = _order(told, [*stated.tolist(), first], there)
        may = {c: free for c in free.tolist()} | {c: np.array([c]) for c in stated.tolist()}
        may[first] = free[free != first]
        for to, lost in zip(*_search(d, pairs, told, order, may, most), strict=True):
            turn = every.copy()
            turn[order] = to
            found.setdefault(turn.tobytes(), (float(lost), turn))
    best = sorted(found.values(), key=lambda one: one[0])
    turns = [turn for _, turn in best if (turn != every).sum() >= FEWEST]
    return np.array(turns[:MOST], np.int64).reshape(-1, len(every))


def _search(
    d: Single, pairs: PairScore, told: Floats, order: Ints, may: dict[int, Ints], most: float
) -> tuple[Ints, Single]:
    """(B, n) what the labels in order become, each one of those that it may, and (B) nats lost by (1)."""
    state, lost = may[int(order[0])][:, None], np.zeros(len(may[int(order[0])]), np.float32)
    used = state == np.arange(len(d))
    for k, c in enumerate(order[1:].tolist(), 1):
        by = np.argsort(-told[c, order[:k]], kind="stable")[:TELLING]
        e, to = order[by], may[c]
        own = pairs.at(d[c, e], c, e)
        first = own[0] - pairs.at(d[c, e[0]], to, state[:, by[:1]])  # (1), of the one that tells most
        first[used[:, to]] = np.inf
        parent, which = np.nonzero(first <= MOST_OF_A_PAIR * most)
        new = lost[parent] + first[parent, which]
        for part in (slice(1, 5), slice(5, None)):  # what has lost too much is not compared to all
            nats = pairs.at(d[c, e[part]], to[which, None], state[parent[:, None], by[part]])
            new += own[part].sum() - nats.sum(1)
            parent, which, new = parent[new <= most], which[new <= most], new[new <= most]
        keep = np.arange(len(new))
        if len(keep) > BEAM:
            keep = keep[np.argpartition(new[keep], BEAM)[:BEAM]]
        state, lost = np.column_stack([state[parent[keep]], to[which[keep]]]), new[keep]
        used = used[parent[keep]]
        used[np.arange(len(keep)), state[:, -1]] = True
        if not len(keep):
            return np.zeros((0, len(order)), np.int64), lost
    return state, lost


def _order(told: Floats, first: list[int], among: Ints) -> Ints:
    """Some labels, from the first on each time the one that those before tell best, by the nats (L, L) of pairs."""
    done, best = list(first), told[first].sum(0)
    best[np.setdiff1d(np.arange(len(told)), among)] = -np.inf
    while len(done) < len(among):
        best[done] = -np.inf
        done.append(int(best.argmax()))
        best += told[done[-1]]
    return np.array(done, np.int64)


def _mean_distances(y: Single) -> Single:
    """(L, L) mm of places y (K, L, 3); NaN of labels that are never seen together, and on the diagonal of those that
    are not there."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.asarray(np.nanmean(lengths(y[:, :, None] - y[:, None]), axis=0))
