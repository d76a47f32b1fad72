"""What a calibration was made from and how well that fits it: all that a judgement of it needs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ...data import Finding, Rig
from ...data.array_types import Bools, Floats
from ..control_points.judgement import Judgement
from .world_pose import WorldPose

FALLBACK_SD = 0.2
"""px; a centroid's, where a calibration says nothing of its residuals; chosen (see studies/calibration_quality.py)."""
LEAST_SD = 0.01
"""px; no camera model is truer than this; chosen (see studies/calibration_quality.py)."""


def _none(*shape: int) -> Floats:
    return np.full(shape, np.nan)


class Check(NamedTuple):
    """A length that took no part in the calibration: what it is, mm as known and as found."""

    what: str
    known: float
    found: float


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Of C cameras and N points; empty where a calibration came as a file.

    Attributes:
        way: how it was made, in words.
        names: (N) of the points, or none.
        xyz: (N, 3) mm, in the world of the rig.
        uv: (C, N, 2) px where they were seen; NaN where not.
        residual: (C, N, 2) px seen minus reprojected.
        kept: (C, N) which took part in the fit.
        left_out: (C, N) px error of each image when its point, or its fold of points, took no part; NaN where unknown.
        left_out_mm: (N) how far a point lies from where it was surveyed when it took no part; NaN where unknown.
        known: (L) lengths on the wand, mm; lengths: (F, L) as poses that took no part give them, mm; place: (F, 3) mm.
        halves: (2) by how many times squares of residuals of each half of the frames are less with its own cameras.
        checks: lengths that took no part.
        joint: (15 C, 15 C) covariance of all cameras together, or None where each was calibrated by itself.
        world: the error of the room, where points at known places gave it afterwards; it is not in `joint`.
        freedom: equations more than parameters, over all cameras; 0 where unknown.
        straight: name, and px RMS by which rows of the linearisation grid are bent before and after, of each camera.
        judged: whether it is good and why not, where the way has a judgement of its own.
        findings: what contradicted itself while it was made.
        surveyed: whether the points were measured in the laboratory, or came out of the calibration.
    """

    way: str
    names: tuple[str, ...] = ()
    xyz: Floats = field(default_factory=lambda: _none(0, 3))
    uv: Floats = field(default_factory=lambda: _none(0, 0, 2))
    residual: Floats = field(default_factory=lambda: _none(0, 0, 2))
    kept: Bools = field(default_factory=lambda: np.zeros((0, 0), np.bool_))
    left_out: Floats = field(default_factory=lambda: _none(0, 0))
    left_out_mm: Floats = field(default_factory=lambda: _none(0))
    known: Floats = field(default_factory=lambda: _none(0))
    lengths: Floats = field(default_factory=lambda: _none(0, 0))
    place: Floats = field(default_factory=lambda: _none(0, 3))
    halves: Floats = field(default_factory=lambda: _none(2))
    checks: tuple[Check, ...] = ()
    joint: Floats | None = None
    world: WorldPose | None = None
    freedom: int = 0
    straight: tuple[tuple[str, float, float], ...] = ()
    judged: Judgement | None = None
    findings: tuple[Finding, ...] = ()
    surveyed: bool = True


def centroid_deviation(rig: Rig, evidence: Evidence) -> float:
    """Standard deviation of a centroid along one axis, px, as the calibration's residuals show it.

    Residuals are smaller than errors, since parameters were fitted to them: with n coordinates and ν degrees of freedom
    s² = Σ r² / ν. Without residuals the rig's own count, and without those a usual value stands.
    """
    used = evidence.residual[evidence.kept]
    if len(used):
        return residual_deviation(used, evidence.freedom)
    stated = np.array([camera.residual for camera in rig])
    stated = stated[np.isfinite(stated)]
    return max(float(np.sqrt((stated**2).mean() / 2)), LEAST_SD) if len(stated) else FALLBACK_SD


def residual_deviation(used: Floats, freedom: int) -> float:
    """s of residuals (n, 2) px that took part in a fit with ν degrees of freedom, px, at least `LEAST_SD`."""
    n = used.size
    return max(float(np.sqrt((used**2).sum() / (freedom if 0 < freedom <= n else n))), LEAST_SD)
