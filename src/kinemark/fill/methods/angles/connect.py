"""Which markers form segments: given, or found from distances that stay (Swamidas 1997, 3.33 and 5.2).

The thesis' matrix CONNECT names pairs of markers. Where it is not given, markers whose distances all stay within a
share of themselves form a *bank*, on one body; all its pairs are segments. Banks, and markers on their own, are
joined by the tree of the least spread, each of whose branches is a segment of its own, as from the shoulder to the
elbow.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....data.array_types import Floats, Ints
from ....geometry.rigid_pairs import Distances, distances, rigid_groups, spanning_links
from ....signal.segment_directions import LinkedSegments

FEWEST = 10
"""Frames that must have both ends of a segment; chosen (see studies/missing_markers.py)."""
LONG = 1500
"""Frames of a trial above which fewer of them tell distances; chosen (see studies/missing_markers.py)."""


def connect(
    xyz: Floats,
    *,
    names: Sequence[str],
    links: Sequence[tuple[str, str]] = (),
    banks: Sequence[Sequence[str]] = (),
    stiff: float = 0.02,
    loose: float = 0.25,
) -> LinkedSegments:
    """Segments of markers (M, F, 3) mm, NaN where missing.

    Args:
        xyz: paths.
        names: (M).
        links: pairs that are segments; empty, and banks empty too: found.
        banks: groups of markers on one body.
        stiff: share of its mean by which a distance within a bank may spread.
        loose: of a segment that joins banks.

    Raises:
        ValueError: a link or bank names a marker that is not there, or one twice.
    """
    found = distances(xyz, most_frames=1000 if xyz.shape[1] <= LONG else 300)
    share = np.where(found.frames >= FEWEST, found.share, np.nan)
    if links or banks:
        return _given(found, names, links, banks)
    group = rigid_groups(share, most=stiff)
    same = np.argwhere(np.triu(group[:, None] == group, 1) & (share <= stiff))
    tree = spanning_links(np.where(group[:, None] == group, np.fmin(share, 0.0), share), most=loose)
    tree = tree[group[tree[:, 0]] != group[tree[:, 1]]]
    number = np.concatenate([group[same[:, 0]], len(xyz) + np.arange(len(tree))])
    return _measured(np.concatenate([same, tree]), number, found)


def _given(
    found: Distances, names: Sequence[str], links: Sequence[tuple[str, str]], banks: Sequence[Sequence[str]]
) -> LinkedSegments:
    place = {name: m for m, name in enumerate(names)}
    if wrong := sorted({name for group in (*links, *banks) for name in group} - set(place)):
        raise ValueError(f"links or banks name {wrong}, which are not among the markers")
    if any(len(set(group)) < len(group) or len(group) < 2 for group in (*links, *banks)):
        raise ValueError("a link is of two different markers, a bank of two or more")
    link = [(place[a], place[b]) for a, b in links]
    number = list(range(len(link)))
    for k, bank in enumerate(banks):
        own = [place[name] for name in bank]
        pairs = [(a, b) for i, a in enumerate(own) for b in own[i + 1 :]]
        link, number = link + pairs, number + [len(links) + k] * len(pairs)
    return _measured(np.array(link, np.int64), np.array(number, np.int64), found)


def _measured(link: Ints, number: Ints, found: Distances) -> LinkedSegments:
    """Those whose length is known, of 1 mm and more."""
    a, b = link[:, 0], link[:, 1]
    with np.errstate(invalid="ignore"):
        use = (found.frames[a, b] >= FEWEST) & (found.mean[a, b] >= 1.0) & np.isfinite(found.spread[a, b])
    a, b = a[use], b[use]
    return LinkedSegments(link[use], number[use], found.mean[a, b], found.spread[a, b])
