"""Forward and backward prediction that meet in the middle of a gap (Swamidas 1997, 5.2).

"The prediction would only run for half of the interval when the marker is missing, i.e., the forward prediction and
backward prediction would start at the two ends of the interval and meet in the middle."

The recording is tracked with tracks that end where no point is found, and begin where a point is left: pieces without a
gap. Of each piece the predictor is run through to its end, and through its frames reversed to its beginning. A piece
that ends in frame e and one that begins in s > e meet in the frame m half way, where the one is predicted at x₁ with
the variance P₁ of each coordinate, and the other at x₂ with P₂. Up to a constant

    c = |x₁ − x₂|² / V + 3 ln V,    V = P₁ + P₂                          (1)

is −2 times the log-likelihood that they are one marker. Pieces are joined so that as many as possible are, at the least
sum of (1): each end with one beginning. The constraints of the forward tracking have no part in it. Velocities at m are
left out: by constant acceleration they are so far off that they do more harm than good (studies/swamidas.py).

With an angle model that has placed the marker from both ends (`guided_meeting`), places are known all through the gap,
and not only in its middle, where two markers may cross: (1) is then the mean over the frames that both have.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...data import Cloud, Tracks
from ...data.array_types import Floats, Ints
from ...signal.assignment import assign
from ...signal.kalman import KalmanState, follow, predict
from .swamidas_method import Swamidas

SHORTEST = 3
"""Points that a state of position, velocity and acceleration needs; by definition."""


class Join(NamedTuple):
    """A piece and the one that goes on with its marker: last frame e and first frame s, and what is predicted of the
    frames between, xyz (s − e − 1, 3) mm, the first half forwards and the second backwards."""

    piece: int
    next: int
    last: int
    first: int
    xyz: Floats


class Piece(NamedTuple):
    """The rows of a track, its first and last frame, and the states one frame before and after it."""

    rows: Ints
    first: int
    last: int
    before: KalmanState
    after: KalmanState


class Way(NamedTuple):
    """What is predicted from one end of a gap: xyz (n, 3) mm, frame by frame away from the end, and the variance (n, 3)
    mm²; NaN in frames that it says nothing of."""

    xyz: Floats
    variance: Floats

    def on(self, n: int) -> Way:
        """Of so many frames, NaN beyond what it says."""
        more = np.full((n - len(self.xyz), 3), np.nan)
        return Way(np.concatenate([self.xyz, more]), np.concatenate([self.variance, more]))

    def reversed(self) -> Way:
        """The frames in the reverse order."""
        return Way(self.xyz[::-1], self.variance[::-1])


Guide = Callable[[Piece, int], Way | None]
"""What an angle model says of so many frames beyond a piece; None where its pass takes a point in them."""


class Guides(NamedTuple):
    """The model's words beyond the last frame of a piece, and before its first."""

    forward: Guide
    backward: Guide


def pieces_of(tracks: Tracks, sd: float, process_sd: float) -> list[Piece]:
    """The tracks that have three points in a row; σ and U of the predictor, mm and mm/frame²."""
    cloud, found = tracks.cloud, []
    frame = cloud.frame
    for identity in range(len(tracks)):
        rows = np.flatnonzero(tracks.id == identity)
        if len(rows) < SHORTEST:
            continue
        path = np.full((frame[rows[-1]] - frame[rows[0]] + 1, 3), np.nan)
        path[frame[rows] - frame[rows[0]]] = cloud.xyz[rows]
        after, before = follow(path, sd, process_sd), follow(path[::-1], sd, process_sd)
        if after is not None and before is not None:
            found.append(Piece(rows, int(frame[rows[0]]), int(frame[rows[-1]]), before, after))
    return found


def joins(pieces: list[Piece], process_sd: float, *, longest: float, guides: Guides | None = None) -> list[Join]:
    """Which pieces go on with which, over gaps of at most `longest` frames; `guides` are those of a model."""
    cost = np.full((len(pieces), len(pieces)), np.inf)
    for i, one in enumerate(pieces):
        for j, other in enumerate(pieces):
            if 0 < other.first - one.last - 1 <= longest:
                cost[i, j] = _cost(one, other, process_sd, guides)
    finite = np.isfinite(cost)
    if not finite.any():
        return []
    cost -= cost[finite].min()  # of a likelihood only differences count, and the assignment wants none below 0
    rows, columns = assign(cost, np.full(len(pieces), np.finfo(float).max))
    return [
        Join(i, j, pieces[i].last, pieces[j].first, _bridge(pieces[i], pieces[j], process_sd, guides))
        for i, j in zip(rows.tolist(), columns.tolist(), strict=True)
    ]


def _ways(one: Piece, other: Piece, process_sd: float, guides: Guides | None) -> tuple[Way, Way]:
    """By the model all through the gap; else from e + 1 to m forwards, and from s − 1 down to m backwards."""
    n = other.first - one.last - 1
    there, back = (guides.forward(one, n), guides.backward(other, n)) if guides else (None, None)
    if there and back and np.isfinite(there.variance + back.reversed().variance).any():
        return there, back
    middle = (one.last + other.first) // 2
    return (
        _coasting(one.after, max(middle - one.last, 1), process_sd),
        _coasting(other.before, max(other.first - middle, 1), process_sd),
    )


def _coasting(state: KalmanState, n: int, process_sd: float) -> Way:
    states = [state]
    for _ in range(n - 1):
        states.append(predict(states[-1], process_sd))
    variance = [np.full(3, one.P[0, 0, 0]) for one in states]
    return Way(np.array([one.x[0, 0] for one in states]), np.array(variance))


def _cost(one: Piece, other: Piece, process_sd: float, guides: Guides | None) -> float:
    """(1), summed over the coordinates, whose variances may differ; the mean over the frames that both ways have."""
    n = other.first - one.last - 1
    forward, backward = _ways(one, other, process_sd, guides)
    there, back = forward.on(n), backward.on(n).reversed()
    V = there.variance + back.variance  # NaN but in the middle, where no model speaks
    each = ((there.xyz - back.xyz) ** 2 / V + np.log(V)).sum(1)
    return float(np.nanmean(each))


def _bridge(one: Piece, other: Piece, process_sd: float, guides: Guides | None) -> Floats:
    """(L, 3) mm what is predicted of the frames between: the first half forwards, the second backwards."""
    forward, backward = _ways(one, other, process_sd, guides)
    n, half = other.first - one.last - 1, max((one.last + other.first) // 2 - one.last, 1)
    return np.concatenate([forward.xyz[:half], backward.xyz[: n - half][::-1]])


def joined(cloud: Cloud, pieces: list[Piece], found: list[Join], *, begun_by: int | None) -> NDArray[np.int64]:
    """(P) identities of the rows: of the chains of pieces, in their order.

    Args:
        cloud: the rows. pieces, found: of it.
        begun_by: the last frame in which a chain may begin; None: any.
    """
    identity, chain = np.full(len(cloud), -1), np.arange(len(pieces))
    for join in sorted(found, key=lambda join: join.first):
        chain[join.next] = chain[join.piece]
    for k, piece in enumerate(pieces):
        if begun_by is None or pieces[chain[k]].first <= begun_by:
            identity[piece.rows] = chain[k]
    return identity


def without_coasting(method: Swamidas, rate: float) -> Swamidas:
    """The method whose tracks are the pieces."""
    alone = replace(method, angle_model=None, model=None)
    return replace(alone, direction="forward", initiate_from="any", max_coasting=0.5 / rate)
