"""The directions of segments: angles that any recording has, without names and without a model.

A segment is a line between two markers that keep their distance. With e₁, e₂ perpendicular to the line of length ℓ, its
two turns change with its ends by

    J = ± e_kᵀ / ℓ                                                       (1)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..data.array_types import Floats
from ..geometry.rigid_pairs import distances
from ..numerics.vectors import perpendicular_pair
from .sample_frames import SampledFrames


@dataclass(frozen=True, slots=True)
class Rigid:
    """What counts as a segment.

    Attributes:
        spread_mm, spread_share: the standard deviation of its length may be this, or this part of the length.
        length_mm: least and greatest length.
    """

    spread_mm: float = 4.0
    spread_share: float = 0.02
    length_mm: tuple[float, float] = (100.0, 700.0)


RIGID = Rigid()
FEWEST = 10  # frames that must have both markers; chosen


def segments(there: SampledFrames, method: Rigid = RIGID) -> list[tuple[int, int]]:
    """Pairs of markers that keep their distance: for each marker its steadiest partner, each pair once."""
    known = distances(there.xyz, most_frames=there.xyz.shape[1])
    found: dict[tuple[int, int], float] = {}
    for a, b in np.argwhere(np.triu(known.frames >= FEWEST, 1)).tolist():
        median = float(np.nanmedian(np.linalg.norm(there.xyz[a] - there.xyz[b], axis=1)))
        low, high = method.length_mm
        if low <= median <= high and known.spread[a, b] <= max(method.spread_mm, method.spread_share * median):
            found[a, b] = float(known.spread[a, b])
    best = {m: min((p for p in found if m in p), key=lambda p: found[p], default=None) for m in range(len(there.xyz))}
    return sorted({pair for pair in best.values() if pair is not None})


def segment_jacobian(xyz: Floats, pairs: list[tuple[int, int]]) -> Floats:
    """(F, 2 · pairs, M, 3) deg/mm of the two turns of each segment, by (1); NaN where an end is missing."""
    M, F, _ = xyz.shape
    J = np.zeros((F, 2 * len(pairs), M, 3))
    for k, (a, b) in enumerate(pairs):
        line = xyz[b] - xyz[a]
        length = np.linalg.norm(line, axis=1, keepdims=True)
        direction = line / length
        for i, e in enumerate(np.moveaxis(perpendicular_pair(direction), -1, 0)):
            J[:, 2 * k + i, b] = np.degrees(e / length)  # (1)
            J[:, 2 * k + i, a] = -J[:, 2 * k + i, b]
    return J
