"""A fill tied to the edges of its gap, where the frames beside it could not be learnt from.

A reference marker that is missing beside a gap takes those frames from what is learnt, and nothing ties the fill f to
the marker's last sample before the gap, or the first after it. Let x be the measured sample at such an edge, s the step
to it from the one before, and f₀, f₁ the fill's frames next to it. A smooth motion goes on with the mean of the steps
on both sides, so the fill is off there by

    o = x + (s + f₁ − f₀)/2 − f₀                                                                          (1)

The offsets go on into the gap as the remainder of the method does, with Matérn's covariance M (`kriging`), a tied edge
having the offset 0:

    f(t) + Σ w_e o_e,     (M(edge, edge) + ν) w = M(edge, t)                                              (2)

Source: simple kriging (Cressie 1993, chapter 3).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...data.array_types import Floats
from ..marker_array import Gap
from .kriging import Hyper, matern


def edge_offsets(path: Floats, gap: Gap, xyz: Floats, learnt: Mapping[int, bool]) -> dict[int, Floats]:
    """(1) by the edge frame: (3) mm; 0 where the frame was learnt from. Frames that are not known are left out.

    Args:
        path: (F, 3) mm, the marker in the whole trial, NaN where missing.
        gap: of it.
        xyz: (L, 3) mm, its fill.
        learnt: whether each of the frames `start` − 1 and `stop` was learnt from.
    """
    out = {}
    for edge, inside, toward in ((gap.start - 1, xyz, 1), (gap.stop, xyz[::-1], -1)):
        if 0 <= edge < len(path) and np.isfinite(path[edge, 0]):
            out[edge] = np.zeros(3) if learnt[edge] else _offset(path, edge, toward, inside)
    return out


def _offset(path: Floats, edge: int, toward: int, inside: Floats) -> Floats:
    """(1); one step alone where the other is not known."""
    before = edge - toward
    steps = [path[edge] - path[before]] if 0 <= before < len(path) else []
    steps += [inside[1] - inside[0]] if len(inside) > 1 else []
    known = [step for step in steps if np.isfinite(step[0])]
    return path[edge] + (np.mean(known, axis=0) if known else 0.0) - inside[0]


def tied(xyz: Floats, gap: Gap, offsets: Mapping[int, Floats], *, rate: float, hyper: Hyper) -> Floats:
    """(2): the fill (L, 3) with its offsets taken off; as it is where there are none."""
    if not any(offset.any() for offset in offsets.values()):
        return xyz
    edges, frames = np.array(list(offsets), np.float64), np.arange(gap.start, gap.stop, dtype=np.float64)

    def M(one: Floats) -> Floats:
        return matern(np.abs(one[:, None] - edges) / (rate * hyper.ell), hyper.order)

    w = np.linalg.solve(M(edges) + hyper.nu * np.eye(len(edges)), M(frames).T)
    return xyz + w.T @ np.array(list(offsets.values()))
