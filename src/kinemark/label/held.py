"""Whether names form the body that the template tells of: a label's stiffest neighbours are where they should be.

On a body of something else each name lies where its few neighbours happen to suit it, mostly such as tell little; those
at a fixed distance are missing or off. Parts of the right body, such as the legs alone, have theirs.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from ..numerics.evenly import evenly_rounded
from .evidence import WIDER, PairScore, Single, distances
from .stretches import Stretches
from .sweeps import places

NEIGHBOURS = 3
"""Of each label, those whose distance is known best; chosen: as many as place it."""
WITHIN = 2.5
"""σ within which such a distance holds; chosen: one in a hundred is farther off."""
FRAMES = 40
"""In which this is looked at; chosen."""
STIFFEST = 4
"""Of each label, those by which its own probability is told; chosen."""
USUAL = (1 + 1 / WIDER**2) ** -0.5
"""Mean of exp(−z²/2) of distances as the template has them, whose spread is σ / 1.3; by definition."""
LEAST = 0.65
"""Below which a template is of something else; chosen: right ones hold 0.80 to 1, also with four markers absent, in a
new posture, or of another subject; of 30 pairs of different marker sets one holds more than 0.64, that of 7 markers."""


OWN = 0.8
"""Share of the stiffest distances between markers that are there, below which a template is of another subject, or most
names are wrong; measured on walks of four children, 33 markers and more, and on 21 simulated trials of six marker sets:
by a template of the same subject 0.97 to 1, also in postures that it does not show, of another one 0.1 to 0.76 (0.8 to
0.94 where markers sit alike)."""


def held(stretches: Stretches, label: Ints, pairs: PairScore, *, absent_too: bool = True) -> float:
    """The share of the stiffest distances of all that has a label which hold, 0 for those to labels that are absent.

    Absent is what is so all through the trial: what is hidden for a while, as from few cameras, tells nothing.

    Args:
        label: (T) −1 for none. absent_too: else those to labels that are absent tell nothing either.
    """
    near = _stiffest(pairs.inverse, NEIGHBOURS)
    y = places(stretches, label, len(pairs.distance))
    absent = ~np.isfinite(y[..., 0]).any(0) & absent_too
    holds = total = 0
    for k in evenly_rounded(len(y), FRAMES):
        off = np.abs(distances(y[k], y[k]) - pairs.distance) * pairs.inverse
        own = np.isfinite(y[k, :, 0])
        holds += int((np.take_along_axis(off, near, axis=1)[own] < WITHIN).sum())
        total += int((own | absent)[near[own]].sum())
    return holds / max(total, 1)


def stiffness_kept(y: Single, pairs: PairScore, keeps: Bools) -> tuple[Floats, Floats]:
    """(L) how well each label's stiffest distances hold, from 0 to 1: mean of exp(−z²/2) with z in σ; 0 where absent.

    And (L) by how many of them that tell, in the mean of the frames in which any does.

    Where fewer than four distances of a label keep, others take their places. These tell nothing, as those of feet that
    stood close together and walk apart, and count as what distances that hold have in the mean, where one that tells is
    seen at all. Where none keeps, the four that are known best are taken.

    Args:
        y: (K, L, 3) places of labels, mm, NaN where not seen. keeps: (L, L) of the template.
    """
    inverse = np.where(keeps | ~keeps.any(1, keepdims=True), pairs.inverse, 0.0)
    near = _stiffest(inverse, STIFFEST)
    tells = np.take_along_axis(inverse > 0, near, axis=1)
    total, count, proofs, frames = (np.zeros(len(near)) for _ in range(4))
    for xyz in y:
        off = np.take_along_axis((distances(xyz, xyz) - pairs.distance) * pairs.inverse, near, axis=1)
        there = np.isfinite(off) & tells
        seen = there | ~tells & there.any(1, keepdims=True)
        holds = np.where(tells, np.exp(-0.5 * np.where(seen, off, 0.0) ** 2), USUAL)
        total += np.where(seen, holds, 0.0).sum(1)
        count += seen.sum(1)
        proofs += there.sum(1)
        frames += there.any(1)
    return total / np.maximum(count, 1), proofs / np.maximum(frames, 1)


def _stiffest(inverse: Floats | Single, n: int) -> Ints:
    """(L, n) of each label, the others whose distance is known best; inverse (L, L) 1/σ, 0 where nothing is known."""
    sigma = np.where(inverse > 0, 1 / np.where(inverse > 0, inverse, 1.0), np.inf)
    return np.argsort(sigma, axis=1, kind="stable")[:, : min(n, len(sigma) - 1)]
