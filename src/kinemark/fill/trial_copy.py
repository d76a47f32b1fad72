"""The trial that is filled: marker trajectories are copied when they are first written into."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..data import Origin, Trajectories
from ..data.array_types import Bools, Floats
from .marker_array import Gap


class TrialCopy:
    """Copies of the paths that gaps are written into; others are shared with the trial."""

    def __init__(self, trajectories: Trajectories) -> None:
        self.source = trajectories
        self.changed: dict[int, dict[str, Any]] = {}

    def measured(self, gap: Gap) -> tuple[int, ...]:
        """Frames of a gap in which the trial has a sample."""
        origin = self.source.paths[gap.marker].origin[gap.start : gap.stop]
        return tuple(int(f) for f in gap.start + np.flatnonzero(origin != Origin.MISSING))

    def of(self, marker: int) -> dict[str, Any]:
        """The columns of a marker, copied when they are first asked for."""
        names = ("xyz", "cov", "origin", "residual", "cameras", "detection")
        path = self.source.paths[marker]
        return self.changed.setdefault(marker, {name: getattr(path, name).copy() for name in names})

    def drop(self, missing: Bools) -> None:
        """Make samples (M, F) missing that are no positions, whether their gap is filled or stays open."""
        for marker, path in enumerate(self.source.paths):
            outliers = missing[marker] & (path.origin != Origin.MISSING)
            if outliers.any():
                into = self.of(marker)
                into["xyz"][outliers] = into["cov"][outliers] = into["residual"][outliers] = np.nan
                into["origin"][outliers], into["cameras"][outliers], into["detection"][outliers] = Origin.MISSING, 0, -1

    def put(self, gap: Gap, xyz: Floats, cov: Floats) -> None:
        """Fill a gap."""
        into, at = self.of(gap.marker), slice(gap.start, gap.stop)
        into["xyz"][at], into["cov"][at] = xyz, cov
        into["origin"][at], into["residual"][at] = Origin.FILLED, np.nan
        into["cameras"][at], into["detection"][at] = 0, -1

    def trajectories(self) -> Trajectories:
        """The trial with all that was put."""
        paths = [
            replace(path, **self.changed[k]) if k in self.changed else path for k, path in enumerate(self.source.paths)
        ]
        return replace(self.source, paths=tuple(paths))
