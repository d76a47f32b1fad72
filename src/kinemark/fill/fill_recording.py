"""Filling a recording of our own, whose 2D images are at hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..data import MarkerTrajectory, Origin, Trajectories
from ..data.edits import GapChoice
from ..data.fills import detection_columns
from ..data.method import Method, parameter
from .fill import fill
from .filled_gap import Filled, FilledGap
from .judge.auto import Auto
from .rays import Rays, sharpened

STATIC = "static"
"""Method of gaps that a static trial filled."""


@dataclass(frozen=True, slots=True)
class Filling(Method):
    """How the gaps of a recording are filled: by which method, and what goes for all methods.

    Attributes:
        method: one of the stage's methods. name: of it.
    """

    method: Any = field(default_factory=Auto)
    name: str = "auto"
    limit_mm: float | None = parameter(
        None, unit="mm", above=0,
        meaning="gaps whose expected mean error is greater stay open; None: 20, less on what is smaller than a person",
    )  # fmt: skip
    ends: bool = parameter(False, meaning="also fill before a marker's first sample and after its last")
    trim: int = parameter(
        0, unit="samples", low=0,
        meaning="so many suspicious samples may be replaced on each side of a gap; 0: they are listed and kept",
    )  # fmt: skip
    rays: bool = parameter(True, meaning="use images that one camera alone has of a marker in its gap")


def fill_recording(
    trajectories: Trajectories, rays: Rays, *, method: Filling, static: Trajectories | None = None,
    choices: Sequence[GapChoice] = (),
) -> Filled:  # fmt: skip
    """The trial with its gaps filled, also by the images that single cameras have in them.

    The expected error of a gap is that of the method without the cameras' help, as no hold-out gap has one. Markers of
    the static trial that this one never shows are placed from it, as `fill` does. `choices` are how somebody wants
    single gaps filled.
    """
    filled = fill(
        trajectories,
        method=method.method,
        limit_mm=method.limit_mm,
        ends=method.ends,
        trim=method.trim,
        static=static,
        choices=choices,
    )
    if not method.rays:
        return filled
    paths = {path.name: path for path in filled.trajectories}
    for gap in filled.gaps:
        if gap.method and gap.method != STATIC:
            paths[gap.marker] = _expected_errors(paths[gap.marker], gap, rays)
    return Filled(replace(filled.trajectories, paths=tuple(paths.values())), filled.gaps)


def _expected_errors(path: MarkerTrajectory, gap: FilledGap, rays: Rays) -> MarkerTrajectory:
    """A marker with what single cameras say of one gap."""
    at = slice(gap.start, gap.stop)
    found = sharpened(path.xyz[at], path.cov[at], gap.start, rays)
    seen = (found.detection >= 0).any(1)
    if not seen.any():
        return path
    own = (path.origin[at] == Origin.FILLED) & seen
    xyz, cov, detection = np.array(path.xyz), np.array(path.cov), detection_columns(path, found.detection.shape[1])
    xyz[at][own], cov[at][own], detection[at][own] = found.xyz[own], found.cov[own], found.detection[own]
    return replace(path, xyz=xyz, cov=cov, detection=detection)
