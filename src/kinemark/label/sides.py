"""Which markers are the left and the right one of a landmark: by their names, or by the body's symmetry."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np
import scipy

from ..data.array_types import Floats

Rule = tuple[str, str]
RULES: tuple[Rule, ...] = (
    (r"^((?:.*[:/ ])?)[Ll]eft", r"\1{right}"),
    (r"(?<![A-Za-z])[Ll]eft(?![a-z])", "{right}"),
    (r"Left", "{right}"),
    (r"^((?:.*:)?)L(?=[A-Z0-9_. -])", r"\1{R}"),
    (r"^((?:.*:)?)l(?=[A-Z0-9_. -])", r"\1{R}"),
    (r"(?<=[_. -])L$", "{R}"),
    (r"(?<=[_. -])l$", "{R}"),
    (r"(?<=[a-z0-9])L(?=\d*$)", "{R}"),
    (r"(?<=[A-Z0-9])l(?=\d*$)", "{R}"),
    (r"^L(?=[a-z])", "{R}"),
    (r"(?<=_)L(?=[A-Z_])", "{R}"),
)
"""How names say left, and where "right" stands instead; conventions of the common programs."""
LEAST_SHARE = 0.05
"""Of the body's size: how far the mirror image of a marker may be from its partner; chosen."""
LEAST_PAIRED = 0.7
"""Share of the markers that a body's mirror image must find again, in pairs or in the middle; chosen."""


def sides_by_name(names: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Pairs of left and right names that differ in the side alone; each name in one pair at most.

    The rule that pairs most names comes first, so that LFLL has its partner by how the others are spelt.
    """
    found = [
        [(name, other) for name in names if (other := swapped(name)) is not None and other in names]
        for swapped in map(_swap, RULES)
    ]
    pairs: dict[str, str] = {}
    for rows in sorted(found, key=len, reverse=True):
        for left, right in rows:
            if not {left, right} & ({*pairs} | {*pairs.values()}):
                pairs[left] = right
    return tuple((name, pairs[name]) for name in names if name in pairs)


def _swap(rule: Rule) -> Callable[[str], str | None]:
    """What turns a left name into the right one; None for a name that the rule finds no side in."""
    pattern, template = rule

    def swapped(name: str) -> str | None:
        found = re.search(pattern, name)
        if not found:
            return None
        word = found.group(0)
        capital = word.lstrip(found.group(1) if found.groups() else "")[:1].isupper()
        to = template.format(right="Right" if capital else "right", R="R" if capital else "r")
        return name[: found.start()] + found.expand(to) + name[found.end() :]

    return swapped


def sides_by_shape(names: Sequence[str], mean: Floats, xyz: Floats) -> tuple[tuple[str, str], ...]:
    """Pairs by the symmetry of the mean distances (M, M); none where the body is not symmetric or the side not known.

    The body walks forwards: left is up × the way that it goes. Without a way of a body's size there are no sides.

    Args:
        names: (M). mean: (M, M) mm, NaN where unknown.
        xyz: (M, K, 3) the markers' paths, Z up.
    """
    partner = mirror_partners(mean)
    left = _left(xyz, float(np.nanmax(mean)))
    if partner is None or left is None:
        return ()
    pairs = []
    for a, b in enumerate(partner):
        if a < b:
            side = np.nanmean((xyz[a] - xyz[b]) @ left.T if left.ndim > 1 else (xyz[a] - xyz[b]) @ left)
            pairs.append((names[a], names[b]) if side > 0 else (names[b], names[a]))
    return tuple(pairs)


def mirror_partners(mean: Floats) -> list[int] | None:
    """Of M markers the partner of each in the body's mirror image, itself for one in the middle; None without symmetry.

    The mean distances are embedded in space (classical scaling, Torgerson 1952). The plane between any two markers may
    be that of symmetry; the best is the one whose mirror image lies nearest to the markers.
    """
    if not np.isfinite(mean).all() or len(mean) < 4:
        return None
    x = _embedded(mean)
    size = float(mean.max())
    best, found = np.inf, None
    for a in range(len(x)):
        for b in range(a + 1, len(x)):
            n = x[a] - x[b]
            n = n / max(np.linalg.norm(n), 1e-12)
            image = x - 2 * ((x - (x[a] + x[b]) / 2) @ n)[:, None] * n
            d = np.linalg.norm(image[:, None] - x[None], axis=-1)
            nearest = d.min(1)
            cost = float(np.minimum(nearest, LEAST_SHARE * size).mean())
            if cost < best:
                best, found = cost, d
    if found is None:
        return None
    to = scipy.optimize.linear_sum_assignment(np.minimum(found, LEAST_SHARE * size))[1].tolist()
    partner = [b if to[b] == a and found[a, b] < LEAST_SHARE * size else -1 for a, b in enumerate(to)]
    if np.mean([b >= 0 for b in partner]) < LEAST_PAIRED or all(b in (-1, a) for a, b in enumerate(partner)):
        return None
    return partner


def _embedded(mean: Floats) -> Floats:
    """(M, 3) places with nearly these distances."""
    centred = np.eye(len(mean)) - 1 / len(mean)
    value, vector = np.linalg.eigh(-0.5 * centred @ (mean**2) @ centred)
    return np.asarray(vector[:, -3:] * np.sqrt(np.maximum(value[-3:], 0.0)))


def _left(xyz: Floats, size: float) -> Floats | None:
    """(3) to the left of one who walks; None where the body goes less than half its size."""
    middle = np.nanmean(xyz, 0)
    seen = middle[np.isfinite(middle).all(1)]
    way = (seen[-1] - seen[0]) * [1, 1, 0] if len(seen) else np.zeros(3)
    length = np.linalg.norm(way)
    return np.cross([0.0, 0.0, 1.0], way / length) if length > 0.5 * size else None
