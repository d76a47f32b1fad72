"""Ghosts: paths that are no marker, as images of several markers, or of none, make them where rays meet by chance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data import Trajectories
from ...data.edits import is_named
from .paths import Paths
from .probability import probability


class GhostEvidence(NamedTuple):
    """ln of the samples' number; images of a sample in the mean, 0 where unknown; ln(1 + roughness), roughness being
    the noise of the path over that of the trial."""

    samples: float
    images: float
    rough: float


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
        evidence = GhostEvidence(float(np.log(len(own))), images, float(np.log1p(paths.sd[p] / usual)))
        found.append(Ghost(p, int(own[0]), int(own[-1]), evidence, probability("ghost", evidence)))
    return found
