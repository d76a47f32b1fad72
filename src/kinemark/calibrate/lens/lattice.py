"""Points of a picture that form a lattice: growing it from a seed, cell by cell.

A plane grid seen by a camera is no regular lattice: perspective shrinks it, the lens bends it. But over a few cells it
nearly is one, and only that is used. Each node (i, j) has a place p(i, j) in the image, and round any node

    p(i, j) ≈ p0 + A (i, j)ᵀ                                             (1)  to first order
    p(i, j) ≈ p0 + A (i, j)ᵀ + B (i², i j, j²)ᵀ + C (i³, i² j, i j², j³)ᵀ  (2)  to third order

1. Seed: a point in the middle of two pairs of opposite neighbours ±a, ±b, the shortest two that are not in line, whose
   corners ±a ± b are there as well.
2. Growth: every empty node beside a filled one gets a place by (1), fitted to the filled nodes at most two cells away;
   the nearest free point takes it if it is less than `REACH` cells off. What is missing stays empty and is gone round.
3. Settling: each node is predicted by (2) from the nodes round it but itself; the nearest point within a tolerance that
   follows the scatter takes it, or none. So a reflection beside a dot loses the dot's place.

Distances are measured in cells, |A⁻¹ (p − p̂)|, so that a grid seen at a slant is judged alike in both directions.
"""

from __future__ import annotations

import numpy as np
import scipy

from ...data.array_types import Bools, Floats, Ints

REACH = 0.3
"""Of a cell's side; a point may be so far from where the lattice expects it; chosen (see studies/linearisation.py)."""
OPPOSITE = 0.25  # of a step's length; two steps that cancel to this are opposite; chosen (see studies/linearisation.py)
NEIGHBOURS = 16  # of each point, among which its cell is looked for; chosen (see studies/linearisation.py)
SEEDS = 8  # blocks that are grown at most; chosen for speed
WINDOW, NEAR = 3, 2
"""Cells; half width of the polynomial's window, of degree three and of one; chosen (see studies/linearisation.py)."""
SETTLED = (0.08, 0.15)
"""Of a cell's side, least and greatest tolerance at the end; chosen (see studies/linearisation.py)."""
FULL = 0.95  # of the points, with which a lattice is taken at once; chosen (see studies/linearisation.py)

_OFFSETS = (np.indices((2 * WINDOW + 1, 2 * WINDOW + 1)) - WINDOW).reshape(2, -1).T
"""Cells of the window, about its middle; by definition."""
_WEIGHT = 1.0 / (1.0 + (_OFFSETS**2).sum(1)) * (_OFFSETS != 0).any(1)
"""Of each cell, falling with its distance in cells; chosen (see studies/linearisation.py)."""
_POWERS = [(a, n - a) for n in range(4) for a in range(n, -1, -1)]
"""Of a polynomial of degree three in two variables; by definition."""
_TERMS = np.stack([1.0 * _OFFSETS[:, 0] ** a * _OFFSETS[:, 1] ** b for a, b in _POWERS], 1)
"""Its terms at `_OFFSETS`; by definition."""


def grow_lattice(uv: Floats, *, enough: int | None = None) -> Ints:
    """The largest lattice among points (n, 2) px: which point is at which node, (I, J) rows of `uv`, −1 for none.

    The axes are two edges of its cells, in no particular order or direction; a parallelogram of dots may be sheared
    by whole cells. Without any lattice the result has no nodes, (0, 0).

    Args:
        uv: (n, 2) finite.
        enough: growth stops when a seed reaches so many points; by default nearly all of them.
    """
    best = np.zeros((0, 0), np.int64)
    enough = enough or int(FULL * len(uv))
    tree = scipy.spatial.KDTree(uv) if len(uv) >= 9 else None
    if tree is None:
        return best
    visited: Bools = np.zeros(len(uv), np.bool_)
    for seed in _seeds(uv, tree):
        if visited[seed[1, 1]]:
            continue  # it lies in a lattice that has been grown
        index = confirmed_nodes(_grown(uv, tree, seed), uv, tree)
        visited[index[index >= 0]] = True
        if (index >= 0).sum() > (best >= 0).sum():
            best = index
        if (best >= 0).sum() >= enough:
            break
    return best


def _seeds(uv: Floats, tree: scipy.spatial.KDTree) -> list[Ints]:
    """Blocks of 3 × 3 points that look most like a lattice, the best first."""
    near = np.atleast_2d(tree.query(uv, k=min(NEIGHBOURS + 1, len(uv)))[1])[:, 1:]
    found = []
    for k in range(len(uv)):
        block = _block(uv, tree, k, near[k])
        if block is not None:
            found.append(block)
    found.sort(key=lambda item: item[0])
    return [block for _, block in found[: SEEDS * 4]]


def _block(uv: Floats, tree: scipy.spatial.KDTree, k: int, near: Ints) -> tuple[float, Ints] | None:
    """The 3 × 3 points about point k, and how far they are from a lattice, in cells."""
    d = uv[near] - uv[k]
    first, second = np.triu_indices(len(near), 1)
    axis, length = (d[first] - d[second]) / 2, np.linalg.norm(d[first] - d[second], axis=1) / 2
    opposite = np.flatnonzero(np.linalg.norm(d[first] + d[second], axis=1) < OPPOSITE * length)
    opposite = opposite[np.argsort(length[opposite])]
    if len(opposite) < 2:
        return None
    a = axis[opposite[0]]
    across = np.abs(axis[opposite] @ np.array([a[1], -a[0]])) / (length[opposite] * np.linalg.norm(a))
    others = opposite[across > 0.2]
    if len(others) == 0:
        return None
    A = np.column_stack([a, axis[others[0]]])
    steps = (np.indices((3, 3)) - 1).reshape(2, -1).T
    place = uv[k] + steps @ A.T
    taken = np.asarray(tree.query(place)[1], np.int64)
    distance = np.linalg.norm((uv[taken] - place) @ np.linalg.inv(A).T, axis=1)
    if distance.max() > 1.3 * REACH or len(set(taken.tolist())) < 9:
        return None
    return float(distance.max()), taken.reshape(3, 3)


def _grown(uv: Floats, tree: scipy.spatial.KDTree, seed: Ints) -> Ints:
    """Step 2."""
    index, used = np.pad(seed, WINDOW + 1, constant_values=-1), np.zeros(len(uv), np.bool_)
    used[seed] = True
    while True:
        nodes = _beside(index)
        place, A, known = _predict(index, uv, nodes, curved=False)
        nodes, place, A = nodes[known], place[known], A[known]
        added = _take(index, used, uv, tree, nodes, place, A, REACH)
        if added == 0:
            return _trimmed(index)
        index = np.pad(_trimmed(index), WINDOW + 1, constant_values=-1)


def confirmed_nodes(index: Ints, uv: Floats, tree: scipy.spatial.KDTree) -> Ints:
    """Step 3 for nodes (I, J): places confirmed, replaced, given up, or filled within the lattice."""
    for _ in range(3):
        index = np.pad(_trimmed(index), WINDOW + 1, constant_values=-1)
        inner = np.argwhere(np.ones_like(index[WINDOW + 1 : -WINDOW - 1, WINDOW + 1 : -WINDOW - 1])) + WINDOW + 1
        place, A, known = _predict(index, uv, inner, curved=True)
        nodes, place, A = inner[known], place[known], A[known]
        here = index[tuple(nodes.T)]
        distance = _cells(uv[here], place, A)[here >= 0]
        tolerance = float(np.clip(8 * np.median(distance), *SETTLED)) if len(distance) else SETTLED[1]
        before, index = index, np.full_like(index, -1)
        _take(index, np.zeros(len(uv), np.bool_), uv, tree, nodes, place, A, tolerance)
        if (index == before).all():
            break
    return _trimmed(index)


def _take(
    index: Ints,
    used: Bools,
    uv: Floats,
    tree: scipy.spatial.KDTree,
    nodes: Ints,
    place: Floats,
    A: Floats,
    reach: float,
) -> int:
    """Fill `nodes` (m, 2) of `index` with the nearest points that are free, in order of distance; how many."""
    if len(nodes) == 0:
        return 0
    near = tree.query(place, k=min(3, len(uv)))[1].reshape(len(nodes), -1)
    distance = np.where(used[near], np.inf, _cells(uv[near], place[:, None], A[:, None]))
    node, choice = np.nonzero(distance < reach)
    order = np.argsort(distance[node, choice])
    added, filled = 0, np.zeros(len(nodes), np.bool_)
    for k, point in zip(node[order], near[node, choice][order], strict=True):
        if not filled[k] and not used[point]:
            index[tuple(nodes[k])] = point
            used[point] = filled[k] = True
            added += 1
    return added


def _beside(index: Ints) -> Ints:
    """(m, 2) empty nodes with a filled one beside them."""
    full = index >= 0
    beside = np.zeros_like(full)
    beside[1:] |= full[:-1]
    beside[:-1] |= full[1:]
    beside[:, 1:] |= full[:, :-1]
    beside[:, :-1] |= full[:, 1:]
    return np.argwhere(beside & ~full)


def _predict(index: Ints, uv: Floats, nodes: Ints, *, curved: bool) -> tuple[Floats, Floats, Bools]:
    """Places (m, 2) of nodes (m, 2) by (1) or (2), A (m, 2, 2), and which are determined (m).

    A little weight against curvature keeps (2) determined where few nodes are near, and then it is (1).
    """
    at = nodes[:, None] + _OFFSETS
    inside = np.asarray((at >= 0) & (at < index.shape)).all(-1)
    point = np.where(inside, index[tuple(np.where(np.expand_dims(inside, -1), at, 0).transpose(2, 0, 1))], -1)
    weight: Floats = np.where(point >= 0, _WEIGHT, 0.0)
    weight *= np.abs(_OFFSETS).max(1) <= (WINDOW if curved else NEAR)
    M = _TERMS[:, : 10 if curved else 3]
    normal = np.einsum("mk,ka,kb->mab", weight, M, M)
    about_mean = normal[:, 1:3, 1:3] - _outer(normal[:, 0, 1:3]) / np.maximum(normal[:, :1, :1], 1e-9)
    known = np.linalg.eigvalsh(about_mean).min(1) > 0.1  # the nodes near are not all on one line
    normal = normal + np.diag([1e-9] * 3 + [1e-3] * (M.shape[1] - 3))
    right = np.einsum("mk,ka,mkc->mac", weight, M, uv[point])
    fitted = np.linalg.solve(normal, right)
    A = fitted[:, 1:3].transpose(0, 2, 1)
    return fitted[:, 0], A, np.asarray(known & (np.abs(np.linalg.det(A)) > 1e-6))


def _cells(uv: Floats, place: Floats, A: Floats) -> Floats:
    """Distance of points (…, 2) from places (…, 2) in cells A (…, 2, 2)."""
    return np.asarray(np.linalg.norm((np.linalg.inv(A) @ (uv - place)[..., None])[..., 0], axis=-1))


def _outer(v: Floats) -> Floats:
    return v[:, :, None] * v[:, None, :]


def _trimmed(index: Ints) -> Ints:
    """`index` without empty rows and columns at its sides."""
    filled = np.argwhere(index >= 0)
    if len(filled) == 0:
        return np.zeros((0, 0), np.int64)
    low, high = filled.min(0), filled.max(0) + 1
    return index[low[0] : high[0], low[1] : high[1]]
