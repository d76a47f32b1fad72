"""What an angle model says of the two halves of a gap (Swamidas 1997, 3.5.2 and 5.2 together).

The recording is tracked with the model in the loop once forwards and once backwards (`angle_guide`). Where a track of
the forward pass is without points from the end of a piece to the beginning of another, what that pass expects in the
frames between is the way from that end, and of the backward pass the way from the other end. In frames in which the
model has placed the marker,

    P = (h / 3)²                                                         (1)

is the variance of a coordinate, with h half the box about the corrected place, which is made of three standard
deviations ((1) of `angle_guide`); in others (the first of a gap, when no pass knows yet that the marker is missing)
there is none. A track that has taken a point between says nothing of this gap; the predictor alone does then.
"""

from __future__ import annotations

import numpy as np

from .angle_guide import SIDES
from .meeting import Guide, Guides, Piece, Way
from .predictions import SwamidasResult


def guides_of(forward: SwamidasResult, backward: SwamidasResult) -> Guides:
    """The model's words by the two passes over the same points."""
    return Guides(_guide(forward, step=1), _guide(backward, step=-1))


def _guide(passed: SwamidasResult, *, step: int) -> Guide:
    """Of one pass, beyond the last point of a piece (step 1) or before its first (−1)."""
    frame = passed.tracks.cloud.frame
    taken = set(zip(passed.tracks.id.tolist(), frame.tolist(), strict=True))
    rows = [{int(i): k for k, i in enumerate(one.id)} for one in passed.expected]

    def way(piece: Piece, n: int) -> Way | None:
        row = piece.rows[-1 if step > 0 else 0]
        track = int(passed.tracks.id[row])
        frames = [int(frame[row]) + step * k for k in range(1, n + 1)]
        if track < 0 or any(track not in rows[f] or (track, f) in taken for f in frames):
            return None
        expected, at = [passed.expected[f] for f in frames], [rows[f][track] for f in frames]
        xyz, half, placed = (
            np.array([getattr(one, name)[k] for one, k in zip(expected, at, strict=True)])
            for name in ("xyz", "half", "placed")
        )
        return Way(xyz, np.where(placed[:, None], (half / SIDES) ** 2, np.nan))

    return way
