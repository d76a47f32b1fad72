"""Which groups of some images are markers, by their size, and which are strobes or specks.

Markers on each other and bits of hidden ones say nothing of the size of a marker. So only groups count that have the
median ratio of width to height within a factor `ROUND`, and fill their rectangle at least by `FILL`; small ones, with
their rough rims, by a little less: √area pixels (1).

The logarithms of their areas fall into clusters with empty stretches between them: two neighbours in order belong to
different clusters if the larger has at least `RATIO` times the area of the smaller (2). The markers are the cluster
of most groups, together with the next ones, up and down, that have at least a `FEW`th as many (3): in a calibration
volume there are near and far markers by the dozen, but few strobes. A limit between markers and others lies between
the areas on both sides, in the logarithm half-way to specks and three quarters of the way to strobes (4), but no nearer
than `TWO` times the greatest marker, so that two on each other are not called a strobe, nor one that moves fast (5);
where there are no others, it is `ROOM` times beyond the markers (6).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .grouping import PixelGroups

ROUND = 1.35  # factor between widths by heights of one kind of marker; chosen
FILL = 0.65  # of its rectangle that a disc fills (π/4 is 0.785); chosen, with room for pixels
RATIO = 1.8  # of areas between clusters of sizes; chosen
FEW = 4  # 1 part in so many of the most frequent size; chosen
TWO = 2.1  # times the greatest marker's area: two on each other; chosen, with 5 % of room
ROOM = 3.0  # times a marker's area, where there is nothing else; chosen


class Sizes(NamedTuple):
    """Of markers: least, median and greatest area, px²; median width and height, px, and ratio of long to short side.

    Of the others: specks and strobes a frame, and the share of frames with strobes; low and high: the limits of area
    between which markers are, px².
    """

    least: float
    area: float
    greatest: float
    width: float
    height: float
    aspect: float
    specks: float
    strobes: float
    strobe_frames: float
    low: float
    high: float


def marker_sizes(groups: PixelGroups, *, height: int, width: int, frames: int) -> Sizes | None:
    """Sizes of the markers among groups of frames of this height and width, px; None where there is no group."""
    inside = (groups.left > 0) & (groups.right < width - 1)
    inside &= (groups.top % height > 0) & (groups.bottom % height < height - 1)
    some = groups.keep(inside) if inside.any() else groups
    if len(some.area) == 0:
        return None
    some = some.keep(_round(some))
    order = np.sort(some.area).astype(np.float64)
    first, last = _markers(order)
    markers = some.keep((some.area >= order[first]) & (some.area <= order[last]))
    w, h = (markers.right - markers.left + 1), (markers.bottom - markers.top + 1)
    return Sizes(
        least=float(order[first]),
        area=float(np.median(markers.area)),
        greatest=float(order[last]),
        width=float(np.median(w)),
        height=float(np.median(h)),
        aspect=float(np.median(np.maximum(w, h) / np.minimum(w, h))),
        specks=first / frames,
        strobes=(len(order) - 1 - last) / frames,
        strobe_frames=len(np.unique(some.top[some.area > order[last]] // height)) / frames,
        low=_limit(order, first, -1),
        high=_limit(order, last, 1),
    )


def _round(groups: PixelGroups) -> NDArray[np.bool_]:
    """(G) whether a group has the shape that most have; (1)."""
    w, h = groups.right - groups.left + 1.0, groups.bottom - groups.top + 1.0
    usual = np.abs(np.log(w / h) - np.median(np.log(w / h))) <= np.log(ROUND)
    shaped = usual & (groups.area + np.sqrt(groups.area) >= FILL * w * h)
    return shaped if shaped.any() else usual


def _markers(order: NDArray[np.float64]) -> tuple[int, int]:
    """First and last index, among sorted areas, of the markers; (2) (3)."""
    cuts = np.flatnonzero(order[1:] >= RATIO * order[:-1]) + 1
    ends = np.concatenate([[0], cuts, [len(order)]])
    number = np.diff(ends)
    first = last = int(np.argmax(number))
    few = number[first] / FEW
    while first > 0 and number[first - 1] >= few:
        first -= 1
    while last < len(number) - 1 and number[last + 1] >= few:
        last += 1
    return int(ends[first]), int(ends[last + 1] - 1)


def _limit(order: NDArray[np.float64], edge: int, side: int) -> float:
    """The limit beyond the markers' least (side −1) or greatest (1) area."""
    beyond = edge + side
    if 0 <= beyond < len(order):
        way = 0.75 if side > 0 else 0.5
        between = float(order[edge] ** (1 - way) * order[beyond] ** way)  # (4)
        return max(between, TWO * float(order[edge])) if side > 0 else between  # (5)
    return float(order[edge] * ROOM**side)  # (6)
