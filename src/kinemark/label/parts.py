"""Parts of the body in a posture that the template never showed, and bodies that move by themselves, as tools do.

A limb in a new posture is off from all markers of the rest at once. Evidence takes that for as many proofs as there are
pairs, so that the limb stays without names though every distance within it holds. So once the body is named, what is
left is looked through part by part. Two labels belong together where their distance hardly changes by the template,

    s_ab² ≤ (0.02 D_ab)² + (0.003 H)²                                                                              (1)

with H the size of the body; a part is labels all of which belong together, by complete linkage, of those that are away,
seen in few frames. It is labelled as a subject of its own, by the distances within it alone, among all tracks that have
no name; those to the rest of the body are what is new. Where the body as a whole does not fit, all parts are looked for
so, and no name of them is sure. A part must fit as a whole body must. Where another part that is away fits the same
tracks nearly as well, as the other arm, its names are as likely as that one's; of two that want the same tracks the
worse is looked for once more among what the better one left.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy

from ..data import Trajectories
from ..data.array_types import Bools, Floats, Ints
from ..numerics.evenly import evenly_rounded
from .decided_sides import UNDECIDED
from .evidence import WRONG_HAND, PairScore, hands
from .labels import Labels, State
from .stretches import stretches_of
from .sweeps import places, total_score
from .template import Template

STIFF, OF_SIZE = 0.02, 0.003
"""Of (1), shares of the distance and of the size; chosen: parts of walks, of a run and of a range of motion are
segments by it; with 0.03 thighs of some walks are one with the pelvis or the other knee."""
AWAY = 0.5
"""Share of the frames below which a label is away; chosen: names of a half of the trial are carried over the rest."""
KNOWN = 0.65
"""Probability from which on a track keeps the name that the whole body gave it; chosen: one half before probabilities
were recalibrated. With one half of now a tool of a simulated set kept the names of another one, 6 % of the samples."""
LEAST = 3
"""Markers of a part; by definition: two have a single distance, which any two tracks may have."""
ROUNDS = 3
"""At most; chosen: what lost its tracks to a better part is looked for anew."""
FRAMES = 10
"""In which sides are compared; chosen, as in `limbs`."""

Naming = Callable[[Trajectories, Template, Mapping[str, str | None]], Labels]
"""Labels of tracks by a template, some of them stated."""


class Found(NamedTuple):
    """A part that was found: track → row of the labels that name it, these labels, and their nats a frame."""

    at: dict[int, int]
    by: Labels
    score: float


def with_parts(
    tracks: Trajectories, labels: Labels, template: Template, name: Naming, stated: Collection[str] = ()
) -> Labels:
    """Labels, with those of parts that the whole body left without names; the same object where there are none.

    Args:
        tracks: T that were labelled. labels: of them; none has a name where the body did not fit. template: by which.
        name: labels a part. stated: tracks that keep what was stated of them.
    """
    seen = np.isfinite(tracks.xyz[..., 0])
    known = np.array([track in stated for track in tracks.names], bool)
    before = np.zeros(len(tracks), bool)
    for _ in range(ROUNDS):
        free = (labels.probability < KNOWN) & ~known & seen.any(1)
        if seen[free].sum(0).max(initial=0) < LEAST or (free == before).all():
            break  # among the same tracks the same parts are found
        before = free
        away = _away(seen, labels, template, free)
        parts = [part for part in stiff_parts(template, away) if len(part) >= LEAST]
        found = [one for part in parts if (one := _found(tracks, template, part, np.flatnonzero(free), name))]
        if not found:
            break
        labels = _taken(labels, found)
    return labels


def stiff_parts(template: Template, away: Bools) -> list[Ints]:
    """Labels that are away, in parts all of whose labels belong together (1)."""
    at = np.flatnonzero(away)
    if len(at) < 2:
        return [at]
    share = _looseness(template)[np.ix_(at, at)]
    np.fill_diagonal(share, 0.0)
    tree = scipy.cluster.hierarchy.linkage(scipy.spatial.distance.squareform(share, checks=False), "complete")
    part = scipy.cluster.hierarchy.fcluster(tree, 1.0, "distance")
    return [at[part == k] for k in range(1, part.max() + 1)]


def _looseness(template: Template) -> Floats:
    """(L, L) spread as a share of what (1) allows, at most 9; 9 of what was never seen together."""
    share = template.spread / np.hypot(STIFF * template.distance, OF_SIZE * template.size)
    return np.asarray(np.where(template.frames > 0, np.minimum(np.nan_to_num(share, nan=9.0), 9.0), 9.0))


def _away(seen: Bools, labels: Labels, template: Template, free: Bools) -> Bools:
    """(L) whether a label is seen in few of the frames in which any track without name is."""
    rest = seen[free].any(0) if free.any() else np.zeros(seen.shape[1], bool)
    named = {a: np.zeros(seen.shape[1], bool) for a in template.names}
    for t in np.flatnonzero(~free & np.array([name in named for name in labels.names], bool)):
        named[str(labels.names[t])] |= seen[t]
    return np.array([bool(rest.any()) and (named[a] & rest).sum() < AWAY * rest.sum() for a in template.names], bool)


def _found(tracks: Trajectories, template: Template, part: Ints, free: Ints, name: Naming) -> Found | None:
    """A part among free tracks; None where it is not there."""
    own = part_of(template, part)
    among = replace(tracks, paths=tuple(tracks.paths[t] for t in free))
    by = name(among, own, {})
    if by.refused is not None or len({*by.names} - {None}) < LEAST:
        return None
    at = {int(t): k for k, t in enumerate(free) if by.names[k] is not None}
    score = _score(among, by, own, template.size)
    return Found(at, by, score) if score > 0 else None


def part_of(template: Template, index: Ints) -> Template:
    """The template of some of its labels."""
    pick, turn = np.ix_(index, index), np.full(len(template), -1)
    turn[index] = np.arange(len(index))
    kept = (turn[template.handed] >= 0).all(1)
    doubt = np.asarray(template.doubt)
    return replace(
        template,
        names=tuple(template.names[a] for a in index.tolist()),
        **{key: getattr(template, key)[pick] for key in ("distance", "spread", "short_spread", "frames")},
        handed=turn[template.handed[kept]],
        sign=template.sign[kept],
        doubt=doubt[pick],
    )


def _score(tracks: Trajectories, by: Labels, part: Template, size: float) -> float:
    """Nats a frame of the names of tracks, with quadruples; below 0 where most of these are turned, as in a mirror."""
    stretches, pairs = stretches_of(tracks, size), PairScore.of_template(part)
    label = np.array([-1 if one is None else part.names.index(one) for one in by.names])
    y = places(stretches, label, len(part))
    y = y[evenly_rounded(len(y), FRAMES)]
    turned = np.array([hands(xyz, part.handed, part.sign) < 0 for xyz in y]).reshape(len(y), -1)
    seen = np.isfinite(y[:, part.handed, 0]).all(2)
    if (turned & seen).sum() > seen.sum() / 2:
        return -np.inf
    own = 0.0 if pairs.hands else -WRONG_HAND * float(turned.sum()) / max(len(y), 1)
    return total_score(stretches, label, pairs)[0] + own


def _taken(labels: Labels, found: list[Found]) -> Labels:
    """Labels with the parts, the best first, but those that want tracks of a better one."""
    names, state, runner_up = list(labels.names), list(labels.state), list(labels.runner_up)
    p, margin, against = labels.probability.copy(), labels.margin.copy(), list(labels.against)
    used: set[int] = set()
    for one in sorted(found, key=lambda each: -each.score):
        if used & set(one.at):
            continue
        used |= set(one.at)
        doubted = _rivalled(one, found)
        for t, k in one.at.items():
            names[t], runner_up[t], against[t] = one.by.names[k], one.by.runner_up[k], one.by.against[k]
            p[t], margin[t] = (0.5 if doubted else 1.0) * one.by.probability[k], one.by.margin[k]
            state[t] = _doubted(one.by.state[k]) if doubted else one.by.state[k]
    return replace(
        labels, names=tuple(names), state=tuple(state), runner_up=tuple(runner_up), against=tuple(against),
        probability=p, margin=margin,
    )  # fmt: skip


def _doubted(state: State) -> State:
    return "unsure" if state == "sure" else state


def _rivalled(one: Found, found: list[Found]) -> bool:
    """Whether another part fits most of the same tracks nearly as well."""
    return any(
        other.score > one.score - UNDECIDED and 2 * len(set(other.at) & set(one.at)) > len(one.at)
        for other in found
        if other is not one
    )


def placed_share(seen: Bools, labels: Labels, L: int) -> float:
    """Of the samples that could have a name, at most L a frame, those that have one."""
    named = np.array([a is not None for a in labels.names], bool)
    could: Floats = np.minimum(seen.sum(0), L).astype(float)
    return float(seen[named].sum() / max(could.sum(), 1))
