"""Ghosts: paths that are no marker, as images of several markers, or of none, make them where rays meet by chance.

They are short, rough and seen by few cameras, and their standard uncertainty is great: rays that meet by chance meet
under small angles, and far from all cameras, as often as not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data import Trajectories
from ...data.array_types import Floats
from ...data.edits import is_named
from .paths import Paths
from .probability import probability


class GhostEvidence(NamedTuple):
    """What tells of a ghost.

    Attributes:
        seconds: ln of how long the path is seen, s. images: of a sample in the mean, 0 where unknown.
        rough: ln(1 + roughness), roughness being the noise of the path over that of the trial.
        stated: ln of the standard uncertainty of an axis, mm, the median of its samples; 0 where none is stated.
    """

    seconds: float
    images: float
    rough: float
    stated: float


class Ghost(NamedTuple):
    """A path without a name, and how likely it is no marker."""

    path: int
    first: int
    last: int
    evidence: GhostEvidence
    wrong: float


def ghosts(paths: Paths, trajectories: Trajectories) -> list[Ghost]:
    """All paths without a marker's name that have samples."""
    usual = float(np.median(paths.sd)) if len(paths.sd) else 1.0
    found = []
    for p, path in enumerate(trajectories):
        own = paths.frames[p]
        if is_named(path.name) or not len(own):
            continue
        images = float((path.detection[own] >= 0).sum(1).mean()) if path.detection.shape[1] else 0.0
        evidence = GhostEvidence(
            float(np.log(len(own) / paths.rate)), images, float(np.log1p(paths.sd[p] / usual)), _stated(path.cov[own])
        )
        found.append(Ghost(p, int(own[0]), int(own[-1]), evidence, probability("ghost", evidence)))
    return found


def _stated(cov: Floats) -> float:
    """`GhostEvidence.stated` of samples with these covariances (n, 3, 3) mm²."""
    variance = np.trace(cov, axis1=1, axis2=2) / 3
    variance = variance[np.isfinite(variance) & (variance > 0)]
    return float(np.log(np.median(variance)) / 2) if len(variance) else 0.0
