"""Labelling with tracks that go over from one marker to another: they are cut there, and all is named anew.

A cut is kept where its two sides are named in the end, and otherwise than each other. Where a track breaks off, and
where it is a marker in a part alone, one side may also have no name. A cut behind a gap of which nothing tells whose it
is stays as well where one of its sides is not sure: each has a name that is as sure as it is by itself. So do cuts
where unsure tracks make sudden steps, as where two images become one, if more samples are sure with them than without.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..data import Trajectories
from ..data.array_types import Ints
from .breaks import find_breaks, sudden_steps
from .cutting import cut
from .hidden import find_hidden
from .label import label
from .labels import Labels, State
from .stated import fixed_labels
from .stretches import FREE
from .switches import find_turns
from .template import Template

ROUNDS = 3
"""Of naming and cutting; chosen: what hid behind other exchanges is found the second time."""
_Cut = tuple[int, int]
"""Of a track, before a frame."""


class Switch(NamedTuple):
    """A track goes over to another marker.

    Attributes:
        track: index among those that were given. frame: the first, from 0, of the second marker.
        before, after: names of the markers.
    """

    track: int
    frame: int
    before: str
    after: str


class CutLabels(NamedTuple):
    """Tracks cut where they go over to another marker.

    Attributes:
        tracks: P of them. labels: of these. of: (P) the track that each is of, as they were given.
        switches: in the order of tracks and frames.
    """

    tracks: Trajectories
    labels: Labels
    of: Ints
    switches: tuple[Switch, ...]


def label_switching(
    tracks: Trajectories,
    template: Template,
    *,
    method: Any = None,
    stated: Mapping[str, str | None] = MappingProxyType({}),
) -> CutLabels:
    """As `label`, with tracks that go over from one marker to another cut there.

    Args:
        tracks: of a recording. template: of the subject. method: one of `LABEL`.
        stated: track → marker that a person stated, None for no marker; such tracks are not cut.

    Raises:
        KinemarkError: there are no tracks.
    """

    @cache  # where no cut stays, all is as it was before the first
    def by_cuts(cuts: frozenset[_Cut]) -> CutLabels:
        now, of = cut(tracks, set(cuts)) if cuts else (tracks, np.arange(len(tracks)))
        return CutLabels(now, label(now, template, method=method, stated=stated), of, ())

    def named(cuts: set[_Cut]) -> CutLabels:
        return by_cuts(frozenset(cuts))

    free = np.flatnonzero(fixed_labels(tracks, template, stated) == FREE)
    hidden = find_hidden(tracks, template.size, free)
    breaks = find_breaks(tracks, template.size, free) | hidden.changed
    cuts, breaks = _with_turns(named, breaks | hidden.open, breaks, template, stated)
    cuts = _settled(named, cuts, breaks, hidden.open)
    if sudden := _sudden(named(cuts), tracks, template.size, free) - cuts:
        other = _settled(named, cuts | sudden, breaks, hidden.open | sudden)
        cuts = max(cuts, other, key=lambda one: _sure_samples(named(one)))
    return named(cuts)._replace(switches=_switches(named(cuts), cuts))


def _with_turns(
    named: Callable[[set[_Cut]], CutLabels],
    cuts: set[_Cut],
    breaks: set[_Cut],
    template: Template,
    stated: Mapping[str, str | None],
) -> tuple[set[_Cut], set[_Cut]]:
    """The cuts, and the breaks among them, with those where tracks that were named go over to other markers."""
    for _ in range(ROUNDS):
        found = named(cuts)
        turns = _turns(found.tracks, found.labels, template, stated)
        new = {(int(found.of[t]), frame) for t, frame, _ in turns} - cuts
        if not new:
            break
        cuts = cuts | new
        breaks = breaks | new & {(int(found.of[t]), frame) for t, frame, alone in turns if alone}
    return cuts, breaks


def _settled(
    named: Callable[[set[_Cut]], CutLabels], cuts: set[_Cut], breaks: set[_Cut], open_: set[_Cut]
) -> set[_Cut]:
    """The cuts that are kept when all is named by them alone."""
    while len(kept := _kept(named(cuts), cuts, breaks, open_)) < len(cuts):  # ends, as there are fewer each time
        cuts = kept
    return cuts


def _sudden(found: CutLabels, tracks: Trajectories, size: float, free: Ints) -> set[_Cut]:
    """Before the sudden steps of tracks of which a piece is not sure."""
    unsure = found.of[_in_state(found, "unsure")]
    return sudden_steps(tracks, size, np.intersect1d(free, unsure))


def _sure_samples(found: CutLabels) -> int:
    """How many samples have sure names."""
    return int(np.isfinite(found.tracks.xyz[_in_state(found, "sure"), :, 0]).sum())


def _in_state(found: CutLabels, state: State) -> Ints:
    """The pieces whose names are in a state."""
    return np.flatnonzero([one == state for one in found.labels.state])


def _kept(found: CutLabels, cuts: set[_Cut], breaks: set[_Cut], open_: set[_Cut]) -> set[_Cut]:
    """The cuts whose two sides have names, and different ones.

    Of `breaks` also those of which one side has none, and of those that are open also those not both sides of which are
    sure.
    """
    kept = set()
    for one in cuts:
        (was, sure), (to, as_well) = _sides(found, one)
        unlike = was != to and (one in breaks or None not in (was, to))
        open_still = one in open_ and (was, to) != (None, None) and not (sure and as_well)
        if unlike or open_still:
            kept.add(one)
    return kept


def _switches(found: CutLabels, cuts: set[_Cut]) -> tuple[Switch, ...]:
    """The cuts whose two sides have names, and different ones."""
    out = []
    for t, frame in sorted(cuts):
        (was, _), (to, _) = _sides(found, (t, frame))
        if was is not None and to is not None and was != to:
            out.append(Switch(t, frame, was, to))
    return tuple(out)


def _sides(found: CutLabels, one: _Cut) -> tuple[tuple[str | None, bool], tuple[str | None, bool]]:
    """Names of the pieces before and after a cut, and whether they are sure; None for what has none."""
    t, frame = one
    pieces = np.flatnonzero(found.of == t)
    seen = np.isfinite(found.tracks.xyz[pieces, :, 0])
    before, after = pieces[seen[:, :frame].any(1)], pieces[seen[:, frame:].any(1)]
    if not len(before) or not len(after):
        return (None, False), (None, False)
    p, q, labels = before[-1], after[0], found.labels
    return (labels.names[p], labels.state[p] == "sure"), (labels.names[q], labels.state[q] == "sure")


def _turns(
    tracks: Trajectories, labels: Labels, template: Template, stated: Mapping[str, str | None]
) -> list[tuple[int, int, bool]]:
    """As `find_turns` has them; none where the template does not fit."""
    if labels.refused is not None:
        return []
    number: dict[str | None, int] = {name: a for a, name in enumerate(template.names)}
    label_of = np.array([number.get(name, -1) for name in labels.names])
    return find_turns(tracks, label_of, template, fixed_labels(tracks, template, stated))
