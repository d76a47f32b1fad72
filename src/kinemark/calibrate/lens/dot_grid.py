"""Which dot of a picture is which point of a plane grid (KISS 3.2: 300 points in 15 rows and 20 columns).

The dots' lattice is grown from the points alone (`lattice`). Its axes are fixed up to whole shears, turns and
mirroring: node q becomes U q with an integer matrix U of determinant ±1 (1). Of all U that keep the handedness of the
picture (a camera sees a grid from its front), the one is right for which most nodes fall into a window of
`rows` × `columns` (2). Where several do, as the half turn always does, that one is taken whose rows run most to the
right as seen, so that the first point is the top left one (3).

A window whose border lines are mostly empty shows a part of the grid, and which part nobody can tell; a full line
beside the window shows a larger grid. Both are refused (4). For a lens a part is enough: `part_of_grid`.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from ...data import KinemarkError
from ...data.array_types import Floats, Ints
from .lattice import grow_lattice

FEWEST_SHARE = 0.6  # of the grid's dots that must be seen; chosen (see studies/linearisation.py)
HALF = 0.5  # of a line's dots; an outer line with fewer is no line of the grid; chosen (see studies/linearisation.py)
MOST_POINTS = 5000  # images of a camera at most; chosen, lest noise take minutes (see studies/linearisation.py)
TURNS = [np.array(u).reshape(2, 2) for u in product(range(-2, 3), repeat=4) if abs(u[0] * u[3] - u[1] * u[2]) == 1]
"""The U of (1); by definition."""


def order_grid(uv: Floats, *, columns: int, rows: int) -> Ints:
    """Which of the points (n, 2) px is at which place of a plane grid: (rows, columns) index into `uv`, −1 for none.

    As seen, rows run to the right and follow each other downwards, so [0, 0] is the top left dot; where rows run
    straight up or down, that one of two ways that points a little more to the right. Points that are NaN, or on no
    place of the grid, are passed over.

    Raises:
        ValueError: `columns` or `rows` is below 3, or `uv` is not (n, 2).
        KinemarkError: there is no such grid, only a part of it, or a larger one; the message says what was found.
    """
    if min(columns, rows) < 3:
        raise ValueError(f"columns and rows are {columns} and {rows}, wanted at least 3 each")
    nodes, point, A = _lattice(uv, columns * rows)
    want = f"{rows} rows × {columns} columns"
    if len(point) < FEWEST_SHARE * rows * columns:
        raise KinemarkError(
            f"Among {len(uv)} points, {len(point)} form a grid, and one of {want} has {rows * columns}. Check the "
            "numbers of rows and columns, the threshold, and whether the whole grid is in the picture."
        )
    turn, corner = _placed(nodes, A, (rows, columns))
    q = nodes @ turn.T - corner
    _refuse_other_sizes(q, (rows, columns), want)
    inside = ((q >= 0) & (q < (rows, columns))).all(1)
    index = np.full((rows, columns), -1, np.int64)
    index[tuple(q[inside].T)] = point[inside]
    return index


def part_of_grid(uv: Floats) -> Ints:
    """As `order_grid` for a grid of unknown size, of which any part is seen: (R, C) index into `uv`, −1 for none.

    Which part it is remains unknown, and whether rows are the grid's rows or its columns; a lens does not ask.

    Raises:
        ValueError: `uv` is not (n, 2).
        KinemarkError: no lattice of 9 points or more is among the points.
    """
    nodes, point, A = _lattice(uv, None)
    if len(point) < 9:
        raise KinemarkError(
            f"Among {len(uv)} points, no grid is found. Check the threshold and what is in the picture."
        )
    boxes = [np.ptp(nodes @ turn.T, axis=0) + 1 for turn in TURNS]
    smallest = min(int(box.prod()) for box in boxes)
    tight = [turn for turn, box in zip(TURNS, boxes, strict=True) if box.prod() == smallest]
    turn = max(tight, key=lambda turn: _row_direction(A, turn))
    q = nodes @ turn.T
    q = q - q.min(0)
    index = np.full(q.max(0) + 1, -1, np.int64)
    index[tuple(q.T)] = point
    return index


def _lattice(uv: Floats, enough: int | None) -> tuple[Ints, Ints, Floats]:
    """Nodes (m, 2) of the lattice, their rows (m) of `uv`, and the mean cell A (2, 2): d uv / d node."""
    if uv.ndim != 2 or uv.shape[1] != 2:
        raise ValueError(f"uv has shape {uv.shape}, wanted (n, 2)")
    finite = np.flatnonzero(np.isfinite(uv).all(1)).astype(np.int64)
    if len(finite) > MOST_POINTS:
        raise KinemarkError(
            f"{len(finite)} points are seen, and a grid has {enough or 'some hundred'}. Raise the threshold, or limit "
            "the size of markers."
        )
    index = grow_lattice(uv[finite], enough=enough)
    nodes = np.argwhere(index >= 0).astype(np.int64)
    point = finite[index[index >= 0]]
    if len(point) < 9:
        return nodes, point, np.eye(2)
    A = np.linalg.lstsq(np.column_stack([nodes, np.ones(len(nodes))]), uv[point])[0][:2].T
    return nodes, point, np.asarray(A, np.float64)


def _placed(nodes: Ints, A: Floats, shape: tuple[int, int]) -> tuple[Ints, Ints]:
    """U of (1) and the window's first node (2), by (2) and (3)."""
    best: tuple[float, float] = (-1.0, -2.0)
    chosen = (TURNS[0], nodes[0])
    for turn in TURNS:
        rightness = _row_direction(A, turn)
        if rightness < -1:
            continue
        corner, count = _window(nodes @ turn.T, shape)
        if (count, rightness) > best:
            best, chosen = (count, rightness), (turn, corner)
    return chosen


def _row_direction(A: Floats, turn: Ints) -> float:
    """Cosine between +u and the rows as seen once node q is U q; below −1 where the picture would be mirrored."""
    down, right = (A @ np.linalg.inv(turn)).T
    mirrored = right[0] * down[1] - right[1] * down[0] <= 0
    return -2.0 if mirrored else float(right[0] / np.linalg.norm(right))


def _window(q: Ints, shape: tuple[int, int]) -> tuple[Ints, int]:
    """The first node (2) of the window of this shape that holds most nodes (m, 2), and how many."""
    low = q.min(0) - shape
    full = np.zeros(q.max(0) - low + 1 + shape, np.int64)
    full[tuple((q - low).T)] = 1
    total = np.pad(full.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    r, c = shape
    held = total[r:, c:] - total[:-r, c:] - total[r:, :-c] + total[:-r, :-c]
    corner = np.array(np.unravel_index(held.argmax(), held.shape))
    return corner + low, int(held.max())


def _refuse_other_sizes(q: Ints, shape: tuple[int, int], want: str) -> None:
    """(4) for nodes (m, 2) relative to the window."""
    inside = ((q >= 0) & (q < shape)).all(1)
    for axis, name in ((0, "row"), (1, "column")):
        n, across = shape[axis], shape[1 - axis]
        along_window = (q[:, 1 - axis] >= 0) & (q[:, 1 - axis] < across)
        lines = np.bincount(q[inside, axis], minlength=n)
        empty = [k + 1 for k in (0, n - 1) if lines[k] < HALF * across]
        beyond = [k for k in (-1, n) if (along_window & (q[:, axis] == k)).sum() >= HALF * across]
        if beyond:
            raise KinemarkError(
                f"The grid in the picture is larger than {want}: it has another {name} with "
                f"{(along_window & (q[:, axis] == beyond[0])).sum()} points. Check the numbers of rows and columns."
            )
        if empty:
            raise KinemarkError(
                f"{inside.sum()} of {shape[0] * shape[1]} points of the grid of {want} are found, and of its {name} "
                f"{empty[0]} only {lines[empty[0] - 1]} of {across}: the grid in the picture is smaller or cut, and "
                "which part is seen is unknown. Take in the whole grid, or check the numbers of rows and columns."
            )
