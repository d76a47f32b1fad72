"""A template that has seen the trial: its own distances join those that were known before.

A distance with the mean D, the spread S and the doubt u is seen in the trial n independent times, with the mean d and
the spread s, in frames in which the template takes it for possible. Then

    1/u'² = 1/(u² + S²) + n/s²,   D' = u'² ( D/(u² + S²) + d n/s² ),   S'² = (n₀ S² + n s²) / (n₀ + n)           (1)

the posterior mean of a normal distribution, with the spread pooled; n₀ says how many times the template's is worth.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data.array_types import Floats
from ..numerics.evenly import evenly_rounded
from ..numerics.vectors import lengths
from .evidence import OF_SIZE, RELATIVE, WIDER, Single
from .stretches import GRID_HZ
from .template import Template

FRAMES = 150
"""In which the trial's distances are looked at; chosen: a mean and a spread need no more."""
PER_POSE = 0.5 * GRID_HZ
"""Frames of the grid that are one independent pose; chosen: half a second."""
WORTH = 3.0
"""n₀ of (1), poses; chosen."""
POSSIBLE = 3.0
"""σ within which a distance is what the template says; chosen."""
LEAST_SHARE = 0.6
"""Of a pair's frames that must be possible, or the pair stays as it was; chosen."""


def pooled(template: Template, y: Single) -> Template:
    """The template after the trial's labelled places y (K, L, 3)."""
    some = evenly_rounded(len(y), FRAMES)
    xyz = y[some]
    d = lengths(xyz[:, :, None] - xyz[:, None]).astype(float)
    D, S, doubt = template.distance, template.spread, np.asarray(template.doubt)
    floor = np.hypot(RELATIVE * np.nan_to_num(D), OF_SIZE * template.size)
    possible = np.abs(d - D) < POSSIBLE * np.sqrt((WIDER * S) ** 2 + doubt**2 + floor**2)
    seen = np.isfinite(d).sum(0)
    count = possible.sum(0)
    mean = np.where(possible, d, 0.0).sum(0) / np.maximum(count, 1)
    square = np.where(possible, (d - mean) ** 2, 0.0).sum(0) / np.maximum(count, 1)
    poses = count * (len(y) / len(some)) / PER_POSE
    told = np.isfinite(D) & (count > LEAST_SHARE * seen) & (poses >= 1) & ~np.eye(len(D), dtype=bool)
    return _joined(template, mean, square + (0.5 * floor) ** 2, np.where(told, poses, 0.0))


def _joined(template: Template, mean: Floats, square: Floats, n: Floats) -> Template:
    """(1); unchanged where n is 0."""
    D, S, doubt = template.distance, template.spread, np.asarray(template.doubt)
    before = doubt**2 + S**2 + np.spacing(1.0)
    precision = 1 / before + n / np.maximum(square, 1e-12)
    new = (D / before + mean * n / np.maximum(square, 1e-12)) / precision
    told = n > 0
    return replace(
        template,
        distance=np.where(told, new, D),
        spread=np.where(told, np.sqrt((WORTH * S**2 + n * square) / (WORTH + n)), S),
        doubt=np.where(told, np.sqrt(1 / precision), doubt),
    )
