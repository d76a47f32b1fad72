"""Tables of the study of probable errors: whether what is said is true, with intervals.

Problems of one recording are not independent, so that intervals of 95 % are those of drawing recordings again
(bootstrap), with all that was made of one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from kinemark.data.array_types import Floats

BINS = (0.0, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 1.0001)
DRAWN = 2000  # times that recordings are drawn again


class Judged(NamedTuple):
    """A problem: the recording, its kind, what was said, whether it is one, and whether it is worth a look."""

    recording: str
    kind: str
    wrong: float
    true: bool
    asked: bool


def auc(wrong: Floats, y: Floats) -> float:
    rank = scipy.stats.rankdata(wrong)
    n = y.sum()
    return float((rank[y > 0].sum() - n * (n + 1) / 2) / (n * (len(y) - n)))


def table(kind: str, rows: list[Judged]) -> None:
    wrong, y = np.array([row.wrong for row in rows]), np.array([float(row.true) for row in rows])
    if not 0 < y.sum() < len(y):
        return
    cells = []
    for low, high in pairwise(BINS):
        mine = (wrong >= low) & (wrong < high)
        cells.append(f"{wrong[mine].mean():.2f}→{y[mine].mean():.2f} ({mine.sum()})" if mine.any() else "–")
    print(f"  {kind:6} {len(y):5} {y.sum():4.0f} wrong, area {auc(wrong, y):.3f}; said→true: {'  '.join(cells)}")


def classes(rows: Sequence[Judged]) -> None:
    """By how much more of the classes of all problems is true than was said."""
    cells = []
    for low, high in pairwise(BINS):
        mine = [row for row in rows if low <= row.wrong < high]
        if mine:
            cells.append(f"{off(sums(mine).sum(0)):+.2f} ({interval(mine, off)})")
    print("  true less said:        " + "  ".join(cells))


def sums(rows: Sequence[Judged]) -> Floats:
    """(recordings, 3) of each recording how many problems, how many were said to be wrong, and how many are."""
    of: dict[str, list[tuple[float, float, float]]] = {}
    for row in rows:
        of.setdefault(row.recording, []).append((1.0, row.wrong, float(row.true)))
    return np.array([np.sum(some, axis=0) for some in of.values()]).reshape(-1, 3)


def off(of: Floats) -> Floats:
    """How many more (…, 3) are wrong than was said, a problem."""
    return (of[..., 2] - of[..., 1]) / np.maximum(of[..., 0], 1)


def ratio(of: Floats) -> Floats:
    """How many times as many (…, 3) were said to be wrong as are."""
    return of[..., 1] / np.maximum(of[..., 2], 1)


def interval(rows: Sequence[Judged], figure: Callable[[Floats], Floats]) -> str:
    """95 % of a figure."""
    each, rng = sums(rows), np.random.default_rng(0)
    drawn = figure(each[rng.integers(len(each), size=(DRAWN, len(each)))].sum(1))
    return " to ".join(f"{value:.2f}" for value in np.quantile(drawn, (0.025, 0.975)))
