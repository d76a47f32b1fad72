"""Labelling with tracks that go over from one marker to another: they are cut there, and all is named anew.

A cut is kept where its two sides are named in the end, and otherwise than each other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..data import Origin, Trajectories
from ..data.array_types import Ints
from .label import label
from .labels import Labels
from .stated import fixed_labels
from .switches import find_turns
from .template import Template

ROUNDS = 3
"""Of naming and cutting; chosen: what hid behind other exchanges is found the second time."""


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
    cuts: set[tuple[int, int]] = set()
    now, of = tracks, np.arange(len(tracks))
    labels = label(now, template, method=method, stated=stated)
    for _ in range(ROUNDS):
        new = {(int(of[t]), frame) for t, frame in _turns(now, labels, template, stated)} - cuts
        if not new:
            break
        cuts |= new
        now, of = cut(tracks, cuts)
        labels = label(now, template, method=method, stated=stated)
    found = _switches(now, of, labels, cuts)
    while len(found) < len(cuts):  # ends, as there are fewer each time
        cuts = {(one.track, one.frame) for one in found}
        now, of = cut(tracks, cuts)
        labels = label(now, template, method=method, stated=stated)
        found = _switches(now, of, labels, cuts)
    return CutLabels(now, labels, of, found)


def cut(tracks: Trajectories, cuts: set[tuple[int, int]]) -> tuple[Trajectories, Ints]:
    """Tracks cut before these (track, frame), and (P) which track each piece is of; pieces are called `*3 (1)`, …"""
    paths, of = [], []
    for t, path in enumerate(tracks):
        ends = sorted(frame for one, frame in cuts if one == t)
        part = np.searchsorted(ends, np.arange(len(path)), side="right")
        seen = np.unique(part[path.origin != Origin.MISSING]).tolist()
        pieces = [replace(path.only(part == k), name=f"{path.name} ({i})") for i, k in enumerate(seen, 1)]
        paths += pieces if len(pieces) > 1 else [path]
        of += [t] * max(len(pieces), 1)
    return replace(tracks, paths=tuple(paths)), np.array(of, np.int64)


def _switches(now: Trajectories, of: Ints, labels: Labels, cuts: set[tuple[int, int]]) -> tuple[Switch, ...]:
    """The cuts whose two sides have names, and different ones."""
    found = []
    seen = np.isfinite(now.xyz[..., 0])
    for t, frame in sorted(cuts):
        pieces = np.flatnonzero(of == t)
        before = [p for p in pieces.tolist() if seen[p, :frame].any()]
        after = [p for p in pieces.tolist() if seen[p, frame:].any()]
        was, to = (labels.names[p] for p in (before[-1], after[0])) if before and after else (None, None)
        if was is not None and to is not None and was != to:
            found.append(Switch(t, frame, was, to))
    return tuple(found)


def _turns(
    tracks: Trajectories, labels: Labels, template: Template, stated: Mapping[str, str | None]
) -> list[tuple[int, int]]:
    """(track, frame) before which tracks should be cut; none where the template does not fit."""
    if labels.refused is not None:
        return []
    number: dict[str | None, int] = {name: a for a, name in enumerate(template.names)}
    label_of = np.array([number.get(name, -1) for name in labels.names])
    return find_turns(tracks, label_of, template, fixed_labels(tracks, template, stated))
