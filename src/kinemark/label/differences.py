"""Which of two near markers is which: by how much nearer the one is to their neighbours than the other.

Where a posture or a subject is another, the distances of a neighbour c to two near labels a and b change alike. Their
difference Δ = d_ac − d_bc is |ab| times the cosine of the angle under which c is seen, so that it never is greater than
|ab| and changes little unless the two turn about each other. With Δ₀ = D_ac − D_bc of the template, an exchange of a
and b loses

    x = Σ_c ‹ max(−(Δ − Δ₀)² / 2σ², −2) − max(−(Δ + Δ₀)² / 2σ², −2) ›,   σ = min( √(σ_ac² + σ_bc²), |ab| / 2 )     (1)

over the nearest neighbours, in nats a frame.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats, Ints
from .evidence import PairScore, Single
from .template import Template

NEIGHBOURS = 12
"""c of (1); chosen: about the two segments that meet there."""
TURNED = 0.5
"""Greatest σ of (1) as a share of |ab|; chosen: a marker pair turns by some 30° against its neighbours."""
ONE_PLACE = 1e-9
"""Least σ of (1) as a share of the body's size; of two labels in one place no neighbour tells; chosen."""
FLOOR = -2.0
"""Of a neighbour that is off, nats; chosen."""


def losses(y: Single, pairs: PairScore, template: Template, twos: Ints) -> Floats:
    """(P) nats (1) that an exchange of two labels loses; infinite where the two are not seen together.

    Args:
        y: (K, L, 3) places of labels, mm, NaN where not seen. twos: (P, 2) labels that are exchanged.
    """
    a, b = twos[:, 0], twos[:, 1]
    near = _neighbours(template.distance, a, b)
    D, sigma = template.distance, np.where(pairs.inverse > 0, 1 / np.where(pairs.inverse > 0, pairs.inverse, 1), np.inf)
    wide = np.hypot(sigma[a[:, None], near], sigma[b[:, None], near])
    width = np.maximum(np.minimum(wide, TURNED * D[a, b][:, None]), ONE_PLACE * template.size)
    of_template = D[a[:, None], near] - D[b[:, None], near]
    total, frames = np.zeros(len(twos)), np.zeros(len(twos))
    for xyz in y.astype(float):
        d = np.linalg.norm(xyz[:, None] - xyz[None], axis=-1)
        off = d[a[:, None], near] - d[b[:, None], near]
        each = _nats((off - of_template) / width) - _nats((off + of_template) / width)
        total += np.where(np.isfinite(each), each, 0.0).sum(1)
        frames += np.isfinite(each).any(1)
    return np.asarray(np.where(frames > 0, total / np.maximum(frames, 1), np.inf))


def _nats(z: Floats) -> Floats:
    """One of the two terms of (1)."""
    return np.asarray(np.maximum(-0.5 * z * z, FLOOR))


def _neighbours(D: Floats, a: Ints, b: Ints) -> Ints:
    """(P, n) labels nearest to each two in the template."""
    apart = D[a] + D[b]
    apart[~np.isfinite(apart)] = np.inf
    apart[np.arange(len(a)), a] = apart[np.arange(len(b)), b] = np.inf
    return np.argsort(apart, axis=1, kind="stable")[:, : min(NEIGHBOURS, len(D) - 2)]
