"""Which markers are the left and the right one of a landmark: by their names, or by the body's symmetry."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import scipy

from ..data.array_types import Floats, Ints
from ..data.marker_sides import sides_by_name

LEAST_SHARE = 0.05
"""Of the body's size: how far the mirror image of a marker may be from its partner; chosen."""
AXES = 5
"""Of the space in which mean distances are embedded; chosen: a body that moves needs more than three."""
LEAST_PAIRED = 0.7
"""Share of the markers that a body's mirror image must find again, in pairs or in the middle; chosen."""


def mirrored(names: tuple[str, ...]) -> Ints:
    """(L) the label of each name's other side; its own where it has none."""
    number = {name: a for a, name in enumerate(names)}
    out = np.arange(len(names))
    for one, other in sides_by_name(names):
        out[[number[one], number[other]]] = number[other], number[one]
    return out


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
        if 0 <= a < b:
            side = np.nanmean((xyz[a] - xyz[b]) @ left)
            pairs.append((names[a], names[b]) if side > 0 else (names[b], names[a]))
    return tuple(pairs)


def mirror_partners(mean: Floats) -> list[int] | None:
    """Of M markers the partner of each in the body's mirror image, itself for one in the middle; None without symmetry.

    The mean distances are embedded in a space (classical scaling) whose axes each stay as they are or change their sign
    when left and right do. Of all ways to change signs the one counts whose image lies nearest to the markers and in
    which most of them have a partner.
    """
    if not np.isfinite(mean).all() or len(mean) < 4:
        return None
    x = _embedded(mean)
    reach = LEAST_SHARE * float(mean.max())
    best, found = np.inf, None
    for signs in itertools.product((1.0, -1.0), repeat=x.shape[1]):
        d = np.linalg.norm((x * signs)[:, None] - x[None], axis=-1)
        to = scipy.optimize.linear_sum_assignment(np.minimum(d, 2 * reach))[1]
        own = np.arange(len(x))
        partner = np.where((to[to] == own) & (d[own, to] < reach), to, -1)
        cost = float(np.minimum(d[own, to], 2 * reach).mean())
        if cost < best and (partner >= 0).mean() >= LEAST_PAIRED and (partner != own).mean() >= LEAST_PAIRED / 2:
            best, found = cost, partner
    return None if found is None else [int(b) for b in found]


def _embedded(mean: Floats) -> Floats:
    """(M, n) places with nearly these distances, on the `AXES` along which they reach farthest."""
    centred = np.eye(len(mean)) - 1 / len(mean)
    value, vector = np.linalg.eigh(-0.5 * centred @ (mean**2) @ centred)
    return np.asarray(vector[:, -AXES:] * np.sqrt(np.maximum(value[-AXES:], 0.0)))


def _left(xyz: Floats, size: float) -> Floats | None:
    """(3) to the left of one who walks; None where the body goes less than half its size."""
    middle = np.nanmean(xyz, 0)
    seen = middle[np.isfinite(middle).all(1)]
    way = (seen[-1] - seen[0]) * [1, 1, 0] if len(seen) else np.zeros(3)
    length = np.linalg.norm(way)
    return np.cross([0.0, 0.0, 1.0], way / length) if length > 0.5 * size else None
